//! Why a trial cannot be carried out at all.

use crate::campaign::{JournalError, RegressionError};
use crate::run::{PrepareError, RerunError};
use crate::run_folder::RunFolderError;
use miette::Diagnostic;
use std::{fmt, io};

/// Why a trial cannot be carried out. As a test that ends in an error prints it (`Debug`), it shows the place in the
/// file and says what to do.
#[derive(thiserror::Error, Diagnostic)]
pub enum TrialError {
    /// The plan, or what it names, cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Prepare(#[from] PrepareError),
    /// The run folder cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// A run cannot be carried out again on its record.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rerun(#[from] RerunError),
    /// There is no room for what a run leaves behind.
    #[error("failed to make a temporary folder in {}", std::env::temp_dir().display())]
    #[diagnostic(help("say where with `in_folder`, or set TMPDIR"))]
    Temporary(#[source] io::Error),
    /// What was done of a campaign cannot be kept.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Journal(#[from] JournalError),
    /// A case cannot be saved as a plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Regression(#[from] RegressionError),
    /// A campaign would find only what is broken already.
    #[error("{plan}: breaks {property} without any fault, at {at_s:.3} s: {what}")]
    #[diagnostic(help("`run` the trial first, and assert that it passes"))]
    Broken {
        /// Name of the plan.
        plan: String,
        /// The property.
        property: String,
        /// Bench time, s.
        at_s: f64,
        /// What was seen.
        what: String,
    },
    /// A campaign would judge what never comes to its end.
    #[error("{plan}: ends in {outcome} without any fault")]
    #[diagnostic(help("`run` the trial first, and assert that it passes"))]
    Unfinished {
        /// Name of the plan.
        plan: String,
        /// How its run ended.
        outcome: String,
    },
    /// No fault of those that were asked for can happen there.
    #[error("{plan}: none of these faults can strike its bench")]
    #[diagnostic(help("`hil list faults` says what each strikes"))]
    NothingToStrike {
        /// Name of the plan.
        plan: String,
    },
    /// There is no fault of that name.
    #[error("no fault is called \"{name}\"")]
    #[diagnostic(help("`hil list faults` names all"))]
    UnknownFault {
        /// What was asked for.
        name: String,
    },
}

/// With its place in the file and what to do, in plain ASCII.
impl fmt::Debug for TrialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\n")?;
        shown(f, self)
    }
}

#[cfg(feature = "fancy")]
fn shown(f: &mut fmt::Formatter<'_>, error: &TrialError) -> fmt::Result {
    use miette::{GraphicalReportHandler, GraphicalTheme};
    /// Columns of a message, as of those of `hil`.
    const WIDTH: usize = 100;
    let theme = GraphicalTheme::none();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(WIDTH).with_links(false);
    handler.render_report(f, error)
}

#[cfg(not(feature = "fancy"))]
fn shown(f: &mut fmt::Formatter<'_>, error: &TrialError) -> fmt::Result {
    miette::NarratableReportHandler::new().render_report(f, error)
}
