//! Plans one after another: what one makes, the later ones use.

use super::build_server::{Annotation, SummaryArguments};
use super::crossing;
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::live;
use super::progress::Screen;
use super::say;
use super::setup::Setup;
use super::stopwatch::Stopwatch;
use super::terminal::Terminal;
use crate::calibrations;
use crate::console::{self, Style};
use crate::made::Made;
use crate::operator::Answers;
use crate::outcome::{Outcome, Summary};
use crate::record::sink::Level;
use crate::run::{Completed, Options, Prepared, run_to_folder};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Where run folders go, unless said otherwise.
pub(super) const RUNS: &str = "runs";

/// Where run folders go.
#[derive(Debug, Clone)]
pub(super) enum Out {
    /// This is the run folder.
    Folder(PathBuf),
    /// Each plan has its own in here.
    Parent(PathBuf),
}

impl Out {
    fn folder(&self, plan: &str, seed: u64) -> PathBuf {
        match self {
            Self::Folder(path) => path.clone(),
            Self::Parent(path) => path.join(format!("{plan}-seed{seed}")),
        }
    }
}

/// Plans to be run in order.
#[derive(Debug)]
pub(super) struct Series<'a> {
    /// Names or paths.
    pub(super) plans: &'a [&'a str],
    pub(super) setup: &'a Setup,
    pub(super) seed: u64,
    pub(super) out: Out,
    pub(super) level: Level,
    pub(super) answers: Answers,
    /// Whoever can be asked for the others.
    pub(super) person: Option<Terminal>,
    pub(super) summary: SummaryArguments,
}

/// Reads and checks all of them before anything runs, so that a slip in the last plan does not cost
/// the hours of the others. A calibration that an earlier plan makes is taken for granted.
///
/// # Errors
///
/// The first plan that cannot be prepared, or two of the same name: they would share a run folder.
pub(super) fn prepare_all(plans: &[&str]) -> Result<Vec<Prepared>, Failure> {
    let mut promised = Made::default();
    let mut prepared: Vec<Prepared> = Vec::new();
    for name in plans {
        let next = Prepared::load(name, &promised)?;
        if prepared.iter().any(|earlier| earlier.plan.name == next.plan.name) {
            return Err(Failure::arguments(
                format!("two of the plans are called {}", next.plan.name),
                "the second would replace the run of the first; run them one at a time",
            ));
        }
        promised.promise(&next.plan);
        prepared.push(next);
    }
    Ok(prepared)
}

impl Series<'_> {
    /// Runs them, prints the table, and gives the worst outcome. A failed plan does not stop the later
    /// ones; an interrupt does.
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let interrupt = Interrupt::install(screen)?;
        let mut summaries = Vec::new();
        let done = self.run_all(screen, &interrupt, &mut summaries);
        // What was measured before something went wrong is shown in any case.
        if done.is_ok() || !summaries.is_empty() {
            say(&console::measurements_table(&summaries, Style::of_stdout()))?;
            self.summary.append(&console::runs_markdown(&summaries))?;
        }
        done.map(|()| console::worst(&summaries))
    }

    fn run_all(
        &self,
        screen: &Screen,
        interrupt: &Interrupt,
        summaries: &mut Vec<Summary>,
    ) -> Result<(), Failure> {
        let mut made = Made::default();
        let mut promised = BTreeSet::new();
        for (index, name) in self.plans.iter().enumerate() {
            let prepared = Prepared::load(name, &made)?;
            for calibration in prepared.calibrations.keys() {
                if promised.contains(calibration) && !made.calibrations.contains_key(calibration) {
                    tracing::warn!(
                        "{name}: the calibration {calibration} that an earlier plan was to make is \
                         missing; the one on file is used"
                    );
                }
            }
            promised.extend(calibrations::made_by(&prepared.plan));
            let out = self.out.folder(prepared.plan.name.as_str(), self.seed);
            let completed = self.run(&prepared, &out, screen, interrupt)?;
            if completed.dropped > 0 {
                tracing::warn!("{name}: full lines dropped {} times", completed.dropped);
            }
            made.extend(completed.made);
            annotate(name, &completed.summary, screen);
            summaries.push(completed.summary);
            let left = &self.plans[index + 1..];
            if interrupt.requested() && !left.is_empty() {
                screen.note(&format!("not run: {}", left.join(", ")));
                break;
            }
        }
        Ok(())
    }

    fn run(
        &self,
        prepared: &Prepared,
        out: &Path,
        screen: &Screen,
        interrupt: &Interrupt,
    ) -> Result<Completed, Failure> {
        let options =
            Options { seed: self.seed, out, level: self.level, answers: self.answers.clone() };
        let progress = screen.plan(prepared.plan.name.as_str());
        let mut pulse = |now| {
            progress.show(now);
            !interrupt.requested()
        };
        let stopwatch = Stopwatch::start();
        let wall_s = || stopwatch.elapsed_s();
        let completed = match self.setup {
            Setup::Simulated => run_to_folder(prepared, &options, &mut pulse, &wall_s)?,
            Setup::Kernel(bus) => crossing::run(*bus, prepared, &options, &mut pulse, &wall_s)?,
            Setup::Live(setup) => {
                live::run(prepared, &options, setup, self.person.as_ref(), &mut pulse)?
            }
        };
        progress.finish(&completed.summary);
        Ok(completed)
    }
}

/// Shows a build server what did not pass, at the plan where that is a file.
fn annotate(plan: &str, summary: &Summary, screen: &Screen) {
    if summary.outcome == Outcome::Passed {
        return;
    }
    let title = format!("{}: {}", summary.plan, summary.outcome.name());
    let failed = summary.measurements.iter().filter(|one| !one.verdict.is_acceptable());
    let failed: Vec<&str> = failed.map(|one| one.name.as_str()).collect();
    let message = match (&summary.reason, failed.is_empty()) {
        (Some(reason), _) => reason.clone(),
        (None, false) => format!("out of band or never measured: {}", failed.join(", ")),
        (None, true) => summary.outcome.name().to_owned(),
    };
    let place = Path::new(plan).is_file().then(|| (plan.to_owned(), 1));
    Annotation { place, title, message }.show(screen);
}

#[cfg(test)]
mod tests {
    use super::{Out, prepare_all};

    #[test]
    fn a_run_folder_has_plan_and_seed_in_its_name() {
        assert_eq!(Out::Parent("runs".into()).folder("laps", 7).to_str(), Some("runs/laps-seed7"));
        assert_eq!(Out::Folder("here".into()).folder("laps", 7).to_str(), Some("here"));
    }

    #[test]
    fn two_plans_cannot_share_a_run_folder() {
        assert_eq!(prepare_all(&["warm-up", "umbmark"]).unwrap().len(), 2);
        let failure = prepare_all(&["warm-up", "warm-up"]).unwrap_err();
        assert_eq!(failure.to_string(), "two of the plans are called warm-up");
    }
}
