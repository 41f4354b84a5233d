//! Runs cases in real time, one at a time: emulated devices on ports, real ones, any device under test.

use super::clocked::Clocked;
use super::simulated::{result, struck};
use crate::campaign::{Case, CaseResult, Course, Executor};
use crate::faults::{FaultKind, Target};
use crate::plan::Property;
use crate::properties::Unjudged;
use crate::record::sink::NullSink;
use crate::run::Prepared;
use crate::run_live::{LiveOrder, carry_out};
use live::world::{LiveError, Setting};
use rig::Sink;
use rig::operator::{Answers, Operator, Person};
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wire::time::{Span, Timestamp};

/// A bench that campaigns share: one run at a time, and no more runs once it has failed to come up.
#[derive(Debug, Clone, Default)]
pub struct Bench(Arc<Mutex<Option<LiveError>>>);

impl Bench {
    /// Why the bench did not come up, if it failed. Waits for a run in progress.
    pub fn take_broken(&self) -> Option<LiveError> {
        self.turn().take()
    }

    /// Waits for its turn; returns the failure of the bench, if there was one.
    fn turn(&self) -> MutexGuard<'_, Option<LiveError>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a campaign needs from its site.
pub struct Site {
    /// The bench.
    pub bench: Bench,
    /// Answers to questions of the plan.
    pub answers: Answers,
    /// Makes a person who answers the other questions, anew for each run.
    pub person: Option<Box<dyn Fn() -> Box<dyn Person> + Send + Sync>>,
    /// Whether the user wants the campaign to stop.
    pub stop: Box<dyn Fn() -> bool + Send + Sync>,
    /// File for the stderr of the device under test, of the last run.
    pub log: PathBuf,
}

impl fmt::Debug for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Site").field("log", &self.log).finish_non_exhaustive()
    }
}

/// Runs cases on a bench in real time. The result of a case may differ the next time:
/// [`Repeatedly`](crate::campaign::Repeatedly) decides what to believe.
#[derive(Debug)]
pub struct OnBench {
    prepared: Prepared,
    setting: Setting,
    properties: Vec<Property>,
    unjudged: Vec<Unjudged>,
    site: Site,
}

impl OnBench {
    /// Creates an executor for a plan on the bench of `setting`. It judges the properties of the plan, or all if the
    /// plan declares none, as far as this bench can judge them.
    pub fn new(prepared: Prepared, setting: Setting, site: Site) -> Self {
        let (properties, unjudged) = setting.sight().divide(&prepared.plan.judged(&prepared.rig));
        Self { prepared, setting, properties, unjudged, site }
    }

    /// The properties that are judged.
    pub fn properties(&self) -> &[Property] {
        &self.properties
    }

    /// The properties that this bench cannot judge.
    pub fn unjudged(&self) -> &[Unjudged] {
        &self.unjudged
    }

    /// Whether a fault of this kind can be injected here.
    pub fn can_suffer(&self, target: Target, what: FaultKind) -> bool {
        self.setting.can_suffer(target, what)
    }

    /// Why the bench did not come up, if it failed; further runs are not attempted.
    pub fn take_broken(&self) -> Option<LiveError> {
        self.site.bench.take_broken()
    }

    fn run(&self, case: &Case, sink: Sink<'_>) -> (Span, CaseResult) {
        let not_run = || (Span::ZERO, CaseResult::given_up());
        let mut broken = self.site.bench.turn();
        if broken.is_some() || (self.site.stop)() {
            return not_run();
        }
        let prepared = struck(&self.prepared, case);
        let order = LiveOrder {
            prepared: &prepared,
            seed: case.seed,
            setting: &self.setting,
            properties: &self.properties,
            log: &self.site.log,
        };
        let person = self.site.person.as_ref().map(|person| person());
        let operator = Operator::live(self.site.answers.clone(), person);
        match carry_out(order, operator, sink, &mut |_| !(self.site.stop)()) {
            Ok(live) => {
                let result = result(&self.prepared, &live.run);
                (live.run.end - Timestamp::ZERO, result)
            }
            Err(error) => {
                *broken = Some(error);
                not_run()
            }
        }
    }
}

impl Executor for OnBench {
    fn execute(&self, case: &Case) -> CaseResult {
        self.run(case, &mut NullSink).1
    }

    fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
        let mut clocked = Clocked::new(&self.prepared.plan);
        let (lasted, result) = self.run(&Case { seed, ..Case::default() }, &mut clocked);
        (clocked.course(lasted), result)
    }

    fn is_stopped(&self) -> bool {
        (self.site.stop)()
    }

    fn takes(&self, case: &Case) -> bool {
        let plan = &self.prepared.plan;
        let all = case.schedule.beside(&plan.faults);
        let lines = self.prepared.rig.struck();
        all.fits(plan, &lines).is_ok() && self.setting.reaches(&all).is_ok()
    }
}
