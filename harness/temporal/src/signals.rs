//! Resolution of the signals of a formula by the caller.

use crate::mistake::Mistake;
use std::ops::Range;

pub trait Signals {
    /// Finds the signal with this name: `node.Message.Signal`, `node.Signal` or `Signal`, in the caller's notation.
    ///
    /// # Errors
    ///
    /// If there is no such signal. [`NotFound::unknown`] and [`NotFound::ambiguous`] word it like other mistakes.
    fn find(&self, name: &str) -> Result<Signal, NotFound>;

    /// A number that is 1 while this counter or checksum of protected messages is right, and 0 otherwise.
    ///
    /// # Errors
    ///
    /// If the signal is unknown, or does not protect its message in this way.
    fn protecting(&self, name: &str, how: Protecting) -> Result<Signal, NotFound> {
        self.find(name)?;
        let what = how.word();
        Err(NotFound { message: format!("nothing says how `{name}` {what}"), help: None })
    }

    /// A number that counts the messages with this name: `node.Message`, or `Message` if only one node sends one.
    ///
    /// # Errors
    ///
    /// If there is no such message.
    fn message(&self, name: &str) -> Result<Signal, NotFound> {
        Err(NotFound { message: format!("no message `{name}`"), help: None })
    }
}

wire::tabled! {
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Protecting {
        /// A counter that continues the previous one.
        Follows = "follows",
        /// A checksum that matches its message.
        Fits = "fits",
    }
    pub fn word() -> &'static str
}

/// The properties of a signal that a formula needs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Signal {
    /// The caller's number for it, used in updates.
    pub index: usize,
    /// Its unit, such as `V`, `degC` or `km/h`; empty if it is a plain number.
    pub unit: String,
    /// Named values, as in the value table of a DBC.
    pub names: Vec<(String, f64)>,
    /// Its smallest and largest possible value, if known; robustness is a share of the range.
    pub range: Option<(f64, f64)>,
    /// The difference of two neighbouring values; zero if it is a real number, or unknown.
    pub step: f64,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotFound {
    pub message: String,
    pub help: Option<String>,
}

impl NotFound {
    /// The mistake of the name at this place of a formula.
    pub(crate) fn at(self, at: Range<usize>) -> Mistake {
        Mistake { at, message: self.message, help: self.help }
    }

    /// No signal is named `name`; the help proposes the nearest of `known`.
    pub fn unknown<S: AsRef<str>>(name: &str, known: &[S]) -> Self {
        Self { message: format!("no signal `{name}`"), help: Some(proposal(name, known)) }
    }

    /// `name` may mean any of `candidates`, given as full names.
    pub fn ambiguous<S: AsRef<str>>(name: &str, candidates: &[S]) -> Self {
        let help = format!("write {}", listed(candidates, " or "));
        Self { message: format!("`{name}` may be several signals"), help: Some(help) }
    }
}

/// Minimum similarity (Jaro-Winkler, 0 to 1) for proposing a name. Assumption: one or two typing errors are above it, a
/// different word is below.
const LIKENESS_MIN: f64 = 0.8;

/// Number of names listed if none is similar; a bus has hundreds.
const LISTED_MAX: usize = 8;

/// "did you mean ...?" if a name is similar, otherwise the list of known names.
pub(crate) fn proposal<S: AsRef<str>>(wrong: &str, known: &[S]) -> String {
    // As the quantity of a measurement is written: `signal.Temperature`.
    let is_end =
        |name: &&S| wrong.strip_suffix(name.as_ref()).is_some_and(|front| front.ends_with('.'));
    if let Some(name) = known.iter().find(is_end) {
        return format!("write `{}`", name.as_ref());
    }
    let folded = wrong.to_lowercase();
    let mut best = (LIKENESS_MIN, None);
    for name in known {
        let likeness = strsim::jaro_winkler(&folded, &name.as_ref().to_lowercase());
        if likeness > best.0 {
            best = (likeness, Some(name.as_ref()));
        }
    }
    match best.1 {
        Some(name) => format!("did you mean `{name}`?"),
        None if known.is_empty() => "no name is known here".to_owned(),
        None => format!("known here: {}", listed(known, ", ")),
    }
}

fn listed<S: AsRef<str>>(names: &[S], between: &str) -> String {
    let some: Vec<_> =
        names.iter().take(LISTED_MAX).map(|name| format!("`{}`", name.as_ref())).collect();
    match names.len().saturating_sub(LISTED_MAX) {
        0 => some.join(between),
        more => format!("{} and {more} more", some.join(between)),
    }
}
