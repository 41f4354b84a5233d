//! Steps that repeat other steps, and those that ask a person.

use super::band::Band;
use super::name::{Name, ParameterName};
use super::number;
use super::rest::Condition;
use super::step::Step;
use schemars::JsonSchema;
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer};
use wire::time::Span;

/// Most repetitions of one repeat.
pub const REPEAT_TIMES_MAX: u32 = 100_000;
/// Most values of one sweep.
pub const SWEEP_VALUES_MAX: usize = 1_000;
/// Longest text shown to an operator, in bytes.
pub const PROMPT_LEN_MAX: usize = 500;

/// Steps, again and again.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// How often, at most.
    #[serde(deserialize_with = "times")]
    #[schemars(range(min = 1, max = REPEAT_TIMES_MAX))]
    pub times: u32,
    /// From the begin of one repetition to the begin of the next; one that takes longer is followed at once.
    #[serde(rename = "period_s", default, deserialize_with = "number::duration_option")]
    #[schemars(schema_with = "number::schema::duration_option")]
    pub period: Option<Span>,
    /// No further repetition begins once this holds.
    #[serde(default)]
    pub until: Option<Condition>,
    /// What is repeated.
    #[serde(deserialize_with = "some_steps")]
    #[schemars(length(min = 1))]
    pub steps: Vec<Step>,
}

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
    #[serde(default, deserialize_with = "number::finite_option")]
    #[schemars(schema_with = "number::schema::finite_option")]
    from: Option<f64>,
    /// The last value.
    #[serde(default, deserialize_with = "number::finite_option")]
    #[schemars(schema_with = "number::schema::finite_option")]
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
struct Value(
    #[serde(deserialize_with = "number::finite")]
    #[schemars(schema_with = "number::schema::finite")]
    f64,
);

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

/// Something that a person does or tells.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OperatorPrompt {
    /// What is shown.
    #[serde(deserialize_with = "prompt")]
    #[schemars(length(min = 1, max = PROMPT_LEN_MAX))]
    pub text: String,
    /// What is asked for; a key press where it is absent.
    #[serde(default)]
    pub answer: Option<Answer>,
}

/// A number that a person gives; observed as `operator.<name>`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Its name.
    pub name: Name,
    /// Its unit.
    pub unit: String,
    /// What is taken; anything else is asked for again.
    pub range: Band,
    /// Its standard uncertainty.
    #[serde(default, deserialize_with = "uncertainty")]
    #[schemars(range(min = 0))]
    pub uncertainty: f64,
}

fn times<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    let times = i64::deserialize(deserializer)?;
    u32::try_from(times).ok().filter(|times| (1..=REPEAT_TIMES_MAX).contains(times)).ok_or_else(
        || de::Error::invalid_value(Unexpected::Signed(times), &"1 to 100000 repetitions"),
    )
}

fn uncertainty<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let value = number::finite(deserializer)?;
    if value < 0.0 {
        return Err(de::Error::invalid_value(Unexpected::Float(value), &"0 or more"));
    }
    Ok(value)
}

fn prompt<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let text = String::deserialize(deserializer)?;
    if text.trim().is_empty() || text.len() > PROMPT_LEN_MAX {
        return Err(de::Error::invalid_length(text.len(), &"a text of 1 to 500 bytes"));
    }
    Ok(text)
}

/// Steps, at least one.
pub(super) fn some_steps<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Step>, D::Error> {
    let steps = Vec::deserialize(deserializer)?;
    if steps.is_empty() {
        return Err(de::Error::custom("no steps, expected at least one"));
    }
    Ok(steps)
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
