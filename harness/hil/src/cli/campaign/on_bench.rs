//! `hil campaign --clock real`: cases on a bench of this machine or of a worker.

use super::account::{Kept, Place};
#[cfg(feature = "nats")]
use super::over;
use super::saved;
use super::{Begun, CampaignArguments, JOURNAL, Task};
use crate::cli::failure::Failure;
use crate::cli::setup::Setup;
#[cfg(feature = "nats")]
use crate::cli::worker::bench_place;
use campaign::{
    BREAKS_AT_LEAST, CONFIDENCE, Executor, Journal, REPEATS, REPEATS_MAX, Repeatedly, Repetition,
    Settings,
};
use clap::Args;
use harness::executors::{Bench, OnBench, Site};
use harness::operator::{Answers, Person};
use harness::run_live::{DEVICE_LOG, LiveSetting};
use harness::stopwatch::Stopwatch;
use record::figures;
use record::outcome::Outcome;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use views::console::Again;

/// Default attempts to shrink one case: each takes as long as the plan, and longer if it fails.
const SHRINK_MAX: u64 = 20;

/// Who carries out cases, as shown on the page of a campaign.
const HERE: &str = "a bench in real time, one case at a time";
/// See [`HERE`].
#[cfg(feature = "nats")]
const A_WORKER: &str = "a bench of a worker in real time, one case at a time";

/// When a case counts as broken on a bench, where the same case does not always come to the same.
#[derive(Debug, Clone, Args)]
pub(in crate::cli) struct RepetitionArguments {
    /// With --clock real: repetitions of a case that broke a property; the first run does not
    /// count. [default: 8]
    #[arg(long, value_name = "N", conflicts_with_all = ["envelope", "envelopes"],
          value_parser = clap::value_parser!(u64).range(1..=REPEATS_MAX))]
    repeat: Option<u64>,
    /// With --clock real: confidence that the property breaks in the share of --breaks-at-least.
    /// [default: 0.95]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    confidence: Option<f64>,
    /// With --clock real: share of all runs in which a property must break to count as broken. [default: 0.5]
    #[arg(long, value_name = "SHARE", conflicts_with_all = ["envelope", "envelopes"])]
    breaks_at_least: Option<f64>,
}

impl RepetitionArguments {
    /// Refuses repetitions: in virtual time nothing is repeated.
    pub(super) fn none(&self) -> Result<(), Failure> {
        let asked =
            self.repeat.is_some() || self.confidence.is_some() || self.breaks_at_least.is_some();
        if asked {
            return Err(Failure::arguments(
                "the virtual clock has no use for repetition: the same case always comes to the same",
                "add --clock real, or leave out --repeat, --confidence and --breaks-at-least",
            ));
        }
        Ok(())
    }

    pub(super) fn rule(&self) -> Result<Repetition, Failure> {
        Ok(Repetition::new(
            self.repeat.unwrap_or(REPEATS),
            self.confidence.unwrap_or(CONFIDENCE),
            self.breaks_at_least.unwrap_or(BREAKS_AT_LEAST),
        )?)
    }
}

/// A finished campaign on a bench.
struct Over<'a> {
    kept: Kept,
    done: campaign::Campaign,
    saved: Vec<PathBuf>,
    again: Again<'a>,
}

/// What carries out the cases of a bench.
struct Hands<'a, E> {
    executor: &'a E,
    /// What the bench offers for observation and faults.
    bench: &'a OnBench,
    name: &'a str,
    /// Error that prevents further cases.
    broken: &'a dyn Fn() -> Result<(), Failure>,
}

impl CampaignArguments {
    pub(super) fn on_bench(
        &self,
        task: &Task<'_>,
        setup: &Setup,
        live: &LiveSetting,
    ) -> Result<Outcome, Failure> {
        let Task { prepared, interrupt, screen, .. } = *task;
        let rule = self.repetition.rule()?;
        #[cfg(feature = "nats")]
        let elsewhere = match self.over.server()? {
            Some(server) => Some((server, self.setup.bench_elsewhere()?)),
            None => None,
        };
        let setting = live.resolve(&prepared.rig)?;
        setting.fits(&prepared.plan)?;
        let (folder, _held) = self.opened(prepared)?;
        // Origin of the journal: on another bench, or by another rule, a case has another result.
        let bench = format!(", in real time: {setting}, {rule}");
        #[cfg(feature = "nats")]
        let bench = match &elsewhere {
            Some((_, file)) => format!("{bench}, {} of a worker", bench_place(file)?),
            None => bench,
        };
        let what = self.what(task, &bench);
        let stop = interrupt.clone();
        let mut site = Site {
            bench: Bench::default(),
            answers: Answers::default(),
            person: None,
            stop: Box::new(move || stop.requested()),
            log: folder.join(DEVICE_LOG),
        };
        #[cfg(feature = "nats")]
        if let Some((server, bench)) = elsewhere {
            site.answers = self.operator.collect_for_elsewhere(setup, [&*prepared.plan])?;
            let order = over::Order { plan: &self.plan, what: &what, answers: &site.answers };
            let order = order.on_bench(bench, rule)?;
            let here = OnBench::new(prepared.clone(), setting, site);
            let remote = over::open(&server, order, here, interrupt, screen)?;
            let failed = || remote.failure().map_or(Ok(()), |failure| Err(failure.into()));
            let hands =
                Hands { executor: &remote, bench: remote.local(), name: A_WORKER, broken: &failed };
            let over = self.carry_on(task, folder, &what, &hands, rule)?;
            let Some(Over { kept, done, saved, again }) = over else { return Ok(Outcome::Aborted) };
            if !done.stopped && !interrupt.requested() {
                over::finish(&remote, &done, &saved, Some(&again))?;
            }
            return self.tell(screen, kept, (&done, &saved), Some(&again));
        }
        let (answers, person) = self.operator.collect(setup, [&*prepared.plan], screen)?;
        let _lease = self.setup.lease(setup, &|| interrupt.requested(), screen)?;
        site.answers = answers;
        site.person = person.map(|person| -> Box<dyn Fn() -> Box<dyn Person> + Send + Sync> {
            Box::new(move || Box::new(person.clone()))
        });
        let executor = Repeatedly::new(OnBench::new(prepared.clone(), setting, site), rule);
        let here = executor.inner();
        let broken = || here.take_broken().map_or(Ok(()), |error| Err(Failure::from(error)));
        let hands = Hands { executor: &executor, bench: here, name: HERE, broken: &broken };
        let over = self.carry_on(task, folder, &what, &hands, rule)?;
        let Some(Over { kept, done, saved, again }) = over else { return Ok(Outcome::Aborted) };
        self.tell(screen, kept, (&done, &saved), Some(&again))
    }

    /// Runs everything from the run without faults to the repetitions of the smallest cases. `None` if stopped before
    /// the start.
    fn carry_on<'a, E: Executor>(
        &self,
        task: &Task<'_>,
        folder: PathBuf,
        what: &str,
        hands: &Hands<'a, E>,
        rule: Repetition,
    ) -> Result<Option<Over<'a>>, Failure> {
        let Task { prepared, interrupt, screen, .. } = *task;
        let Hands { executor, bench, name, broken } = *hands;
        let watch = Stopwatch::start();
        let (course, clean) = executor.without_faults(self.seed);
        let each_s = watch.elapsed_s();
        broken()?;
        if clean.outcome != Outcome::Passed.name() {
            if interrupt.requested() {
                return Ok(None);
            }
            return Err(Failure::arguments(
                format!(
                    "{} ends in {} on this bench without any fault",
                    prepared.plan.name, clean.outcome
                ),
                format!("run it there by itself to see why: hil run {} --clock real", self.plan),
            ));
        }
        let path = folder.join(JOURNAL);
        let journal = Journal::open_with(&path, what, Some(course.clone()))?;
        let course = journal.course().cloned().unwrap_or(course);
        let can_suffer = |target, what| bench.can_suffer(target, what);
        let states = prepared.plan.unreached(bench.properties(), &clean.reached);
        let space = self.space(task, (course, clean), can_suffer)?;
        for one in bench.unjudged() {
            screen.note(&format!("{} not judged: {}", one.name, one.why));
        }
        screen.note(&format!(
            "the run without faults took {}: {} take about {}, and more where one breaks a property",
            figures::duration(each_s),
            figures::counted(self.cases, "case", "cases"),
            figures::duration(each_s * self.cases as f64)
        ));
        let shrink_max = self.shrink_max(SHRINK_MAX);
        let settings = Settings { cases: self.cases, threads: NonZeroUsize::MIN, shrink_max };
        let begun = Begun { journal, earlier: saved::earlier(&folder), folder };
        let again = self.again();
        let place = Place { carried_out_by: name.to_owned(), replay: &again };
        let kept = self.account(task, &space, &states, place)?;
        let (done, saved) = self.search(task, begun, executor, &space, &states, &settings)?;
        broken()?;
        let confirmed = done.found.iter();
        let confirmed =
            confirmed.map(|found| executor.confirm(&found.shrunk.case, &found.property).ok());
        let confirmed = confirmed.collect();
        broken()?;
        let (unjudged, confidence) = (bench.unjudged(), rule.confidence());
        Ok(Some(Over { kept, done, saved, again: Again { confirmed, unjudged, confidence } }))
    }
}
