//! Limits of real time on this bench.

use crate::number;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::time::Span;

/// What real time may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Timing {
    /// How late the harness may be with anything; what the live world takes for usual where it is absent.
    /// `late_ms_max` in the file, in milliseconds.
    #[serde(rename = "late_ms_max", default, with = "number::Milliseconds")]
    pub late_max: Option<Span>,
    /// How long an attached controller may take until it is heard, from the begin of the run; what the live
    /// world takes for usual where it is absent. `attach_s_max` in the file, in seconds.
    #[serde(rename = "attach_s_max", default, with = "number::WithinHour")]
    pub attach_max: Option<Span>,
    /// Ask for real-time priority and locked memory, as `--realtime` does.
    #[serde(default)]
    pub realtime: bool,
}
