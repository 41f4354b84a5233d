//! Where a formula finds its signals: the caller knows them.

/// The signals that a formula may name.
pub trait Signals {
    /// The signal of this name: `node.Message.Signal`, `node.Signal` or `Signal`, as the caller likes.
    ///
    /// # Errors
    ///
    /// Why there is none. [`NotFound::unknown`] and [`NotFound::ambiguous`] say it as other mistakes do.
    fn find(&self, name: &str) -> Result<Signal, NotFound>;

    /// A number that is 1 while this signal of protected messages is right, and 0 while it is not.
    ///
    /// # Errors
    ///
    /// Why there is none: the signal is unknown, or protects nothing in this way.
    fn protecting(&self, name: &str, how: Protecting) -> Result<Signal, NotFound> {
        self.find(name)?;
        let what = how.word();
        Err(NotFound { message: format!("nothing says how `{name}` {what}"), help: None })
    }
}

/// How a signal protects its message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protecting {
    /// It is a counter, that follows the one before.
    Follows,
    /// It is a checksum, that fits its message.
    Fits,
}

impl Protecting {
    /// As a formula has it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Follows => "follows",
            Self::Fits => "fits",
        }
    }
}

/// What a formula must know of a signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Signal {
    /// The caller's number for it; updates name it so.
    pub index: usize,
    /// Its unit, such as `V`, `degC` or `km/h`; empty if it is a plain number.
    pub unit: String,
    /// Values that have a name, as the value table of a DBC gives them.
    pub names: Vec<(String, f64)>,
    /// The least and the greatest value that it can have, if that is known: a robustness is a share of that.
    pub range: Option<(f64, f64)>,
}

/// Why a name is no signal's.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NotFound {
    /// What is wrong.
    pub message: String,
    /// What to write instead.
    pub help: Option<String>,
}

impl NotFound {
    /// There is no signal `name`; the help proposes the nearest of `known`.
    pub fn unknown<S: AsRef<str>>(name: &str, known: &[S]) -> Self {
        Self { message: format!("no signal `{name}`"), help: Some(proposal(name, known)) }
    }

    /// `name` may be any of `candidates`, which are written in full.
    pub fn ambiguous<S: AsRef<str>>(name: &str, candidates: &[S]) -> Self {
        let help = format!("write {}", listed(candidates, " or "));
        Self { message: format!("`{name}` may be several signals"), help: Some(help) }
    }
}

/// Likeness (Jaro-Winkler, 0 to 1) from which on a name is proposed. Assumption: one or two slips of the
/// finger are above it, another word is below.
const LIKENESS_MIN: f64 = 0.8;

/// So many names are listed where none is near; a bus has hundreds.
const LISTED_MAX: usize = 8;

/// "did you mean ...?" where a name is near, and else those that are known.
pub(crate) fn proposal<S: AsRef<str>>(wrong: &str, known: &[S]) -> String {
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
        None if known.is_empty() => "nothing is known here".to_owned(),
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
