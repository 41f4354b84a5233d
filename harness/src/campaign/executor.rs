//! Who carries out a case.

use super::case::{Case, CaseResult, Violated};
use crate::checks::judge_all;
use crate::operator::Answers;
use crate::outcome::Outcome;
use crate::properties::{Kind, PropertyVerdict};
use crate::record::sink::NullSink;
use crate::run::{Prepared, simulate_watched};
use crate::world::bench::bench_lines;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

/// Carries out cases. The same case gives the same result, but on a real bench.
pub trait Executor: Sync {
    /// Carries out `case`.
    fn execute(&self, case: &Case) -> CaseResult;

    /// Can `case` be carried out at all?
    fn takes(&self, case: &Case) -> bool {
        let _ = case;
        true
    }
}

/// In virtual time, on emulated devices, every byte and frame on its way; nothing is recorded.
#[derive(Debug, Clone)]
pub struct Simulated {
    prepared: Prepared,
    answers: Answers,
}

impl Simulated {
    /// Of a plan; what a person would be asked is answered by `answers`.
    pub const fn new(prepared: Prepared, answers: Answers) -> Self {
        Self { prepared, answers }
    }

    /// The plan with the faults of a case beside its own.
    fn with(&self, case: &Case) -> Prepared {
        let mut prepared = self.prepared.clone();
        let plan = Arc::make_mut(&mut prepared.plan);
        plan.faults.faults.extend(case.schedule.faults.iter().cloned());
        prepared
    }

    /// How long the plan takes where nothing goes wrong, and what it comes to then.
    pub fn without_faults(&self, seed: u64) -> (Span, CaseResult) {
        self.run(&Case { seed, ..Case::default() })
    }

    fn run(&self, case: &Case) -> (Span, CaseResult) {
        let prepared = self.with(case);
        let (run, verdicts) =
            simulate_watched(&prepared, case.seed, &self.answers, &mut NullSink, &mut |_| true);
        let (measured, judged) = judge_all(&prepared.plan.measurements, &run.observations);
        let _ = judged;
        let is_whole = run.ending.outcome == Outcome::Passed;
        let passed = is_whole && measured.iter().all(|one| one.verdict.is_acceptable());
        let result = CaseResult {
            outcome: run.ending.outcome.name().to_owned(),
            violated: verdicts.iter().filter_map(violated).collect(),
            margins: verdicts
                .iter()
                .filter_map(|verdict| Some((verdict.name.to_owned(), verdict.margin?)))
                .collect(),
            reached: verdicts
                .iter()
                .filter(|verdict| verdict.kind == Kind::Sometimes && verdict.held)
                .map(|verdict| verdict.name.to_owned())
                .collect(),
            passed,
        };
        (run.end - Timestamp::ZERO, result)
    }
}

fn violated(verdict: &PropertyVerdict) -> Option<Violated> {
    let violation = verdict.first_violation.as_ref()?;
    Some(Violated {
        property: verdict.name.to_owned(),
        at_s: (violation.at - Timestamp::ZERO).as_secs_f64(),
        what: violation.what.clone(),
    })
}

impl Executor for Simulated {
    fn execute(&self, case: &Case) -> CaseResult {
        self.run(case).1
    }

    fn takes(&self, case: &Case) -> bool {
        let prepared = self.with(case);
        let faults = &prepared.plan.faults;
        faults.check(&prepared.plan).is_ok()
            && faults.check_bench(bench_lines(&prepared.devices)).is_ok()
    }
}
