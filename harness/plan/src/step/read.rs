//! Parses a step: a table with one key that names the action, and optionally `label` and `time_limit_s`.

use super::{Action, KEYS, LABEL, Step, TIME_LIMIT};
use crate::number;
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use wire::time::Span;

/// A key of a step; a second action is rejected here, so that the error points at it.
struct KeySeed {
    action: Option<&'static str>,
}

impl<'de> DeserializeSeed<'de> for KeySeed {
    type Value = String;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<String, D::Error> {
        let key = String::deserialize(deserializer)?;
        if !KEYS.contains(&key.as_str()) {
            return Err(de::Error::unknown_field(&key, KEYS));
        }
        match self.action {
            Some(first) if key != LABEL && key != TIME_LIMIT => Err(de::Error::custom(
                format_args!("`{key}` beside `{first}`, expected one action in a step"),
            )),
            _ => Ok(key),
        }
    }
}

#[derive(Deserialize)]
#[serde(transparent)]
struct TimeLimit(#[serde(with = "number::Duration")] Span);

struct StepVisitor;

impl<'de> Visitor<'de> for StepVisitor {
    type Value = Step;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a step such as `{ wait = { duration_s = 10 } }`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Step, A::Error> {
        let (mut action, mut label, mut limit) = (None, None, None);
        loop {
            let seed = KeySeed { action: action.as_ref().map(Action::name) };
            let Some(key) = map.next_key_seed(seed)? else {
                break;
            };
            match key.as_str() {
                LABEL => label = Some(map.next_value()?),
                TIME_LIMIT => limit = Some(map.next_value::<TimeLimit>()?.0),
                name => action = Some(Action::read(name, &mut map)?),
            }
        }
        let action = action.ok_or_else(|| {
            de::Error::custom("a step without an action, expected one key such as `wait`")
        })?;
        Ok(Step { action, label, explicit_time_limit: limit })
    }
}

impl<'de> Deserialize<'de> for Step {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(StepVisitor)
    }
}

/// One step or more.
pub(crate) fn some_steps<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<Step>, D::Error> {
    let steps = Vec::deserialize(deserializer)?;
    if steps.is_empty() {
        return Err(de::Error::custom("no steps, expected at least one"));
    }
    Ok(steps)
}
