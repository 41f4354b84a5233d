//! How a run ended, and what each declared measurement came to.

mod commands;
mod live;
#[cfg(any(test, feature = "samples"))]
pub mod samples;

pub use commands::CommandSummary;
pub use live::{Bin, PortSide, PortSummary, Spread, Timing};

use crate::FaultSummary;
use serde::{Deserialize, Serialize};

/// What a measurement came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Inside the band by more than the measurement's own uncertainty.
    Pass,
    /// Inside the band, by less than the measurement's own expanded uncertainty (k = 2).
    Marginal,
    /// Outside the band.
    Fail,
    /// Declared and never measured. Counts as a failure.
    Unset,
}

impl Verdict {
    /// A run with this verdict can still pass.
    pub const fn is_acceptable(self) -> bool {
        matches!(self, Self::Pass | Self::Marginal)
    }
}

/// How a run ended. Each has its own exit status.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Every measurement is acceptable.
    Passed,
    /// A measurement failed or was never made.
    Failed,
    /// The bench broke: a port, a device, a disk.
    Error,
    /// A step or the plan took longer than its limit.
    Timeout,
    /// Somebody stopped it.
    Aborted,
}

/// Exit status of bad input: a plan, a bench or a device file that cannot be used.
pub const EXIT_BAD_INPUT: u8 = 2;

impl Outcome {
    /// The documented exit status.
    pub const fn exit_status(self) -> u8 {
        match self {
            Self::Passed => 0,
            Self::Failed => 1,
            Self::Error => 3,
            Self::Timeout => 4,
            Self::Aborted => 5,
        }
    }
}

/// One declared measurement after a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    /// Name, unique in the plan.
    pub name: String,
    /// The figure that was judged; absent when nothing was measured.
    pub value: Option<f64>,
    /// Unit of `value`, `lower` and `upper`.
    pub unit: String,
    /// Lower end of the band, included.
    pub lower: Option<f64>,
    /// Upper end of the band, included.
    pub upper: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// What the paper gives, with its place.
    pub paper: Option<String>,
    /// What the figure is: "worst of 80", "share of 300 inside", "slope of 300 points".
    pub statistic: String,
    /// Standard uncertainty of `value`, in its unit; zero when it is exact.
    pub uncertainty: f64,
    /// How many observations it rests on.
    pub observations: u64,
    /// What it proves, where its plan says so.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub proves: Option<plan::Proves>,
}

/// `summary.json` of a run folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the run ended.
    pub outcome: Outcome,
    /// Why, when it did not simply pass: one sentence.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub reason: Option<String>,
    /// Name of the plan.
    pub plan: String,
    /// Its title.
    pub title: String,
    /// Version of the harness that ran it.
    pub version: String,
    /// The seed.
    pub seed: u64,
    /// `virtual` or `real`.
    pub clock: String,
    /// `memory`, or the kinds of port that were crossed, such as `pty+can`.
    pub bus: String,
    /// `in-process` or `process`; of a plan of a device of the user's own that device.
    pub device_under_test: String,
    /// Bench time from start to end, in seconds.
    pub simulated_s: f64,
    /// Time that the run took, in seconds.
    pub wall_s: f64,
    /// Events that the world handled.
    pub events: u64,
    /// What was measured.
    pub measurements: Vec<Measurement>,
    /// Names of further files that the plan made, in the run folder.
    pub artifacts: Vec<String>,
    /// How well real time was kept; absent in virtual time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub timing: Option<Timing>,
    /// The ports of a run in real time.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub ports: Vec<PortSummary>,
    /// Commands of the bench that the plan asked for, in the order in which it first did.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub commands: Vec<CommandSummary>,
    /// What became of the plan's faults; absent where it has none.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub faults: Vec<FaultSummary>,
    /// What became of the plan's properties; absent where it declares none.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub properties: Vec<PropertySummary>,
}

/// What became of a property that the plan declares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PropertySummary {
    /// As a plan writes it.
    pub name: String,
    /// It must hold at every moment; one that must not, must come about in at least one run of a campaign.
    pub always: bool,
    /// Always: it was never broken. Else: it came about. Absent where it was not judged.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub held: Option<bool>,
    /// Why it was not judged: what it is judged by, and why that was not seen on this bench.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub not_judged: Option<String>,
    /// Least distance to a violation as a share of its limit, -1 to 1.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub margin: Option<f64>,
    /// Bench time when it was first broken, s.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub broken_s: Option<f64>,
    /// What was seen then.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub what: Option<String>,
}

impl PropertySummary {
    /// It must hold at every moment, and did not.
    pub fn is_broken(&self) -> bool {
        self.always && self.held == Some(false)
    }
}

impl Verdict {
    /// The word for it, as in `summary.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Marginal => "marginal",
            Self::Fail => "fail",
            Self::Unset => "unset",
        }
    }
}

impl Outcome {
    /// The word for it, as in `summary.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Error => "error",
            Self::Timeout => "timeout",
            Self::Aborted => "aborted",
        }
    }
}

impl Measurement {
    /// How far inside the band the figure is, in its unit, to the nearer end; negative outside.
    /// `None` where there is no figure or no band.
    pub fn margin(&self) -> Option<f64> {
        let value = self.value?;
        let to_lower = self.lower.map(|lower| value - lower);
        let to_upper = self.upper.map(|upper| upper - value);
        match (to_lower, to_upper) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (one, other) => one.or(other),
        }
    }
}

/// How many measurements came to what.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Inside the band.
    pub passed: usize,
    /// Inside by less than the uncertainty.
    pub marginal: usize,
    /// Outside.
    pub failed: usize,
    /// Never measured.
    pub unset: usize,
}

impl Counts {
    /// Counts the verdicts of `measurements`.
    pub fn of<'a>(measurements: impl IntoIterator<Item = &'a Measurement>) -> Self {
        let mut counts = Self::default();
        for measurement in measurements {
            *match measurement.verdict {
                Verdict::Pass => &mut counts.passed,
                Verdict::Marginal => &mut counts.marginal,
                Verdict::Fail => &mut counts.failed,
                Verdict::Unset => &mut counts.unset,
            } += 1;
        }
        counts
    }

    /// All of them.
    pub const fn total(self) -> usize {
        self.passed + self.marginal + self.failed + self.unset
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let total = self.total();
        write!(f, "{total} measurement{}", if total == 1 { "" } else { "s" })?;
        let parts = [
            (self.passed, "passed"),
            (self.marginal, "marginal"),
            (self.failed, "failed"),
            (self.unset, "never measured"),
        ];
        let mut separator = ": ";
        for (count, word) in parts {
            if count > 0 {
                write!(f, "{separator}{count} {word}")?;
                separator = ", ";
            }
        }
        Ok(())
    }
}
