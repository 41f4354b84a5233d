//! Runs plans one after another; later ones use what earlier ones make.

use super::annotation::Annotation;
use super::build_server::SummaryArguments;
use super::determinism;
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::progress::Screen;
use super::setup::Setup;
use super::terminal::Terminal;
use super::watch::Watch;
use super::{say, say_json};
use harness::hosted::Hosting;
use harness::operator::Answers;
use harness::program::Programs;
use harness::run::{Completed, Options, Prepared, run_to_folder_watched};
use harness::run_live::{LiveRunError, LiveSetting, run_live_to_folder_watched};
use harness::stopwatch::Stopwatch;
use live::crossing::Kernel;
use plan::calibrations;
use plan::made::Made;
use record::outcome::{Outcome, Summary};
use record::sink::Level;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use views::console::{self, Style};
use views::watch::Feed;

pub(super) const RUNS: &str = "runs";

#[derive(Debug, Clone)]
pub(super) enum Out {
    Folder(PathBuf),
    /// Parent folder; each plan has its own run folder, and each of its runs if they are repeated.
    Parent(PathBuf),
}

impl Out {
    pub(super) fn folder(&self, plan: &str, seed: u64, run: Option<u32>) -> PathBuf {
        match (self, run) {
            (Self::Folder(path), _) => path.clone(),
            (Self::Parent(path), None) => path.join(format!("{plan}-seed{seed}")),
            (Self::Parent(path), Some(run)) => path.join(format!("{plan}-seed{seed}-run{run}")),
        }
    }
}

/// Plans to run in order.
#[derive(Debug)]
pub(super) struct Series<'a> {
    pub(super) plans: &'a [&'a str],
    pub(super) setup: &'a Setup,
    /// Controller under test in virtual time.
    pub(super) hosting: Hosting,
    /// The seed that is asked for.
    pub(super) seed: Option<u64>,
    pub(super) out: Out,
    pub(super) level: Level,
    pub(super) answers: Answers,
    /// The person to ask for further answers.
    pub(super) person: Option<Terminal>,
    pub(super) summary: SummaryArguments,
    /// Show the live view.
    pub(super) watched: bool,
    /// Print the result for a program.
    pub(super) json: bool,
    /// Run each plan twice and compare the two runs.
    pub(super) is_verified: bool,
    /// How often a bench runs all of them.
    pub(super) repeat: Option<u32>,
}

/// One of the runs of a series.
#[derive(Debug, Clone, Copy)]
struct Turn<'a> {
    watch: &'a Watch,
    /// The plan, by its place.
    index: usize,
    /// Its number among the runs of the plan, if there are several.
    repetition: Option<u32>,
}

/// The numbers of the runs of a plan; `None` for a single one.
pub(super) fn repetitions(times: Option<u32>) -> Vec<Option<u32>> {
    times.map_or_else(|| vec![None], |times| (1..=times).map(Some).collect())
}

/// Reads and checks all plans before any of them runs, so that a mistake in the last plan does not cost the hours of
/// the others. Calibrations that earlier plans make are assumed to exist.
///
/// # Errors
///
/// When a plan cannot be prepared, or two have the same name and would share a run folder.
pub(super) fn prepare_all(plans: &[&str], setup: &Setup) -> Result<Vec<Prepared>, Failure> {
    let mut promised = Made::default();
    let mut prepared: Vec<Prepared> = Vec::new();
    for name in plans {
        let next = Prepared::load(name, &promised)?.with_real(&setup.real_nodes())?;
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
    /// Runs the plans, prints the table, and returns the worst outcome. A failed plan does not stop the later ones; an
    /// interrupt does.
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let interrupt = Interrupt::install(screen)?;
        let mut summaries = Vec::new();
        let watch = if self.watched {
            let is_real_time = matches!(self.setup, Setup::Live(_));
            Watch::begin(self.plans, is_real_time, &interrupt, screen)
        } else {
            Watch::Unwatched
        };
        let mut done = Ok(());
        for repetition in repetitions(self.repeat) {
            done = self.run_all(repetition, screen, &interrupt, &watch, &mut summaries);
            if done.is_err() || interrupt.requested() {
                break;
            }
        }
        drop(watch);
        let done = tell(done, &summaries, self.json)?;
        if done.is_ok() || !summaries.is_empty() {
            self.summary.append(&console::runs_markdown(&summaries))?;
        }
        done.map(|()| console::worst(&summaries))
    }

    fn run_all(
        &self,
        repetition: Option<u32>,
        screen: &Screen,
        interrupt: &Interrupt,
        watch: &Watch,
        summaries: &mut Vec<Summary>,
    ) -> Result<(), Failure> {
        let mut made = Made::default();
        let mut promised = BTreeSet::new();
        for (index, name) in self.plans.iter().enumerate() {
            let (hosting, programs) = (self.hosting.clone(), Programs::until(interrupt.flag()));
            let prepared = Prepared::load(name, &made)?.with_real(&self.setup.real_nodes())?;
            let prepared = Prepared { hosting, programs, ..prepared };
            for calibration in prepared.calibrations.keys() {
                if promised.contains(calibration) && !made.calibrations.contains_key(calibration) {
                    tracing::warn!(
                        "{name}: the calibration {calibration} that an earlier plan was to make is \
                         missing; the one on file is used"
                    );
                }
            }
            promised.extend(calibrations::made_by(&prepared.plan));
            let seed = prepared.plan.seed(self.seed);
            let out = self.out.folder(prepared.plan.name.as_str(), seed, repetition);
            let turn = Turn { watch, index, repetition };
            let completed = self.run(&prepared, &out, screen, interrupt, turn, summaries)?;
            if completed.dropped > 0 {
                tracing::warn!(
                    "{name}: {} items were lost on lines that were full",
                    completed.dropped
                );
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

    /// Runs one plan; puts the summary of a bench that did not come up with the others.
    fn run(
        &self,
        prepared: &Prepared,
        out: &Path,
        screen: &Screen,
        interrupt: &Interrupt,
        Turn { watch, index, repetition }: Turn<'_>,
        summaries: &mut Vec<Summary>,
    ) -> Result<Completed, Failure> {
        let seed = prepared.plan.seed(self.seed);
        let options = Options { seed, out, level: self.level, answers: self.answers.clone() };
        let header = || prepared.header(seed);
        let mut shown = watch.plan(index, || Feed::new(&prepared.plan, &header()));
        let feed = shown.feed().cloned();
        let feed = feed.as_ref();
        let progress = if watch.is_unwatched() {
            screen.plan(prepared.plan.name.as_str())
        } else {
            screen.plan_shown_elsewhere()
        };
        let mut pulse = |now| {
            progress.show(now);
            shown.progress(now);
            !interrupt.requested()
        };
        let stopwatch = Stopwatch::start();
        let wall_s = || stopwatch.elapsed_s();
        let mut completed = match self.setup {
            Setup::Simulated => {
                run_to_folder_watched(None, prepared, &options, feed, &mut pulse, &wall_s)?
            }
            Setup::Kernel(bus) => {
                let kernel = Box::new(Kernel::open(*bus, &prepared.crossed_lines())?);
                run_to_folder_watched(Some(kernel), prepared, &options, feed, &mut pulse, &wall_s)?
            }
            Setup::Live(setup) => {
                let person = self.person.as_ref().map(|terminal| watch.person(terminal));
                let setup = LiveSetting { repetition, ..LiveSetting::clone(setup) };
                let done = run_live_to_folder_watched(
                    prepared, &options, &setup, person, feed, &mut pulse,
                );
                if let Err(LiveRunError::Live { summary, .. }) = &done {
                    summaries.push(Summary::clone(summary));
                }
                done?
            }
        };
        if self.is_verified {
            let quiet = &mut |_| !interrupt.requested();
            determinism::verify(prepared, (&options, out), &mut completed, quiet)?;
        }
        shown.finish();
        watch.over(index, completed.summary.outcome);
        progress.finish(&completed.summary);
        Ok(completed)
    }
}

/// Prints the results of runs: as a table, or as a document. After an error the results so far are printed too; with
/// JSON they go into the document of the failure, which the caller prints.
pub(super) fn tell(
    done: Result<(), Failure>,
    summaries: &[Summary],
    json: bool,
) -> Result<Result<(), Failure>, Failure> {
    match (done, json) {
        (Ok(()), true) => say_json(&json!({ "runs": summaries })).map(Ok),
        (Err(failure), true) => Ok(Err(failure.after(json!({ "runs": summaries })))),
        (done, false) => {
            if done.is_ok() || !summaries.is_empty() {
                let is_repeated = summaries.iter().any(|one| one.repetition().is_some());
                let table =
                    if is_repeated { console::repeated_table } else { console::measurements_table };
                say(&table(summaries, Style::of_stdout()))?;
            }
            Ok(done)
        }
    }
}

/// Reports a failure to a build server, at the plan if it is a file.
fn annotate(plan: &str, summary: &Summary, screen: &Screen) {
    if summary.outcome == Outcome::Passed {
        return;
    }
    let title = format!("{}: {}", summary.plan, summary.outcome.name());
    let failed = summary.measurements.iter().filter(|one| !one.verdict.is_acceptable());
    let failed: Vec<&str> = failed.map(|one| one.name.as_str()).collect();
    let message = match (&summary.reason, failed.is_empty()) {
        (Some(reason), _) => reason.clone(),
        (None, false) => format!("out of band or unset: {}", failed.join(", ")),
        (None, true) => summary.outcome.name().to_owned(),
    };
    let place = Path::new(plan).is_file().then(|| (plan.to_owned(), 1));
    Annotation { place, title, message }.show(screen);
}

#[cfg(test)]
mod tests {
    use super::{Out, Setup, prepare_all};

    #[test]
    fn a_run_folder_has_plan_and_seed_in_its_name() {
        let folder = |out: Out, run| out.folder("laps", 7, run).to_string_lossy().into_owned();
        assert_eq!(folder(Out::Parent("runs".into()), None), "runs/laps-seed7");
        assert_eq!(folder(Out::Parent("runs".into()), Some(3)), "runs/laps-seed7-run3");
        assert_eq!(folder(Out::Folder("here".into()), None), "here");
    }

    #[test]
    fn two_plans_cannot_share_a_run_folder() {
        assert_eq!(prepare_all(&["warm-up", "umbmark"], &Setup::Simulated).unwrap().len(), 2);
        let failure = prepare_all(&["warm-up", "warm-up"], &Setup::Simulated).unwrap_err();
        assert_eq!(failure.to_string(), "two of the plans are called warm-up");
    }
}
