//! Mistakes in a plan, and their places in it.

use std::ops::Range;

/// One level of a path in the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Segment {
    /// The value of this key.
    Key(&'static str),
    /// The key of this name and its value: a name that the file chooses.
    Entry(String),
    /// The element with this index.
    Index(usize),
    /// These bytes of a text.
    Text(Range<usize>),
}

/// A mistake and its place.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) path: Vec<Segment>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

pub(super) type Checked = Result<(), Fault>;

/// A place in the document.
pub(super) struct Place<'a> {
    pub(super) root: &'a [Segment],
}

impl Place<'_> {
    pub(super) fn fault(&self, rest: &[Segment], message: String, help: Option<String>) -> Fault {
        Fault { path: [self.root, rest].concat(), message, help }
    }
}
