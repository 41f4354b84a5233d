//! Repeats steps.

use super::wait_until::Condition;
use super::{Known, Op, Step, StepKind, some_steps};
use crate::Checked;
use crate::number;
use crate::survey::Survey;
use crate::time_limits::SLACK;
use described::Place;
use schemars::JsonSchema;
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer};
use std::fmt;
use wire::time::Span;

/// Most repetitions of one repeat.
pub const REPEAT_TIMES_MAX: u32 = 100_000;

/// Steps, again and again.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// How often, at most.
    #[serde(deserialize_with = "times")]
    #[schemars(range(min = 1, max = REPEAT_TIMES_MAX))]
    pub times: u32,
    /// From the begin of one repetition to the begin of the next; one that takes longer is followed at once.
    #[serde(rename = "period_s", default, with = "number::Duration")]
    pub period: Option<Span>,
    /// No further repetition begins once this holds.
    #[serde(default)]
    pub until: Option<Condition>,
    /// What is repeated.
    #[serde(deserialize_with = "some_steps")]
    #[schemars(length(min = 1))]
    pub steps: Vec<Step>,
}

impl StepKind for Repeat {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.times {
            1 => f.write_str("repeat once"),
            times => write!(f, "repeat {times} times"),
        }
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(Vec::new())
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        let Some(until) = &self.until else { return Ok(()) };
        let keys = at.key("until").key(until.name()).key("quantity");
        survey.subject.awaited(until.quantity(), &keys)
    }

    fn limit(&self) -> Span {
        let steps = Step::sum_of_limits(&self.steps);
        let once = self.period.map_or(steps, |period| period.max(steps));
        once * i64::from(self.times) + SLACK
    }

    fn steps(&self) -> &[Step] {
        &self.steps
    }

    fn repetitions(&self) -> u64 {
        u64::from(self.times)
    }
}

fn times<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    let times = i64::deserialize(deserializer)?;
    u32::try_from(times).ok().filter(|times| (1..=REPEAT_TIMES_MAX).contains(times)).ok_or_else(
        || de::Error::invalid_value(Unexpected::Signed(times), &"1 to 100000 repetitions"),
    )
}
