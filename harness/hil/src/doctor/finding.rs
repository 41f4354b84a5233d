//! One thing that was found.

use serde::Serialize;

/// How things stand with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// As it should be.
    Good,
    /// Not as it could be, and nothing given needs it.
    Gap,
    /// Not as it must be for what is given.
    Lacking,
}

impl Status {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Gap => "gap",
            Self::Lacking => "lacking",
        }
    }
}

/// One thing that was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What it is about, in a word or two.
    pub subject: String,
    /// How things stand with it.
    pub status: Status,
    /// What was found.
    pub what: String,
    /// What mends it, as lines of a shell: commands, and comments where no command does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mend: Option<String>,
    /// Who needs it, where it lacks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needed_by: Option<String>,
}

impl Finding {
    /// All is well.
    pub fn good(subject: impl Into<String>, what: impl Into<String>) -> Self {
        let (subject, what) = (subject.into(), what.into());
        Self { subject, status: Status::Good, what, mend: None, needed_by: None }
    }

    /// A gap; lacking where somebody needs it.
    pub fn gap(
        subject: impl Into<String>,
        what: impl Into<String>,
        mend: impl Into<String>,
        needed_by: Option<String>,
    ) -> Self {
        let status = if needed_by.is_some() { Status::Lacking } else { Status::Gap };
        let (subject, what, mend) = (subject.into(), what.into(), Some(mend.into()));
        Self { subject, status, what, mend, needed_by }
    }
}

/// `a, b`; none where there are none.
pub(super) fn joined<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let names: Vec<&str> = names.into_iter().collect();
    (!names.is_empty()).then(|| names.join(", "))
}
