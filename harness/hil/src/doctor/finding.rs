//! A finding of the doctor.

use serde::Serialize;

/// Status of a subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Good,
    /// No given bench or plan needs it.
    Optional,
    /// A given bench or plan needs it, and it is not as it must be.
    Missing,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Subject, in a word or two.
    pub subject: String,
    pub status: Status,
    /// The fact, as text.
    pub what: String,
    /// How to fix it, as shell lines: commands, and comments where no command does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mend: Option<String>,
    /// What needs it, if it is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needed_by: Option<String>,
}

impl Finding {
    pub fn good(subject: impl Into<String>, what: impl Into<String>) -> Self {
        let (subject, what) = (subject.into(), what.into());
        Self { subject, status: Status::Good, what, mend: None, needed_by: None }
    }

    /// Optional; missing if something needs it.
    pub fn gap(
        subject: impl Into<String>,
        what: impl Into<String>,
        mend: impl Into<String>,
        needed_by: Option<String>,
    ) -> Self {
        let status = if needed_by.is_some() { Status::Missing } else { Status::Optional };
        let (subject, what, mend) = (subject.into(), what.into(), Some(mend.into()));
        Self { subject, status, what, mend, needed_by }
    }

    /// A port that is not there, and that the `setup` of a bench may create.
    pub(super) fn set_up_later(port: &str, bench: &str) -> Self {
        let what = format!("not there yet: the `setup` of {bench} may create it");
        Self::gap(port, what, "# its ports are opened after the commands of `setup`", None)
    }
}

/// Returns `a, b`; `None` if there are no names.
pub(super) fn joined<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let names: Vec<&str> = names.into_iter().collect();
    (!names.is_empty()).then(|| names.join(", "))
}
