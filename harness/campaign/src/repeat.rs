//! Repetition, where the same case does not always come to the same: in real time, on a real bench.
//!
//! A case that breaks a property once is carried out `repeats` times more. The first run does not count: the case
//! was chosen for it. It counts as broken where the repetitions show, at the stated confidence, that the property
//! breaks in a share of all runs: where the exact lower bound of that share (Clopper and Pearson) is no less than
//! asked for. So a case that breaks more rarely is taken for broken with a probability of at most 1 - confidence.
//! Repetitions end as soon as it is decided, which changes no decision.

use super::case::{Case, CaseResult, Repeated};
use super::executor::Executor;
use super::guard::guarded;
use plan::confidence::clopper_pearson_lower;
use record::outcome::Outcome;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use wire::time::Span;

/// Repetitions where nobody says otherwise: enough that one of them may hold by chance.
pub const REPEATS: u64 = 8;
/// Confidence where nobody says otherwise.
pub const CONFIDENCE: f64 = 0.95;
/// Share of runs that must break where nobody says otherwise. Assumption: what breaks in every other run can be
/// worked on.
pub const BREAKS_AT_LEAST: f64 = 0.5;
/// The most repetitions of one case.
pub const REPEATS_MAX: u64 = 10_000;

/// The rule by which a case counts as broken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Rule", try_from = "Rule")]
pub struct Repetition {
    repeats: u64,
    confidence: f64,
    share: f64,
    needed: u64,
}

/// `broken where 7 of 8 repetitions break (0.95, 0.5)`: with confidence and share.
impl fmt::Display for Repetition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { repeats, confidence, share, needed } = self;
        write!(f, "broken where {needed} of {repeats} repetitions break ({confidence}, {share})")
    }
}

/// A rule as it is written down.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    repeats: u64,
    confidence: f64,
    share: f64,
}

impl From<Repetition> for Rule {
    fn from(rule: Repetition) -> Self {
        let Repetition { repeats, confidence, share, .. } = rule;
        Self { repeats, confidence, share }
    }
}

impl TryFrom<Rule> for Repetition {
    type Error = RepetitionError;

    fn try_from(rule: Rule) -> Result<Self, RepetitionError> {
        Self::new(rule.repeats, rule.confidence, rule.share)
    }
}

/// Why there is no such rule.
#[derive(Debug, Clone, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum RepetitionError {
    /// No probability between 0 and 1.
    #[error("failed to repeat with {name} {value}: expected more than 0 and less than 1")]
    #[diagnostic(help("such as 0.95"))]
    NoShare {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Even if all of them break, they cannot show it.
    #[error(
        "failed to show anything with {repeats} repetitions: all of them broken show a share of {shown:.2}, and \
         {share} is asked for"
    )]
    #[diagnostic(help("--repeat {enough} is the least at this confidence"))]
    TooFew {
        /// Repetitions asked for.
        repeats: u64,
        /// What they could show.
        shown: f64,
        /// What is asked for.
        share: f64,
        /// How many could.
        enough: u64,
    },
}

impl Repetition {
    /// A case is broken where `repeats` repetitions show at `confidence` that at least `share` of all runs break.
    ///
    /// # Errors
    ///
    /// When so many can never show it.
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

    /// So many of them must break.
    pub const fn needed(&self) -> u64 {
        self.needed
    }

    /// How sure it is.
    pub const fn confidence(&self) -> f64 {
        self.confidence
    }

    /// What `broke` of `of` show.
    fn shown(&self, broke: u64, of: u64) -> Repeated {
        Repeated { broke, of, at_least: clopper_pearson_lower(broke, of, self.confidence) }
    }

    /// Is it decided after `broke` of `of`, and how?
    const fn decided(&self, broke: u64, of: u64) -> Option<bool> {
        if broke >= self.needed {
            return Some(true);
        }
        let left = self.repeats - of;
        if broke + left < self.needed { Some(false) } else { None }
    }
}

/// An executor on which only what breaks again and again is broken.
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

    /// Whoever carries them out.
    pub const fn inner(&self) -> &E {
        &self.inner
    }

    /// One run that says something; one that the bench broke is done again, once. Where that says nothing, either, and
    /// where somebody stopped it, the outcome is all that there is. A controller that panics is repeated as any other.
    fn run(&self, case: &Case) -> Result<CaseResult, Outcome> {
        let run = || guarded(&self.inner, case);
        let first = run();
        let result = if first.outcome == Outcome::Error.name() { run() } else { first };
        let nothing = [Outcome::Error, Outcome::Aborted];
        nothing.into_iter().find(|one| one.name() == result.outcome).map_or(Ok(result), Err)
    }

    /// Repeats until each property that broke is decided.
    fn repeat(&self, case: &Case, first: CaseResult) -> CaseResult {
        let suspects = first.violated.iter().map(|violated| (violated.property.clone(), 0));
        let mut broke: BTreeMap<String, u64> = suspects.collect();
        let mut repeated = BTreeMap::new();
        for of in 1..=self.repetition.repeats {
            let result = match self.run(case) {
                Ok(result) => result,
                // The bench broke, or somebody stopped it: whatever broke before says nothing.
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

    fn without_faults(&self, seed: u64) -> (Span, CaseResult) {
        self.inner.without_faults(seed)
    }

    /// What was chosen as the smallest of many is lucky; these repetitions are not.
    fn confirm(&self, case: &Case, property: &str) -> Result<Repeated, Outcome> {
        let mut broke = 0;
        for _ in 0..self.repetition.repeats {
            broke += u64::from(self.run(case)?.breaks(property));
        }
        Ok(self.repetition.shown(broke, self.repetition.repeats))
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
