//! What a run in real time tells of itself beyond its measurements: its timing and its ports.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How well real time was kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// How late the loop of the harness was with what was due.
    pub late: Spread,
    /// From the last byte or frame heard to the command that followed it, for a controller in the process. A
    /// controller that speaks once a period may wait up to that long.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bus_to_command: Option<Spread>,
    /// How late the harness may be, ms.
    pub late_ms_max: f64,
    /// Times that it was later.
    pub misses: u64,
    /// Those during steps that something was measured in.
    pub misses_judged: u64,
    /// Times that the machine was later with what it does for others: bytes that cross a pty, a program that waits for a
    /// processor.
    #[serde(default)]
    pub machine_misses: u64,
    /// `normal`, or what the kernel granted of `realtime`.
    pub scheduling: String,
}

/// A distribution of times.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Spread {
    /// How many.
    pub count: u64,
    /// Half are no longer than this, ms; the upper end of the bin.
    pub p50_ms: f64,
    /// 99 % are no longer than this, ms; the upper end of the bin.
    pub p99_ms: f64,
    /// The longest, ms.
    pub max_ms: f64,
    /// Five bins a decade; those with something in them.
    pub bins: Vec<Bin>,
}

/// A bin of a distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Its upper end, ms, included.
    pub up_to_ms: f64,
    /// How many are in it.
    pub count: u64,
}

/// What crossed a port and what went wrong there.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PortSummary {
    /// The role that it plays.
    pub role: String,
    /// Who has it open.
    pub side: PortSide,
    /// As a bench file names it.
    pub port: String,
    /// Times that it was lost.
    pub lost: u64,
    /// Counts that are not zero, by name (`port::Counters`).
    pub counters: BTreeMap<String, u64>,
}

/// Who has a port open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PortSide {
    /// The harness, for an emulated device or to listen.
    Bench,
    /// The harness, to command a device as the plan says.
    Plan,
    /// The controller in the process of the harness.
    Controller,
}
