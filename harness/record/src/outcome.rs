//! The outcome of a run and the verdict on each declared measurement.

mod commands;
mod live;
#[cfg(any(test, feature = "samples"))]
pub mod samples;

pub use commands::CommandSummary;
pub use live::{Bin, PortSide, PortSummary, Spread, Timing};
pub use plan::check::Verdict;

use crate::{Bench, FaultSummary, figures};
use serde::{Deserialize, Serialize};

wire::words! {
    /// Outcome of a run. Each has its own exit status.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Outcome {
        /// All measurements are acceptable.
        Passed = "passed",
        /// A measurement failed or was never made, or what is under test broke a rule, ended or did not answer.
        Failed = "failed",
        /// The bench failed: a port, a device, a disk.
        Error = "error",
        /// A step or the plan took longer than its limit.
        Timeout = "timeout",
        /// The user stopped the run.
        Aborted = "aborted",
    }
}

/// Exit status for bad input: an unusable plan, bench file or device file.
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
    /// The judged figure; absent when nothing was measured.
    pub value: Option<f64>,
    /// Unit of `value`, `lower` and `upper`.
    pub unit: String,
    /// Lower end of the band, inclusive.
    pub lower: Option<f64>,
    /// Upper end of the band, inclusive.
    pub upper: Option<f64>,
    /// The verdict.
    pub verdict: Verdict,
    /// The value in the paper, with its place there; absent on other rigs.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub paper: Option<String>,
    /// Kind of figure: "worst of 80", "share of 300 inside", "slope of 300 points".
    pub statistic: String,
    /// Standard uncertainty of `value`, in its unit; zero if exact.
    pub uncertainty: f64,
    /// Number of observations used.
    pub observations: u64,
    /// What it proves, if its plan declares that.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub proves: Option<plan::Proves>,
}

/// `summary.json` of a run folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How the run ended.
    pub outcome: Outcome,
    /// The reason if the run did not simply pass, in one sentence.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub reason: Option<String>,
    /// Name of the plan.
    pub plan: String,
    /// Title of the plan.
    pub title: String,
    /// Version of the harness that ran it.
    pub version: String,
    /// The seed.
    pub seed: u64,
    /// `virtual` or `real`.
    pub clock: String,
    /// `memory`, or the kinds of port used, such as `pty+can`.
    pub bus: String,
    /// `in-process` or `process`; for a plan of a custom device, that device.
    pub device_under_test: String,
    /// Bench time from start to end, in seconds.
    pub simulated_s: f64,
    /// Wall-clock time of the run, in seconds.
    pub wall_s: f64,
    /// Events that the world handled.
    pub events: u64,
    /// Declared measurements and their verdicts.
    pub measurements: Vec<Measurement>,
    /// Names of further files in the run folder that the plan made.
    pub artifacts: Vec<String>,
    /// Where and when it ran; absent in virtual time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bench: Option<Bench>,
    /// How well the run kept real time; absent in virtual time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub timing: Option<Timing>,
    /// The ports of a run in real time.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub ports: Vec<PortSummary>,
    /// Commands of the bench that the plan asked for, in the order in which it first did.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub commands: Vec<CommandSummary>,
    /// Results of the plan's faults; absent if the plan schedules no faults.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub faults: Vec<FaultSummary>,
    /// Results of the plan's properties; absent if it declares none.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub properties: Vec<PropertySummary>,
    /// What no measurement covers, one sentence each: values out of range, messages that were refused.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub notes: Vec<String>,
}

impl Summary {
    /// Its number among the runs of `hil run --repeat`.
    pub fn repetition(&self) -> Option<u32> {
        self.bench.as_ref()?.repetition
    }
}

/// Result of a property that the plan declares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PropertySummary {
    /// Name, as in a plan.
    pub name: String,
    /// Whether it must hold at every moment. If not, it must occur: during a run, or in at least one run of a campaign.
    pub always: bool,
    /// For an always-property: it was never broken. Otherwise: it occurred. Absent if it was not judged.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub held: Option<bool>,
    /// Why it was not judged: the signal that it needs, and why this bench cannot observe that.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub not_judged: Option<String>,
    /// Smallest distance to a violation as a share of the limit, -1 to 1.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub margin: Option<f64>,
    /// For a held property `a -> b`: the text of `a`, if `a` was true at no moment at which `b` was known. Nothing was asked
    /// for then, and the property would have held for any device.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub never_asked: Option<String>,
    /// Bench time of the first violation, s.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub broken_s: Option<f64>,
    /// The observation at that time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub what: Option<String>,
}

impl PropertySummary {
    /// A sentence about a property that [is broken](Self::is_broken), as the reason of a run gives it.
    pub fn breach(&self) -> String {
        let what = self.what.as_deref().unwrap_or("-");
        match self.broken_s {
            Some(at_s) => format!("broke {} at {at_s:.3} s: {what}", self.name),
            None => format!("{} {what}", self.name),
        }
    }

    /// A sentence, if the property held only because nothing was asked for.
    pub fn untested(&self) -> Option<String> {
        let premise = self.never_asked.as_ref()?;
        Some(format!(
            "never put to the test: `{premise}` was true at no moment that could be judged"
        ))
    }

    /// Whether it was violated, or is a sometimes-property that did not occur.
    pub fn is_broken(&self) -> bool {
        self.held == Some(false)
    }
}

impl Measurement {
    /// The figure with its unit and uncertainty; `None` if it was never made. It has as many digits as show on which side
    /// of each end of the band it is.
    pub fn figure(&self) -> Option<String> {
        let limits = [self.lower, self.upper].into_iter().flatten();
        Some(figures::quantity_beside(self.value?, self.uncertainty, &self.unit, limits))
    }

    /// Distance of the figure from the nearer end of the band, in its unit; negative outside. `None` without a figure
    /// or a band.
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

/// Number of measurements per verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Inside the band.
    pub passed: usize,
    /// Inside by less than the expanded uncertainty.
    pub marginal: usize,
    /// Outside.
    pub failed: usize,
    /// Never measured.
    pub unset: usize,
    /// Not judged, because no device of the bench gives it.
    pub not_judged: usize,
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
                Verdict::NotJudged => &mut counts.not_judged,
            } += 1;
        }
        counts
    }

    /// Number of all measurements.
    pub const fn total(self) -> usize {
        self.passed + self.marginal + self.failed + self.unset + self.not_judged
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
            (self.unset, "unset"),
            (self.not_judged, "not judged"),
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
