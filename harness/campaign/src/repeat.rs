//! Repetition of cases that do not always give the same result: in real time, on a real bench.
//!
//! A case that breaks a property once is repeated `repeats` times. The first run does not count, because the case was
//! chosen for it. The case counts as broken if the repetitions show, at the given confidence, that the property breaks
//! in a share of all runs: if the exact lower bound of that share (Clopper and Pearson) is at least the requested one.
//! So a case that breaks more rarely counts as broken with a probability of at most 1 - confidence. Repetitions end as
//! soon as the decision is certain, which does not affect it.

use super::case::{Case, CaseResult, Repeated};
use super::course::Course;
use super::executor::Executor;
use super::guard::guarded;
use plan::confidence::clopper_pearson_lower;
use record::outcome::Outcome;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// Default number of repetitions: enough that one of them may hold by chance.
pub const REPEATS: u64 = 8;
/// Default confidence.
pub const CONFIDENCE: f64 = 0.95;
/// Default share of runs that must break. Assumption: a failure in every other run can be debugged.
pub const BREAKS_AT_LEAST: f64 = 0.5;
/// The most repetitions of one case.
pub const REPEATS_MAX: u64 = 10_000;

/// The rule that decides whether a case counts as broken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Rule")]
pub struct Repetition {
    repeats: u64,
    confidence: f64,
    share: f64,
    #[serde(skip)]
    needed: u64,
}

/// `broken where 7 of 8 repetitions break (0.95, 0.5)`, with confidence and share.
impl fmt::Display for Repetition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { repeats, confidence, share, needed } = self;
        write!(f, "broken where {needed} of {repeats} repetitions break ({confidence}, {share})")
    }
}

/// A rule in serialized form.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    repeats: u64,
    confidence: f64,
    share: f64,
}

impl TryFrom<Rule> for Repetition {
    type Error = RepetitionError;

    fn try_from(rule: Rule) -> Result<Self, RepetitionError> {
        Self::new(rule.repeats, rule.confidence, rule.share)
    }
}

/// Why a rule is invalid.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum RepetitionError {
    /// A value that is not a probability between 0 and 1.
    #[error("failed to repeat with {name} {value}: expected more than 0 and less than 1")]
    #[diagnostic(help("such as 0.95"))]
    NoShare {
        /// Name of the value.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The rule could not be met even if all repetitions break.
    #[error(
        "failed to show anything with {repeats} repetitions: all of them broken show a share of {shown:.2}, and \
         {share} is asked for"
    )]
    #[diagnostic(help("--repeat {enough} is the least at this confidence"))]
    TooFew {
        /// Requested number of repetitions.
        repeats: u64,
        /// The share that they could show.
        shown: f64,
        /// The requested share.
        share: f64,
        /// The number of repetitions that would suffice.
        enough: u64,
    },
}

impl Repetition {
    /// A case is broken if `repeats` repetitions show at `confidence` that at least `share` of all runs break.
    ///
    /// # Errors
    ///
    /// When this number of repetitions can never show it.
    pub fn new(repeats: u64, confidence: f64, share: f64) -> Result<Self, RepetitionError> {
        for (name, value) in [("a confidence of", confidence), ("a share of", share)] {
            if !(value > 0.0 && value < 1.0) {
                return Err(RepetitionError::NoShare { name, value });
            }
        }
        let shows = |broke, of| clopper_pearson_lower(broke, of, confidence) >= share;
        let Some(needed) = (1..=repeats.min(REPEATS_MAX)).find(|broke| shows(*broke, repeats))
        else {
            let shown = clopper_pearson_lower(repeats, repeats, confidence);
            let enough = (1..=REPEATS_MAX).find(|of| shows(*of, *of)).unwrap_or(REPEATS_MAX);
            return Err(RepetitionError::TooFew { repeats, shown, share, enough });
        };
        Ok(Self { repeats, confidence, share, needed })
    }

    /// Number of repetitions that must break.
    pub const fn needed(&self) -> u64 {
        self.needed
    }

    /// The confidence of the rule.
    pub const fn confidence(&self) -> f64 {
        self.confidence
    }

    /// The conclusion from `broke` of `of` repetitions.
    fn shown(&self, broke: u64, of: u64) -> Repeated {
        Repeated { broke, of, at_least: clopper_pearson_lower(broke, of, self.confidence) }
    }

    /// The decision after `broke` of `of` repetitions, if it is certain.
    const fn decided(&self, broke: u64, of: u64) -> Option<bool> {
        if broke >= self.needed {
            return Some(true);
        }
        let left = self.repeats - of;
        if broke + left < self.needed { Some(false) } else { None }
    }
}

/// An executor on which a case counts as broken only after repetition.
#[derive(Debug, Clone)]
pub struct Repeatedly<E> {
    inner: E,
    repetition: Repetition,
}

impl<E: Executor> Repeatedly<E> {
    /// Cases are carried out by `inner`.
    pub const fn new(inner: E, repetition: Repetition) -> Self {
        Self { inner, repetition }
    }

    /// The executor that carries out the cases.
    pub const fn inner(&self) -> &E {
        &self.inner
    }

    /// One conclusive run. A run in which the bench failed is repeated once; if that is inconclusive too, or if the run
    /// was interrupted, only the outcome is returned. A controller that panics is repeated like any other.
    fn run(&self, case: &Case) -> Result<CaseResult, Outcome> {
        let run = || guarded(&self.inner, case);
        let first = run();
        let result = if first.outcome == Outcome::Error.name() { run() } else { first };
        let nothing = [Outcome::Error, Outcome::Aborted];
        nothing.into_iter().find(|one| one.name() == result.outcome).map_or(Ok(result), Err)
    }

    /// Repeats until each broken property is decided.
    fn repeat(&self, case: &Case, first: CaseResult) -> CaseResult {
        let suspects = first.violated.iter().map(|violated| (violated.property.clone(), 0));
        let mut broke: BTreeMap<String, u64> = suspects.collect();
        let mut repeated = BTreeMap::new();
        for of in 1..=self.repetition.repeats {
            let result = match self.run(case) {
                Ok(result) => result,
                // The bench failed or the run was interrupted: the violations before that are inconclusive.
                Err(outcome) => return CaseResult::ended(outcome.name()),
            };
            broke.retain(|property, times| {
                *times += u64::from(result.breaks(property));
                let decided = self.repetition.decided(*times, of);
                if decided.is_some() {
                    repeated.insert(property.clone(), self.repetition.shown(*times, of));
                }
                decided.is_none()
            });
            if broke.is_empty() {
                break;
            }
        }
        let mut result = CaseResult { repeated, ..first };
        let shown = |property: &String| {
            result.repeated.get(property).is_some_and(|one| one.broke >= self.repetition.needed)
        };
        let kept: Vec<_> =
            result.violated.iter().filter(|one| shown(&one.property)).cloned().collect();
        result.violated = kept;
        result
    }
}

impl<E: Executor> Executor for Repeatedly<E> {
    fn execute(&self, case: &Case) -> CaseResult {
        match self.run(case) {
            Ok(first) if !first.violated.is_empty() => self.repeat(case, first),
            Ok(result) => result,
            Err(outcome) => CaseResult::ended(outcome.name()),
        }
    }

    fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
        self.inner.without_faults(seed)
    }

    /// The smallest of many cases was chosen with some luck; these repetitions are independent of the choice.
    fn confirm(&self, case: &Case, property: &str) -> Result<Repeated, Outcome> {
        let mut broke = 0;
        for _ in 0..self.repetition.repeats {
            broke += u64::from(self.run(case)?.breaks(property));
        }
        Ok(self.repetition.shown(broke, self.repetition.repeats))
    }

    fn is_stopped(&self) -> bool {
        self.inner.is_stopped()
    }

    fn kept(&self, case: &Case) {
        self.inner.kept(case);
    }

    fn takes(&self, case: &Case) -> bool {
        self.inner.takes(case)
    }
}

#[cfg(test)]
mod tests;
