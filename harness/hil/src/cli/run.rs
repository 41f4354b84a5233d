//! `hil run`: runs plans, once each or for many seeds.

use super::EXIT_STATUSES;
use super::build_server::SummaryArguments;
use super::completions;
use super::failure::Failure;
use super::operator::OperatorArguments;
use super::progress::Screen;
use super::seeds;
use super::series::{Out, RUNS, Series, prepare_all, repetitions};
use super::setup::{Setup, SetupArguments};
use crate::choices::one_of;
use clap::Args;
use clap::builder::TypedValueParser;
use live::crossing::Kernel;
use plan::{Plan, SEED};
use record::outcome::Outcome;
use record::run_folder::RunFolder;
use record::sink::Level;
use std::path::{Path, PathBuf};

/// Most runs of one bench; a day of runs of nine seconds.
const REPEAT_MAX: i64 = 10_000;

fn level() -> impl TypedValueParser<Value = Level> {
    one_of([
        (
            "events",
            "Events of the plan, the controller and the measurements: enough to judge and to draw",
            Level::Events,
        ),
        ("full", "Also every byte and every frame", Level::Full),
    ])
}

/// Runs plans in order; later plans use the calibrations that earlier ones make.
///
/// A run folder holds summary.json, the record, junit.xml and report.html.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct RunArguments {
    /// Names of shipped plans (see `hil list plans`) or paths: anything that ends in .toml or contains a /.
    #[arg(required = true, value_name = "PLAN", add = completions::plan())]
    plans: Vec<String>,
    /// Seed of all random numbers; the first one with --seeds. [default: that of the plan, or 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Run this many seeds on all cores, keep no run folders, and print how many pass. The exit
    /// status says whether they ran; a share is not a verdict.
    #[arg(long, value_name = "N", conflicts_with_all = ["out", "record"],
          value_parser = clap::value_parser!(u64).range(1..=seeds::SEEDS_MAX))]
    seeds: Option<u64>,
    /// At a bench: run the plans this many times, one run after the other, and print how many pass and how far the figures
    /// are apart. Each run has a folder of its own, PLAN-seedN-runK.
    #[arg(long, value_name = "N", conflicts_with_all = ["seeds", "verify_determinism", "watch"],
          value_parser = clap::value_parser!(u32).range(2..=REPEAT_MAX))]
    repeat: Option<u32>,
    /// Also write the table of --seeds to this file, as Markdown.
    #[arg(long, value_name = "FILE", requires = "seeds")]
    markdown: Option<PathBuf>,
    /// The run folder; with several plans or runs, the folder of their run folders, each PLAN-seedN.
    /// [default: runs/PLAN-seedN]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// What to record.
    #[arg(long, value_parser = level(), default_value = "events")]
    record: Level,
    /// In virtual time: run each plan twice, every byte recorded, and compare. The first difference is an error.
    #[arg(long, conflicts_with_all = ["seeds", "record"])]
    verify_determinism: bool,
    #[command(flatten)]
    operator: OperatorArguments,
    #[command(flatten)]
    setup: SetupArguments,
    #[command(flatten)]
    summary: SummaryArguments,
    /// Print one JSON document and nothing else: the summaries as in summary.json; of --seeds the shares.
    #[arg(long, conflicts_with = "watch")]
    pub(super) json: bool,
    /// Show the run live: what is measured, lines, events, steps, remaining time. Without a terminal, as plain lines.
    #[arg(long, conflicts_with = "seeds")]
    watch: bool,
}

impl RunArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        if self.watch && screen.is_quiet() {
            return Err(Failure::arguments(
                "--watch shows the run as it goes, --quiet shows nothing of it",
                "leave out one of them",
            ));
        }
        let plans: Vec<&str> = self.plans.iter().map(String::as_str).collect();
        let out = match (&self.out, plans.len()) {
            (Some(path), 1) if self.repeat.is_none() => Out::Folder(path.clone()),
            (Some(path), _) => Out::Parent(path.clone()),
            (None, _) => Out::Parent(RUNS.into()),
        };
        if self.seeds.is_none() {
            self.outdate(&out);
        }
        let setup = self.setup.setup()?;
        if self.repeat.is_some() && !matches!(setup, Setup::Live(_)) {
            return Err(Failure::arguments(
                "--repeat is of a bench: in virtual time all runs of a seed are the same",
                "add --clock real, or let --seeds vary what is random",
            ));
        }
        let prepared = prepare_all(&plans, &setup)?;
        self.setup.fits(&prepared)?;
        if let Setup::Live(bench) = &setup {
            for one in &prepared {
                bench.resolve(&one.rig)?.fits(&one.plan)?;
            }
        }
        let declared: Vec<&Plan> = prepared.iter().map(|one| &*one.plan).collect();
        let asked = declared.iter().copied();
        let (answers, person) = self.operator.collect(&setup, asked, screen)?;
        if let Some(count) = self.seeds {
            match setup {
                Setup::Simulated => {}
                Setup::Kernel(_) => {
                    return Err(Failure::arguments(
                        "--seeds needs the memory bus: no verdict depends on the bus",
                        "leave out --bus, or --seeds",
                    ));
                }
                Setup::Live(_) => {
                    return Err(Failure::arguments(
                        "--seeds needs the virtual clock: a bench has no seed",
                        "leave out --clock; or repeat the run with --repeat",
                    ));
                }
            }
            self.setup.in_process("--seeds")?;
            let range = seeds::range(self.seed.unwrap_or(SEED), count)?;
            let markdown = self.markdown.as_deref();
            let summary = &self.summary;
            let told = seeds::Told { markdown, summary, json: self.json };
            return seeds::execute(&plans, &declared, range, &answers, told, screen);
        }
        if let Setup::Kernel(bus) = setup {
            // A missing bus does not cost the hours of the plans before it.
            for one in &prepared {
                Kernel::open(bus, &one.crossed_lines())?;
            }
        }
        if self.verify_determinism && !matches!(setup, Setup::Simulated) {
            return Err(Failure::arguments(
                "--verify-determinism is of virtual time in memory: no two runs are alike elsewhere",
                "leave out --clock and --bus, or --verify-determinism",
            ));
        }
        let _lease = self.setup.lease(&setup, &|| false, screen)?;
        let level = if self.verify_determinism { Level::Full } else { self.record };
        let summary = self.summary.clone();
        let seed = self.seed;
        let (watched, json) = (self.watch, self.json);
        Series {
            plans: &plans,
            setup: &setup,
            hosting: self.setup.hosting(),
            seed,
            out,
            level,
            answers,
            person,
            summary,
            watched,
            json,
            is_verified: self.verify_determinism,
            repeat: self.repeat,
        }
        .execute(screen)
    }

    /// Build servers read the verdicts of the last run also if this one does not begin. A plan that cannot be read has
    /// the name of its file.
    fn outdate(&self, out: &Out) {
        for plan in &self.plans {
            let name = Path::new(plan).file_stem().unwrap_or_default().to_string_lossy();
            let seed = self.seed.unwrap_or(SEED);
            for run in repetitions(self.repeat) {
                RunFolder::outdate(&out.folder(&name, seed, run));
            }
        }
    }
}
