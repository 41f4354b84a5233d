//! Repeats steps, once for each value of a parameter.

use super::{Known, Op, Order, Step, StepKind, some_steps};
use crate::Checked;
use crate::name::ParameterName;
use crate::number;
use crate::survey::Survey;
use crate::time_limits::{PERSON_LIMIT, SLACK};
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// Most values of one sweep.
pub const SWEEP_VALUES_MAX: usize = 1_000;

/// Steps, once for each value of a parameter.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(try_from = "SweepFields")]
pub struct Sweep {
    /// Which; also the tag that carries its value.
    pub parameter: ParameterName,
    /// Its values, in order.
    pub values: Vec<f64>,
    /// What is done with each.
    pub steps: Vec<Step>,
}

/// A sweep as it is written: either `values`, or `from`, `to` and `count`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["values"] }, { "required": ["from", "to", "count"] }]))]
struct SweepFields {
    /// Which; also the tag that carries its value.
    parameter: ParameterName,
    /// Its values, in order.
    #[serde(default)]
    #[schemars(length(min = 1, max = SWEEP_VALUES_MAX))]
    values: Option<Vec<Value>>,
    /// The first value.
    #[serde(default, with = "number::Finite")]
    from: Option<f64>,
    /// The last value.
    #[serde(default, with = "number::Finite")]
    to: Option<f64>,
    /// How many values, evenly from the first to the last.
    #[serde(default)]
    #[schemars(range(min = 2, max = SWEEP_VALUES_MAX))]
    count: Option<usize>,
    /// What is done with each.
    #[serde(deserialize_with = "some_steps")]
    #[schemars(length(min = 1))]
    steps: Vec<Step>,
}

#[derive(Deserialize, JsonSchema)]
struct Value(#[serde(with = "number::Finite")] f64);

impl TryFrom<SweepFields> for Sweep {
    type Error = String;

    fn try_from(fields: SweepFields) -> Result<Self, String> {
        let values = match (fields.values, fields.from, fields.to, fields.count) {
            (Some(values), None, None, None) => values.into_iter().map(|Value(v)| v).collect(),
            (None, Some(from), Some(to), Some(count))
                if (2..=SWEEP_VALUES_MAX).contains(&count) =>
            {
                evenly(from, to, count)
            }
            (None, Some(_), Some(_), Some(count)) => {
                return Err(format!("a sweep of {count} values, expected 2 to {SWEEP_VALUES_MAX}"));
            }
            _ => {
                return Err("a sweep needs either `values`, or `from`, `to` and `count`".to_owned());
            }
        };
        if values.is_empty() || values.len() > SWEEP_VALUES_MAX {
            let length = values.len();
            return Err(format!("a sweep of {length} values, expected 1 to {SWEEP_VALUES_MAX}"));
        }
        Ok(Self { parameter: fields.parameter, values, steps: fields.steps })
    }
}

/// `count` values from `from` to `to`, at least two, both ends exact.
fn evenly(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count - 1;
    let value = |index: usize| {
        let share = index as f64 / last as f64;
        from * (1.0 - share) + to * share
    };
    (0..count).map(value).collect()
}

impl StepKind for Sweep {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "sweep {} over {} values", self.parameter, self.values.len())
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(Vec::new())
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.swept.push(self.parameter.to_string());
        survey.subject.parameter(&self.parameter, &self.values, at)
    }

    fn limit(&self) -> Span {
        let values = i64::try_from(self.values.len()).unwrap_or(i64::MAX);
        (Step::sum_of_limits(&self.steps) + PERSON_LIMIT) * values + SLACK
    }

    fn steps(&self) -> &[Step] {
        &self.steps
    }

    fn repetitions(&self) -> u64 {
        self.values.len() as u64
    }
}

impl Sweep {
    /// The parameter to set before the round with this number, from 0.
    pub fn order(&self, round: usize) -> Option<Order> {
        self.values.get(round).map(|value| Order::set(&self.parameter, *value))
    }

    /// The parameter to set before each round.
    pub fn orders(&self) -> impl Iterator<Item = Order> {
        (0..self.values.len()).filter_map(|round| self.order(round))
    }
}

#[cfg(test)]
mod tests {
    use super::evenly;

    #[test]
    fn a_sweep_reaches_both_ends_exactly() {
        let values = evenly(-0.1, 0.3, 5);
        assert_eq!((values.len(), values[0], values[4]), (5, -0.1, 0.3));
        for (value, expected) in values.iter().zip([-0.1, 0.0, 0.1, 0.2, 0.3]) {
            assert!((value - expected).abs() < 1e-15, "{value} is not {expected}");
        }
        assert_eq!(evenly(3.0, 1.0, 2), vec![3.0, 1.0]);
    }
}
