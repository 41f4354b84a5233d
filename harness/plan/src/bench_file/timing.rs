//! Limits of real time on this bench.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Unexpected};
use serde::{Deserialize, Deserializer};
use wire::time::Span;

/// Largest permitted lateness, in milliseconds. Assumption: a bench that is later than the slowest measured motion, a
/// lap's corner of some 10 s, measures nothing.
pub const LATE_MS_MAX_MAX: f64 = 10_000.0;

/// Longest wait for an attached controller, in seconds. Assumption: a user who has not started it within an hour will
/// not.
pub const ATTACH_S_MAX_MAX: f64 = 3_600.0;

/// What real time may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// How late the harness may be with anything; what the live world takes for usual where it is absent.
    /// `late_ms_max` in the file, in milliseconds.
    #[serde(rename = "late_ms_max", default, deserialize_with = "milliseconds")]
    #[schemars(schema_with = "late_schema")]
    pub late_max: Option<Span>,
    /// How long an attached controller may take until it is heard, from the begin of the run; what the live
    /// world takes for usual where it is absent. `attach_s_max` in the file, in seconds.
    #[serde(rename = "attach_s_max", default, deserialize_with = "seconds")]
    #[schemars(schema_with = "attach_schema")]
    pub attach_max: Option<Span>,
    /// Ask for real-time priority and locked memory, as `--realtime` does.
    #[serde(default)]
    pub realtime: bool,
}

fn late_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "number", "exclusiveMinimum": 0, "maximum": LATE_MS_MAX_MAX })
}

fn attach_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "number", "exclusiveMinimum": 0, "maximum": ATTACH_S_MAX_MAX })
}

fn milliseconds<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Span>, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if value > 0.0 && value <= LATE_MS_MAX_MAX {
        return Ok(Some(Span::from_secs_f64(value / 1e3)));
    }
    Err(de::Error::invalid_value(Unexpected::Float(value), &"milliseconds above 0, at most 10000"))
}

fn seconds<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Span>, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if value > 0.0 && value <= ATTACH_S_MAX_MAX {
        return Ok(Some(Span::from_secs_f64(value)));
    }
    Err(de::Error::invalid_value(Unexpected::Float(value), &"seconds above 0, at most 3600"))
}
