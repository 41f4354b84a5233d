//! `hil campaign`: applies faults to a plan, and measures how much of one it tolerates.

pub(super) mod account;
mod ended;
mod on_bench;
#[cfg(feature = "nats")]
mod over;
mod saved;
mod what;

use super::EXIT_STATUSES;
use super::annotation::Annotation;
use super::build_server::SummaryArguments;
use super::completions;
use super::envelopes::{EnvelopeArguments, Means};
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::operator::OperatorArguments;
use super::own::taken;
use super::progress::Screen;
use super::say;
use super::setup::{Setup, SetupArguments};
use crate::choices::threads;
use account::{Kept, Place};
use campaign::{
    self, Campaign, CaseResult, Course, Executor, Guided, Journal, PASSES, Random, Search,
    Settings, Space,
};
use clap::{Args, ValueEnum};
use harness::executors::Simulated;
use harness::program::Programs;
use harness::run::Prepared;
use on_bench::RepetitionArguments;
use plan::faults::{FaultKind, Target};
use plan::library::{Kind, Library};
use plan::made::Made;
use record::figures;
use record::locked::Locked;
use record::outcome::Outcome;
use saved::Earlier;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;
use views::console::{self, Again, Style};

/// How the next case is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum By {
    /// Evenly over all faults, and closer to cases that nearly broke a property where that pays.
    #[default]
    Margins,
    /// At random, whatever earlier cases showed.
    Chance,
}

/// Runs a plan under random faults until a property breaks, shrinks the case, and saves it as a
/// plan.
///
/// An interrupted campaign resumes where it stopped.
///
/// With --clock real, cases run on a bench, one at a time; a case that breaks a property is
/// repeated to confirm it.
///
/// With --envelope or --envelopes it measures how much of a fault is tolerated instead.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct CampaignArguments {
    /// Name of a shipped plan (see `hil list plans`) or path: anything that ends in .toml or contains a /.
    #[arg(value_name = "PLAN", add = completions::plan())]
    pub(super) plan: String,
    /// How many cases.
    #[arg(long, value_name = "N", default_value_t = 1_000,
          value_parser = clap::value_parser!(u64).range(1..=CASES_MAX))]
    pub(super) cases: u64,
    /// Seed of the campaign; with --envelope the first seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    /// What chooses the next case.
    #[arg(long, value_enum, default_value_t)]
    by: By,
    /// Kinds of faults, with commas between (see `hil list faults`). [default: all that apply]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    faults: Vec<String>,
    /// Kinds of faults that are left out, with commas between.
    #[arg(long, value_name = "KIND", value_delimiter = ',', conflicts_with_all = ["envelope", "envelopes"])]
    without: Vec<String>,
    /// What the faults strike, with commas between: gyro, base, table, host or operator, a node with
    /// its messages and signals, a line, or a message or signal of a node. [default: all but
    /// messages and signals of the device under test; with --envelope the first that the fault
    /// applies to]
    #[arg(
        long = "target",
        value_name = "TARGET",
        value_delimiter = ',',
        conflicts_with = "envelopes"
    )]
    targets: Vec<String>,
    /// Faults of one case, at most.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=16))]
    faults_max: u8,
    /// Cases at a time. [default: one per processor]
    #[arg(long, visible_alias = "jobs", value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    #[cfg(feature = "nats")]
    #[command(flatten)]
    over: over::OverArguments,
    /// Folder of the campaign. [default: runs/campaign-PLAN-seedN, and runs/envelopes-PLAN-seedN for envelopes]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder for the smallest cases, as plans. [default: the folder of the campaign]
    #[arg(long, value_name = "DIR", conflicts_with_all = ["envelope", "envelopes"])]
    regressions: Option<PathBuf>,
    #[command(flatten)]
    pub(super) envelopes: EnvelopeArguments,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) operator: OperatorArguments,
    #[command(flatten)]
    setup: SetupArguments,
    #[command(flatten)]
    summary: SummaryArguments,
    #[command(flatten)]
    pub(super) repetition: RepetitionArguments,
    /// Attempts to shrink one case. [default: 500; 20 with the real clock, where each takes as long
    /// as the plan]
    #[arg(long, value_name = "N", conflicts_with_all = ["envelope", "envelopes"])]
    shrink_max: Option<u64>,
}

/// Maximum number of cases: their results are kept in a file and read again.
const CASES_MAX: u64 = 10_000_000;
/// Maximum number of attempts to shrink one case.
const SHRINK_MAX: u64 = 500;
/// File of a campaign folder that holds its cases.
const JOURNAL: &str = "cases.jsonl";

/// What a campaign tests, and whom it reports to.
#[derive(Clone, Copy)]
struct Task<'a> {
    source: &'a str,
    pub(super) prepared: &'a Prepared,
    pub(super) interrupt: &'a Interrupt,
    pub(super) screen: &'a Screen,
}

struct Begun {
    folder: PathBuf,
    journal: Journal,
    earlier: Vec<Earlier>,
}

impl CampaignArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        // The parser forgives a missing `--envelope` beside options that exclude it.
        if let Some(option) = self.envelopes.unused() {
            let message =
                format!("{option} says how an envelope is measured, and none is asked for");
            return Err(Failure::arguments(message, "add --envelope KIND, or leave it out"));
        }
        if !self.envelopes.is_asked() {
            self.outdate();
        }
        let library = Library::beside(&self.plan);
        let source = library.open(Kind::Plan, &self.plan)?;
        let setup = self.setup.setup()?;
        let prepared =
            Prepared::load(&self.plan, &Made::default())?.with_real(&setup.real_nodes())?;
        self.setup.fits(std::slice::from_ref(&prepared))?;
        let interrupt = Interrupt::install(screen)?;
        let live = match &setup {
            Setup::Simulated => None,
            Setup::Kernel(_) => {
                return Err(Failure::arguments(
                    "a campaign needs the memory bus, or the real clock: no verdict depends on what is crossed",
                    "leave out --bus, or add --clock real",
                ));
            }
            Setup::Live(live) => Some(live),
        };
        self.known(&prepared)?;
        let task =
            Task { source: &source.text, prepared: &prepared, interrupt: &interrupt, screen };
        let Some(live) = live else {
            self.repetition.none()?;
            let (answers, _) = self.operator.collect(&setup, [&*prepared.plan], screen)?;
            let hosting = self.setup.hosting();
            let programs = Programs::until(interrupt.flag());
            let carried_out = Prepared { hosting, programs, ..prepared.clone() };
            let executor = Simulated::new(carried_out, answers).stopped_by(interrupt.flag());
            let threads =
                self.threads.or_else(|| available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN);
            if self.envelopes.is_asked() {
                let means = Means {
                    prepared: &prepared,
                    executor: &executor,
                    what: self.envelopes_of(&task),
                    seed: self.seed,
                    target: self.only_target()?,
                    threads,
                    interrupt: &interrupt,
                    screen,
                    summary: &self.summary,
                };
                let folder = self.folder("envelopes", prepared.plan.name.as_str());
                return self.envelopes.execute(&means, &folder, self.json);
            }
            let clean = executor.without_faults(self.seed);
            let judged = prepared.plan.judged(&prepared.rig);
            let states = prepared.plan.unreached(&judged, &clean.1.reached);
            let space = self.space(&task, clean, |_, _| true)?;
            let settings =
                Settings { cases: self.cases, threads, shrink_max: self.shrink_max(SHRINK_MAX) };
            let (folder, _held) = self.opened(&prepared)?;
            let what = self.what(&task, "");
            let journal = Journal::open(&folder.join(JOURNAL), &what)?;
            let begun = Begun { journal, earlier: saved::earlier(&folder), folder };
            let replay = self.again();
            let place = |carried_out_by| Place { carried_out_by, replay: &replay };
            #[cfg(feature = "nats")]
            if let Some(server) = self.over.server()? {
                self.setup.in_process("a campaign over a server")?;
                let answers = executor.answers();
                let order = over::Order { plan: &self.plan, what: &what, answers };
                let order = order.virtually()?;
                let remote = over::open(&server, order, executor.clone(), task.interrupt, screen)?;
                let settings = Settings { threads: over::AT_A_TIME, ..settings };
                let place = place("workers of a server (hil worker)".to_owned());
                let kept = self.account(&task, &space, &states, place)?;
                let (done, saved) =
                    self.search(&task, begun, &remote, &space, &states, &settings)?;
                if let Some(failure) = remote.failure() {
                    return Err(failure.into());
                }
                if !done.stopped && !task.interrupt.requested() {
                    over::finish(&remote, &done, &saved, None)?;
                }
                return self.tell(screen, kept, (&done, &saved), None);
            }
            let place = place(format!(
                "{} of this machine",
                figures::counted(threads.get() as u64, "thread", "threads")
            ));
            let kept = self.account(&task, &space, &states, place)?;
            let (done, saved) = self.search(&task, begun, &executor, &space, &states, &settings)?;
            return self.tell(screen, kept, (&done, &saved), None);
        };
        if self.envelopes.is_asked() || self.threads.is_some_and(|threads| threads.get() > 1) {
            return Err(Failure::arguments(
                "the real clock has one bench: it carries out one case at a time, and no envelope",
                "leave out --clock, or --envelope and --threads",
            ));
        }
        self.on_bench(&task, &setup, live)
    }

    fn shrink_max(&self, usual: u64) -> u64 {
        self.shrink_max.unwrap_or(usual)
    }

    /// Returns the faults to choose from, after checking that the run without faults violates no property; `clean` is
    /// the course and result of that run.
    fn space(
        &self,
        task: &Task<'_>,
        (course, clean): (Course, CaseResult),
        can_suffer: impl Fn(Target, FaultKind) -> bool,
    ) -> Result<Space, Failure> {
        let (plan, lines) = (&task.prepared.plan, task.prepared.rig.struck());
        if let Some(violated) = clean.violated.first() {
            let breaks = match violated.property.as_str() {
                PASSES => "fails".to_owned(),
                property => format!("breaks the property {property}"),
            };
            return Err(Failure::arguments(
                format!("{} {breaks} without any fault", plan.name),
                format!("at {:.3} s: {}", violated.at_s, violated.what),
            ));
        }
        // One that was interrupted shows nothing; the search then stops at once.
        let is_whole = !clean.is_given_up();
        if let Some((property, why)) = clean.never_judged.first_key_value().filter(|_| is_whole) {
            return Err(Failure::arguments(
                format!("{} never judges the property {property}, without any fault", plan.name),
                why,
            ));
        }
        if is_whole && clean.outcome != Outcome::Passed.name() {
            return Err(Failure::arguments(
                format!("{} ends in {} without any fault", plan.name, clean.outcome),
                format!("run it by itself to see why: hil run {}", self.plan),
            ));
        }
        let faults_max = usize::from(self.faults_max);
        let targets = self.struck(task.prepared)?;
        let space = Space::among(plan, lines, course, faults_max, &self.faults, &targets);
        let is_wanted = |kind: FaultKind| !self.without.iter().any(|name| name == kind.name());
        let space = space.within(|target, kind| is_wanted(kind) && can_suffer(target, kind));
        if space.kinds().is_empty() {
            return Err(Failure::arguments(
                format!("none of these faults can strike the bench of {}", plan.name),
                "`hil list faults` says what each strikes",
            ));
        }
        Ok(space)
    }

    /// Returns the campaign's folder, created if it does not exist, and what holds it.
    fn opened(&self, prepared: &Prepared) -> Result<(PathBuf, Option<Locked>), Failure> {
        let folder = self.folder("campaign", prepared.plan.name.as_str());
        let ours = folder.join(JOURNAL).is_file();
        let held = taken(&folder, ours)?;
        Ok((folder, held))
    }

    /// Searches, shrinks and saves in the campaign's folder.
    fn search(
        &self,
        task: &Task<'_>,
        begun: Begun,
        executor: &impl Executor,
        space: &Space,
        states: &BTreeMap<String, bool>,
        settings: &Settings,
    ) -> Result<(Campaign, Vec<PathBuf>), Failure> {
        let Task { prepared, interrupt, screen, .. } = *task;
        let Begun { folder, mut journal, earlier } = begun;
        let mut search: Box<dyn Search> = match self.by {
            By::Margins => Box::new(Guided::new(space, self.seed)),
            By::Chance => Box::new(Random::new(space, self.seed)),
        };
        let bar = screen.cases(prepared.plan.name.as_str(), self.cases);
        let done =
            campaign::run(executor, &mut *search, states, settings, &mut journal, &mut |tally| {
                bar.set_position(tally.cases);
                !interrupt.requested()
            })?;
        bar.finish_and_clear();
        let saved = self.save(task, &folder, &done, earlier)?;
        Ok((done, saved))
    }

    /// Saves, draws and prints the result, and reports it to build servers.
    fn tell(
        &self,
        screen: &Screen,
        kept: Kept,
        (done, saved): (&Campaign, &[PathBuf]),
        again: Option<&Again<'_>>,
    ) -> Result<Outcome, Failure> {
        let markdown = console::campaign_markdown(kept.plan(), done, saved, kept.replay());
        for (found, path) in done.found.iter().zip(saved) {
            let title = format!("{}: {} broke", kept.plan(), found.property);
            let seed = found.shrunk.case.seed;
            let again = format!("hil run {} --seed {seed} {}", path.display(), kept.replay());
            let message = format!("again: {}", again.trim_end());
            Annotation { place: None, title, message }.show(screen);
        }
        let page = kept.end(done, saved, again)?;
        if self.json {
            say(&(console::campaign_json(done, saved, again) + "\n"))?;
        } else {
            say(&console::campaign_table(done, saved, again, Style::of_stdout()))?;
            screen.chat(&format!("{}", page.display()));
        }
        self.summary.append(&markdown)?;
        for state in &done.missed {
            screen.note(&format!("the plan demands {state} sometimes, and no case reached it"));
        }
        let outcome = ended::outcome(done, again.is_none());
        if outcome == Outcome::Error {
            let cases = figures::counted(done.tally.cases, "case", "cases");
            screen.note(&match done.tally.outcomes.get("error") {
                Some(errors) if *errors < done.tally.cases => {
                    format!("no verdict in {errors} of {cases}: they ended in an error")
                }
                _ => format!("no verdict in any of {cases}: nothing was shown"),
            });
        }
        Ok(outcome)
    }

    pub(super) fn folder(&self, what: &str, plan: &str) -> PathBuf {
        let usual = || PathBuf::from(format!("runs/{what}-{plan}-seed{}", self.seed));
        self.out.clone().unwrap_or_else(usual)
    }
}
