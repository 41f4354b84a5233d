//! `hil campaign`: faults thrown at a plan, and how much of one it tolerates.

use super::EXIT_STATUSES;
use super::envelopes::{EnvelopeArguments, Means, kind};
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::operator::OperatorArguments;
use super::progress::Screen;
use super::say;
use super::setup::Setup;
use crate::campaign::{
    self, Campaign, Guided, Journal, Random, Regression, Search, Settings, Simulated, Space,
};
use crate::console::{self, Style};
use crate::library::{Kind, Library};
use crate::made::Made;
use crate::outcome::Outcome;
use crate::plan::Property;
use crate::run::Prepared;
use crate::world::bench::bench_lines;
use clap::{Args, ValueEnum};
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;

/// How the next case is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum By {
    /// Evenly over all that can go wrong, and nearer to where properties nearly broke as far as that pays.
    #[default]
    Margins,
    /// Without regard to earlier ones.
    Chance,
}

impl By {
    const fn name(self) -> &'static str {
        match self {
            Self::Margins => "margins",
            Self::Chance => "chance",
        }
    }
}

/// Throws seeded fault schedules at a plan until a property breaks, makes the case as small as it gets, and saves it as a plan.
///
/// With --envelope or --envelopes it measures instead how much of a fault is tolerated. One that was interrupted goes on where it
/// stopped.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct CampaignArguments {
    /// Name of a shipped plan (see `hil list plans`) or path: what ends in .toml or holds a /.
    #[arg(value_name = "PLAN")]
    plan: String,
    /// How many cases.
    #[arg(long, value_name = "N", default_value_t = 1_000,
          value_parser = clap::value_parser!(u64).range(1..=CASES_MAX))]
    cases: u64,
    /// Seed of the campaign; with --envelope the first seed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What chooses the next case.
    #[arg(long, value_enum, default_value_t)]
    by: By,
    /// Kinds of faults, with commas between (see `hil list faults`). [default: all that apply]
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    faults: Vec<String>,
    /// Faults of one case, at most.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=16))]
    faults_max: u8,
    /// Cases at a time. [default: one a processor]
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// Folder of the campaign. [default: runs/campaign-PLAN-seedN, and runs/envelopes-PLAN-seedN for envelopes]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Where the smallest cases go, as plans. [default: the folder of the campaign]
    #[arg(long, value_name = "DIR")]
    regressions: Option<PathBuf>,
    #[command(flatten)]
    envelopes: EnvelopeArguments,
    /// Print the end as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    operator: OperatorArguments,
    /// Show nothing but the end and what went wrong.
    #[arg(long)]
    pub(super) quiet: bool,
}

/// The most cases: what came of them is kept in a file and read again.
const CASES_MAX: u64 = 10_000_000;
/// Tries to make one case smaller.
const SHRINK_MAX: u64 = 500;
/// File of a campaign folder.
const JOURNAL: &str = "cases.jsonl";

impl CampaignArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let library = Library::beside(&self.plan);
        let source = library.open(Kind::Plan, &self.plan)?;
        let prepared = Prepared::load(&self.plan, &Made::default())?;
        let setup = Setup::Simulated;
        let (answers, _) = self.operator.collect(&setup, [&*prepared.plan], screen)?;
        let executor = Simulated::new(prepared.clone(), answers);
        let threads =
            self.threads.or_else(|| available_parallelism().ok()).unwrap_or(NonZeroUsize::MIN);
        let interrupt = Interrupt::install(screen)?;
        if self.envelopes.is_asked() {
            let means = Means {
                prepared: &prepared,
                executor: &executor,
                seed: self.seed,
                threads,
                interrupt: &interrupt,
                screen,
            };
            return self.envelopes.execute(&means, &self.folder("envelopes", &prepared), self.json);
        }
        self.known()?;
        let (horizon, clean) = executor.without_faults(self.seed);
        if let Some(violated) = clean.violated.first() {
            return Err(Failure::arguments(
                format!("{}: breaks {} without any fault", prepared.plan.name, violated.property),
                format!("at {:.3} s: {}", violated.at_s, violated.what),
            ));
        }
        let faults_max = usize::from(self.faults_max);
        let lines = bench_lines(&prepared.devices);
        let space = Space::new(&prepared.plan, lines, horizon, faults_max, &self.faults);
        if space.kinds().is_empty() {
            return Err(Failure::arguments(
                format!("none of these faults can strike the bench of {}", prepared.plan.name),
                "`hil list faults` says what each strikes",
            ));
        }
        let folder = self.folder("campaign", &prepared);
        std::fs::create_dir_all(&folder).map_err(|source| Failure::file(&folder, source))?;
        let what = format!(
            "{} ({}), by {}, seed {}, up to {faults_max} of {}",
            prepared.plan.name,
            campaign::Case::default().id(&source.text),
            self.by.name(),
            self.seed,
            if self.faults.is_empty() { "all faults".to_owned() } else { self.faults.join(", ") },
        );
        let mut journal = Journal::open(&folder.join(JOURNAL), &what)?;
        let mut search: Box<dyn Search> = match self.by {
            By::Margins => Box::new(Guided::new(&space, self.seed)),
            By::Chance => Box::new(Random::new(&space, self.seed)),
        };
        let bar = screen.cases(prepared.plan.name.as_str(), self.cases);
        let settings = Settings { cases: self.cases, threads, shrink_max: SHRINK_MAX };
        let states = states(&prepared);
        let done = campaign::run(
            &executor,
            &mut *search,
            &states,
            &settings,
            &mut journal,
            &mut |tally| {
                bar.set_position(tally.cases);
                !interrupt.requested()
            },
        )?;
        bar.finish_and_clear();
        let mut saved = Vec::new();
        for found in &done.found {
            let what = found.shrunk.result.violated.iter().find(|v| v.property == found.property);
            let regression = Regression {
                plan: prepared.plan.name.as_str(),
                text: &source.text,
                property: &found.property,
                what: what.map_or("", |violated| violated.what.as_str()),
                case: &found.shrunk.case,
            };
            saved.push(regression.write(self.regressions.as_deref().unwrap_or(&folder))?);
        }
        if self.json {
            say(&(console::campaign_json(&done, &saved) + "\n"))?;
        } else {
            say(&console::campaign_table(&done, &saved, Style::of_stdout()))?;
        }
        Ok(outcome(&done))
    }

    fn folder(&self, what: &str, prepared: &Prepared) -> PathBuf {
        self.out.clone().unwrap_or_else(|| {
            PathBuf::from(format!("runs/{what}-{}-seed{}", prepared.plan.name, self.seed))
        })
    }

    /// Kinds are of the vocabulary.
    fn known(&self) -> Result<(), Failure> {
        self.faults.iter().try_for_each(|name| kind(name).map(|_| ()))
    }
}

/// What must come about sometimes: by the plan, or all that can be judged.
fn states(prepared: &Prepared) -> BTreeSet<String> {
    let asked = match prepared.plan.properties.as_slice() {
        [] => Property::all(),
        some => some.to_vec(),
    };
    asked
        .iter()
        .filter(|property| matches!(property, Property::Sometimes(_)))
        .map(|property| property.name().to_owned())
        .collect()
}

fn outcome(done: &Campaign) -> Outcome {
    match (done.found.is_empty(), done.stopped) {
        (false, _) => Outcome::Failed,
        (true, true) => Outcome::Aborted,
        (true, false) => Outcome::Passed,
    }
}
