//! What is wrong in a plan, and where.

/// A step down into the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Segment {
    /// Into the value of this key.
    Key(&'static str),
    /// Into this element.
    Index(usize),
}

/// Something wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) path: Vec<Segment>,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

/// Where something stands.
pub(super) struct Place<'a> {
    pub(super) root: &'a [Segment],
}

impl Place<'_> {
    pub(super) fn fault(&self, rest: &[Segment], message: String, help: Option<String>) -> Fault {
        Fault { path: [self.root, rest].concat(), message, help }
    }
}
