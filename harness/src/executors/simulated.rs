//! Runs cases in virtual time.

use super::beginnings::Beginnings;
use super::clocked::Clocked;
use super::passes;
use crate::campaign::{Case, CaseResult, Course, Executor, KEEPS_RUNNING, Violated};
use crate::outcome::Outcome;
use crate::properties::{Kind, PropertyVerdict};
use crate::record::sink::NullSink;
use crate::run::{self, Prepared, Underway, simulate_watched};
use rig::Sink;
use rig::operator::Answers;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use wire::time::{Span, Timestamp};

/// How often a run looks whether a property is broken, in bench time.
const LOOK_EVERY: Span = Span::from_secs(1);

/// Runs cases in virtual time on emulated devices, with every byte and frame carried; nothing is recorded.
#[derive(Debug, Clone)]
pub struct Simulated {
    prepared: Prepared,
    answers: Answers,
    /// Whether the plan has to pass, in place of its properties.
    must_pass: bool,
    beginnings: Arc<Beginnings>,
    stop: Arc<AtomicBool>,
}

impl Simulated {
    /// Creates an executor for a plan; `answers` answer its questions.
    pub fn new(prepared: Prepared, answers: Answers) -> Self {
        let (beginnings, stop) = Default::default();
        Self { prepared, answers, must_pass: false, beginnings, stop }
    }

    /// Requires that the plan [passes](crate::campaign::PASSES), in place of its properties.
    pub fn that_must_pass(self) -> Self {
        Self { must_pass: true, ..self }
    }

    /// No further case is tried once `stop` is set.
    pub fn stopped_by(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop, ..self }
    }

    /// Answers to questions of the plan.
    pub const fn answers(&self) -> &Answers {
        &self.answers
    }

    fn run(&self, case: &Case) -> CaseResult {
        let run = match self.beginning(case) {
            Some(underway) => underway.into_end(&mut NullSink),
            None => self.whole(case, &mut NullSink),
        };
        self.result(&run)
    }

    /// The run of `case` from its beginning.
    fn whole(&self, case: &Case, sink: Sink<'_>) -> run::Ended {
        let struck = struck(&self.prepared, case);
        simulate_watched(&struck, case.seed, &self.answers, sink, &mut |_| true)
    }

    fn result(&self, run: &run::Ended) -> CaseResult {
        if !self.must_pass {
            return result(&self.prepared, run);
        }
        let (measurements, judged) = run.judge(&self.prepared.plan.measurements);
        let acted = acted(&self.prepared, run);
        CaseResult { acted, ..passes::result(run, &measurements, judged) }
    }

    /// The run of `case` shortly before its first fault, if it can go on from a snapshot.
    fn beginning(&self, case: &Case) -> Option<Underway> {
        let shares = self.prepared.plan.faults.is_empty() && !case.schedule.is_empty();
        let of_case = (case.seed, &case.schedule);
        shares.then(|| self.beginnings.before(&self.prepared, of_case, &self.answers)).flatten()
    }
}

/// Adds the faults of a case to those of the plan.
pub(super) fn struck(prepared: &Prepared, case: &Case) -> Prepared {
    let mut prepared = prepared.clone();
    let plan = Arc::make_mut(&mut prepared.plan);
    plan.faults = case.schedule.beside(&plan.faults);
    prepared
}

/// Result of a run of the plan with the faults of a case.
pub(super) fn result(prepared: &Prepared, run: &run::Ended) -> CaseResult {
    let (measurements, judged) = run.judge(&prepared.plan.measurements);
    let acted = acted(prepared, run);
    if prepared.plan.judged(&prepared.rig).is_empty() {
        return CaseResult { acted, ..passes::result(run, &measurements, judged) };
    }
    let verdicts = &run.properties;
    let never_judged: BTreeMap<_, _> = verdicts.iter().filter_map(never_judged).collect();
    CaseResult {
        outcome: run.ending.outcome.name().to_owned(),
        reason: run.ending.reason.clone(),
        violated: verdicts.iter().filter_map(violated).chain(lost(run)).collect(),
        margins: verdicts
            .iter()
            .filter_map(|verdict| Some((verdict.name.to_owned(), verdict.margin?)))
            .collect(),
        reached: verdicts
            .iter()
            .filter(|verdict| verdict.kind == Kind::Sometimes && verdict.held)
            .map(|verdict| verdict.name.to_owned())
            .collect(),
        never_asked: verdicts
            .iter()
            .filter(|verdict| verdict.never_asked.is_some())
            .map(|verdict| verdict.name.clone())
            .collect(),
        repeated: BTreeMap::new(),
        acted,
        passed: run.ending.outcome.max(judged) == Outcome::Passed && never_judged.is_empty(),
        never_judged,
        announced: run.announced,
        stopped: false,
    }
}

/// How often each fault of a case acted: they stand behind those of the plan.
fn acted(prepared: &Prepared, run: &run::Ended) -> Vec<u64> {
    let of_case = run.faults.iter().skip(prepared.plan.faults.faults.len());
    of_case.map(|fault| fault.acted).collect()
}

/// A sometimes-property has nothing to judge until it occurs.
fn never_judged(verdict: &PropertyVerdict) -> Option<(String, String)> {
    let why = verdict.never_judged.as_ref().filter(|_| verdict.kind == Kind::Always)?;
    Some((verdict.name.clone(), why.what.clone()))
}

/// A program under test that ended: whatever the plan declares, no fault may do that to it.
fn lost(run: &run::Ended) -> Option<Violated> {
    run.ending.lost.then(|| Violated {
        property: KEEPS_RUNNING.to_owned(),
        at_s: run.end.as_secs_f64(),
        what: run.ending.reason.clone().unwrap_or_default(),
    })
}

fn violated(verdict: &PropertyVerdict) -> Option<Violated> {
    let violation = verdict.first_violation.as_ref()?;
    Some(Violated {
        property: verdict.name.to_owned(),
        at_s: violation.at.as_secs_f64(),
        what: violation.what.clone(),
    })
}

impl Executor for Simulated {
    fn execute(&self, case: &Case) -> CaseResult {
        self.run(case)
    }

    fn execute_until(&self, case: &Case, property: &str) -> CaseResult {
        let Some(mut underway) = self.beginning(case) else { return self.execute(case) };
        let mut until = underway.simulation.now();
        loop {
            if let Some((name, violation)) = underway.simulation.broken(property) {
                let (at_s, what) = (violation.at.as_secs_f64(), violation.what.clone());
                let violated = vec![Violated { property: name.to_owned(), at_s, what }];
                let outcome = Outcome::Aborted.name();
                return CaseResult { violated, stopped: true, ..CaseResult::ended(outcome) };
            }
            until += LOOK_EVERY;
            if !underway.run_before(until) {
                return self.result(&underway.into_end(&mut NullSink));
            }
        }
    }

    fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
        let mut clocked = Clocked::new(&self.prepared.plan);
        let run = self.whole(&Case { seed, ..Case::default() }, &mut clocked);
        (clocked.course(run.end - Timestamp::ZERO), self.result(&run))
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn takes(&self, case: &Case) -> bool {
        let plan = &self.prepared.plan;
        let lines = self.prepared.rig.struck();
        case.schedule.beside(&plan.faults).fits(plan, &lines).is_ok()
    }
}
