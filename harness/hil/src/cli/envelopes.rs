//! `hil campaign --envelope` and `--envelopes`: how severe faults may be before a plan fails.

use super::build_server::SummaryArguments;
use super::failure::Failure;
use super::interrupt::Interrupt;
use super::own::taken;
use super::progress::Screen;
use super::say;
use campaign::{
    self, Case, CaseResult, Course, Envelope, EnvelopeSettings, Executor, Kept, Level, Measured,
};
use clap::Args;
use harness::executors::Simulated;
use harness::run::Prepared;
use indicatif::ProgressBar;
use plan::faults::{Fault, FaultKind, Target};
use plan::{DeclaredEnvelope, Unsound, struck_by};
use record::outcome::Outcome;
use record::run_folder::{JUNIT, REPORT, RunFolderError};
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use views::console::{self, Style};
use views::junit;
use views::report::envelopes::page;

/// Which envelopes, and how they are measured.
#[derive(Debug, Args)]
pub(super) struct EnvelopeArguments {
    /// Measure how much of this kind of fault is tolerated.
    #[arg(long, value_name = "KIND", conflicts_with_all = ["cases", "by", "faults", "faults_max"])]
    envelope: Option<String>,
    /// Measure the envelopes that the plan declares; fails unless each is as wide as declared.
    #[arg(long, conflicts_with_all = ["cases", "by", "faults", "faults_max", "envelope"])]
    envelopes: bool,
    /// Runs at each severity, at most; fewer if they decide it.
    /// [default: 400]
    #[arg(long, value_name = "N", requires = "envelope", conflicts_with = "envelopes")]
    runs: Option<u64>,
    /// Share of runs that must pass, at 95 % confidence, for a severity to be tolerated. [default: 0.9]
    #[arg(long, value_name = "SHARE", requires = "envelope", conflicts_with = "envelopes")]
    share: Option<f64>,
    /// Fail unless at least this much is tolerated, in the unit of the fault kind.
    #[arg(long, value_name = "SEVERITY", requires = "envelope", conflicts_with = "envelopes")]
    at_least: Option<f64>,
}

/// Runs at each severity, at most, and the share of them that must pass, unless others are asked for.
const RUNS: u64 = 400;
const SHARE: f64 = 0.9;

const FIGURES: &str = "envelopes.json";
const JOURNAL: &str = "runs.jsonl";

struct Asked {
    fault: Fault,
    at_least: Option<f64>,
    share: f64,
    runs: u64,
}

pub(super) struct Means<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) executor: &'a Simulated,
    /// What determines the runs, as stated in their journal.
    pub(super) what: String,
    pub(super) seed: u64,
    /// Target of the fault, if one was asked for.
    pub(super) target: Option<&'a str>,
    pub(super) threads: NonZeroUsize,
    pub(super) interrupt: &'a Interrupt,
    pub(super) screen: &'a Screen,
    pub(super) summary: &'a SummaryArguments,
}

impl EnvelopeArguments {
    /// Whether an envelope is requested instead of a search.
    pub(super) const fn is_asked(&self) -> bool {
        self.envelopes || self.envelope.is_some()
    }

    /// The first option that says how an envelope is measured, if no envelope is asked for.
    pub(super) fn unused(&self) -> Option<&'static str> {
        let given = [
            (self.runs.is_some(), "--runs"),
            (self.share.is_some(), "--share"),
            (self.at_least.is_some(), "--at-least"),
        ];
        let given = given.into_iter().find(|(is_given, _)| *is_given);
        given.filter(|_| !self.is_asked()).map(|(_, option)| option)
    }

    /// Measures the requested envelopes; the page and the figures go to `folder`.
    pub(super) fn execute(
        &self,
        means: &Means<'_>,
        folder: &Path,
        json: bool,
    ) -> Result<Outcome, Failure> {
        let asked = match &self.envelope {
            Some(name) => vec![self.one(name, means)?],
            None => declared(means.prepared)?,
        };
        let ours = [FIGURES, JOURNAL].iter().any(|name| folder.join(name).is_file());
        let _held = taken(folder, ours)?;
        let (course, clean) = means.executor.without_faults(means.seed);
        let kept = Kept::open(means.executor, &folder.join(JOURNAL), &means.what)?;
        let mut all = Vec::new();
        for asked in asked {
            let envelope = means.measure(&kept, &asked, &course);
            if let Some(failure) = kept.failure() {
                return Err(failure.into());
            }
            if means.interrupt.requested() {
                // What is known so far is no envelope; the journal has the runs.
                means
                    .screen
                    .note(&format!("interrupted; the same command goes on: {}", folder.display()));
                return Ok(Outcome::Aborted);
            }
            if let Some(level) = envelope.fails_by_itself() {
                return Err(means.fails_by_itself(level, &clean));
            }
            if !json {
                say(&console::envelope_table(&envelope, asked.at_least, Style::of_stdout()))?;
            }
            let plan = means.prepared.plan.name.as_str().to_owned();
            all.push(Measured { plan, envelope, at_least: asked.at_least });
        }
        let plan = means.prepared.plan.name.as_str();
        means.summary.append(&console::envelopes_markdown(plan, &all))?;
        let outcome = match all.iter().all(Measured::holds) {
            true => Outcome::Passed,
            false => Outcome::Failed,
        };
        if json {
            say(&(console::envelopes_json(&all) + "\n"))?;
        }
        // The journal is of this plan and seed, and so are the figures beside it.
        let all = joined(figures(folder).unwrap_or_default(), all);
        let verdicts = junit::envelopes(plan, &all).map_err(io::Error::other);
        let verdicts = verdicts.map_err(|source| Failure::file(&folder.join(JUNIT), source))?;
        let (figures, page) = (console::envelopes_json(&all), page(plan, &all));
        for (name, text) in [(FIGURES, &figures), (REPORT, &page), (JUNIT, &verdicts)] {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(|source| Failure::file(&path, source))?;
        }
        if !json {
            means.screen.chat(&format!("{}", folder.join(REPORT).display()));
        }
        Ok(outcome)
    }

    fn one(&self, name: &str, means: &Means<'_>) -> Result<Asked, Failure> {
        let kind = kind(name)?;
        let fault = means.struck(kind)?;
        let (runs, share) = (self.runs.unwrap_or(RUNS), self.share.unwrap_or(SHARE));
        let asked = DeclaredEnvelope {
            kind,
            target: None,
            // Where nothing is asked, any severity of the kind is one.
            at_least: self.at_least.unwrap_or(kind.severity_range().1),
            share,
            runs,
        };
        asked.sound().map_err(|Unsound { key, message, help }| {
            Failure::arguments(format!("--{}: {message}", key.replace('_', "-")), help)
        })?;
        Ok(Asked { fault, at_least: self.at_least, share, runs })
    }
}

/// The envelopes of a folder, and those that were measured since: each fault once, with what was required of it.
fn joined(mut before: Vec<Measured>, since: Vec<Measured>) -> Vec<Measured> {
    for one in since {
        let of_it = |other: &&mut Measured| {
            (&other.envelope.kind, &other.envelope.target)
                == (&one.envelope.kind, &one.envelope.target)
        };
        match before.iter_mut().find(of_it) {
            Some(known) => *known = Measured { at_least: one.at_least.or(known.at_least), ..one },
            None => before.push(one),
        }
    }
    before
}

fn declared(prepared: &Prepared) -> Result<Vec<Asked>, Failure> {
    let plan = &prepared.plan;
    if plan.envelopes.is_empty() {
        return Err(Failure::arguments(
            format!("{} declares no envelope", plan.name),
            "[[envelope]] in the plan: fault = \"drop\", at_least = 0.1; or --envelope KIND",
        ));
    }
    let lines = prepared.rig.struck();
    let asked = |declared: &DeclaredEnvelope| {
        let &DeclaredEnvelope { kind, target, at_least, share, runs } = declared;
        // The plan has been checked against its bench.
        let fault = Fault::new(struck_by(kind, target, &lines)?, kind);
        Some(Asked { fault, at_least: Some(at_least), share, runs })
    };
    Ok(plan.envelopes.iter().filter_map(asked).collect())
}

impl Means<'_> {
    fn struck(&self, kind: FaultKind) -> Result<Fault, Failure> {
        let lines = self.prepared.rig.struck();
        let asked = self.target.map(Target::named);
        if let Some(Some(target)) = asked
            && target.part().is_some()
        {
            let fault = Fault::new(target, kind);
            return fault.check(&lines).map(|()| fault).map_err(|unfit| {
                let message = format!("--target: {}", unfit.message);
                Failure::arguments(message, unfit.help.unwrap_or_default())
            });
        }
        let target = match asked {
            Some(None) => None,
            asked => struck_by(kind, asked.flatten(), &lines),
        };
        target.map(|target| Fault::new(target, kind)).ok_or_else(|| {
            let there = lines.targets(kind.info().reach).into_iter();
            let there = there.filter(|target| struck_by(kind, Some(*target), &lines).is_some());
            let known: Vec<String> = there.map(|target| target.name().to_owned()).collect();
            let what = self.target.map(|name| format!("the {name}"));
            Failure::arguments(
                format!(
                    "`{}` cannot strike {} of {}",
                    kind.name(),
                    what.as_deref().unwrap_or("anything"),
                    self.prepared.plan.name
                ),
                match known.as_slice() {
                    [] => "`hil list faults` says what each strikes".to_owned(),
                    known => format!("here it strikes: {}", known.join(", ")),
                },
            )
        })
    }

    /// A plan that fails without any fault shows nothing about one; `clean` is its run with the first seed.
    fn fails_by_itself(&self, level: &Level, clean: &CaseResult) -> Failure {
        let plan = &self.prepared.plan;
        let Level { passed, runs, .. } = level;
        let unreached = plan.demanded().into_iter().find(|state| !clean.reached.contains(state));
        let why = match (clean.violated.first(), clean.never_judged.first_key_value()) {
            (Some(broken), _) => format!("at {:.3} s: {}", broken.at_s, broken.what),
            (None, Some((property, why))) => format!("{property} is never judged: {why}"),
            (None, None) => match unreached {
                Some(state) => {
                    format!("the plan demands {state} sometimes, and the run did not reach it")
                }
                None => {
                    "`hil run` of the plan shows why, with --seeds N for several seeds".to_owned()
                }
            },
        };
        let message =
            format!("too few runs of {} pass without the fault: {passed} of {runs}", plan.name);
        Failure::arguments(message, why)
    }

    fn measure(&self, kept: &Kept<'_, Simulated>, asked: &Asked, course: &Course) -> Envelope {
        let tells = self.prepared.rig.robot.is_some();
        let settings = EnvelopeSettings {
            runs: asked.runs,
            share: asked.share,
            asked: asked.at_least,
            seed: self.seed,
            course: course.clone(),
            motions: self.prepared.plan.motions_after_bias_test(),
            demanded: self.prepared.plan.demanded(),
            tells,
            threads: self.threads,
        };
        let bar = self.screen.runs_at_most(&asked.fault.to_string(), settings.runs_max());
        let executor = Counting { executor: kept, bar };
        campaign::envelope(&executor, &asked.fault, &settings, &mut |level| {
            self.screen.chat(&console::level_line(level, &asked.fault, tells));
            !self.interrupt.requested()
        })
    }
}

/// Carries out cases and shows how many.
struct Counting<'a> {
    executor: &'a Kept<'a, Simulated>,
    bar: ProgressBar,
}

impl Executor for Counting<'_> {
    fn execute(&self, case: &Case) -> CaseResult {
        let result = self.executor.execute(case);
        self.bar.inc(1);
        result
    }
}

pub(super) fn are_in(folder: &Path) -> bool {
    folder.join(FIGURES).is_file()
}

fn figures(folder: &Path) -> io::Result<Vec<Measured>> {
    let json = std::fs::read(folder.join(FIGURES))?;
    Ok(serde_json::from_slice(&json)?)
}

/// Draws the page of the folder's envelopes from their figures; returns its path.
pub(super) fn draw(folder: &Path) -> Result<PathBuf, Failure> {
    let all = figures(folder)
        .map_err(|source| RunFolderError::Read { path: folder.join(FIGURES), source })?;
    let plan = all.first().map_or("", |measured| &measured.plan);
    let path = folder.join(REPORT);
    std::fs::write(&path, page(plan, &all)).map_err(|source| Failure::file(&path, source))?;
    Ok(path)
}

/// Returns the fault kind of this name, with typical parameters.
pub(super) fn kind(name: &str) -> Result<FaultKind, Failure> {
    FaultKind::named(name).map_err(|unknown| Failure::arguments(unknown.to_string(), unknown.help))
}
