//! Why a trial cannot be carried out at all.

use crate::campaign::{JournalError, RegressionError};
use crate::run::{PrepareError, RerunError};
use crate::run_folder::RunFolderError;
use miette::Diagnostic;
use std::{fmt, io};

/// Why a trial cannot be carried out. Its `Debug` output, which a failing test prints, shows the place in the file and
/// how to fix it.
#[derive(thiserror::Error, Diagnostic)]
pub enum TrialError {
    /// The plan, or a file that it names, is unusable.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Prepare(#[from] PrepareError),
    /// The run folder cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Folder(#[from] RunFolderError),
    /// A recorded run cannot be repeated.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rerun(#[from] RerunError),
    /// Rust code for a node that the rig does not have under test.
    #[error("the rig of {plan} has no node `{node}` under test")]
    #[diagnostic(help("{help}"))]
    NoSuchNode {
        /// Name of the plan.
        plan: String,
        /// The name given to `with_node`.
        node: String,
        /// What to do.
        help: String,
    },
    /// A record of another plan.
    #[error("the record is of the plan {recorded}, and the trial of {plan}")]
    #[diagnostic(help(
        "rerun it with the trial of that plan: what a plan does to the devices is not in the record"
    ))]
    OtherPlan {
        /// Name of the plan of the trial.
        plan: String,
        /// Name of that of the record.
        recorded: String,
    },
    /// There is no room for a temporary folder.
    #[error("failed to make a temporary folder in {}", std::env::temp_dir().display())]
    #[diagnostic(help("say where with `in_folder`, or set TMPDIR"))]
    Temporary(#[source] io::Error),
    /// The journal of a campaign cannot be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Journal(#[from] JournalError),
    /// A case cannot be saved as a plan.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Regression(#[from] RegressionError),
    /// A property breaks without any fault, so a campaign would find nothing new.
    #[error("{plan}: breaks {property} without any fault, at {at_s:.3} s: {what}")]
    #[diagnostic(help("`run` the trial first, and assert that it passes"))]
    Broken {
        /// Name of the plan.
        plan: String,
        /// The property.
        property: String,
        /// Bench time, s.
        at_s: f64,
        /// The violation.
        what: String,
    },
    /// A property has nothing to judge without any fault, so a campaign would show nothing about it.
    #[error("{plan}: never judges {property}, without any fault: {why}")]
    #[diagnostic(help("`run` the trial first, and assert that it passes"))]
    NeverJudged {
        /// Name of the plan.
        plan: String,
        /// The property.
        property: String,
        /// What is missing.
        why: String,
    },
    /// The plan does not end properly without any fault, so a campaign could not judge it.
    #[error("{plan}: ends in {outcome} without any fault")]
    #[diagnostic(help("`run` the trial first, and assert that it passes"))]
    Unfinished {
        /// Name of the plan.
        plan: String,
        /// How its run ended.
        outcome: String,
    },
    /// None of the requested faults can strike the bench.
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
        /// The requested name.
        name: String,
    },
}

/// Shows the place in the file and the help text, in plain ASCII.
impl fmt::Debug for TrialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\n")?;
        shown(f, self)
    }
}

#[cfg(feature = "fancy")]
fn shown(f: &mut fmt::Formatter<'_>, error: &TrialError) -> fmt::Result {
    use miette::{GraphicalReportHandler, GraphicalTheme};
    /// Width of a message, as in `hil`.
    const WIDTH: usize = 100;
    let theme = GraphicalTheme::none();
    let handler = GraphicalReportHandler::new_themed(theme).with_width(WIDTH).with_links(false);
    handler.render_report(f, error)
}

#[cfg(not(feature = "fancy"))]
fn shown(f: &mut fmt::Formatter<'_>, error: &TrialError) -> fmt::Result {
    miette::NarratableReportHandler::new().render_report(f, error)
}
