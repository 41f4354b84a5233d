//! The live part of a summary: timing and ports of a run in real time.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How well a run kept real time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// How late the harness' loop handled due work.
    pub late: Spread,
    /// Time from the last byte or frame received to the command that followed it, for a controller in the process. A
    /// controller that sends once per period may take up to one period.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bus_to_command: Option<Spread>,
    /// Permitted lateness of the harness, ms.
    pub late_ms_max: f64,
    /// Number of times it was exceeded.
    pub misses: u64,
    /// Those during steps that measure something.
    pub misses_judged: u64,
    /// Number of times that the machine exceeded it in work outside the harness: bytes that cross a pty, a program that
    /// waits for a processor.
    #[serde(default)]
    pub machine_misses: u64,
    /// `normal`, or the part of `realtime` that the kernel granted.
    pub scheduling: String,
}

/// A distribution of times.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// Number of values.
    pub count: u64,
    /// Half are at most this long, ms; the upper end of the bin.
    pub p50_ms: f64,
    /// 99 % are at most this long, ms; the upper end of the bin.
    pub p99_ms: f64,
    /// The longest, ms.
    pub max_ms: f64,
    /// Five bins per decade; only bins that are not empty.
    pub bins: Vec<Bin>,
}

/// A bin of a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Upper end, ms, inclusive.
    pub up_to_ms: f64,
    /// Number of values in the bin.
    pub count: u64,
}

/// Traffic and errors of a port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PortSummary {
    /// The role of the port.
    pub role: String,
    /// The user of the port.
    pub side: PortSide,
    /// The port as the bench file names it.
    pub port: String,
    /// Number of times it was lost.
    pub lost: u64,
    /// Counts that are not zero, by name (`port::Counters`).
    pub counters: BTreeMap<String, u64>,
}

/// The user of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PortSide {
    /// The harness, for an emulated device or for listening.
    Bench,
    /// The harness, to command a device on behalf of the plan.
    Plan,
    /// The controller in the process of the harness.
    Controller,
}
