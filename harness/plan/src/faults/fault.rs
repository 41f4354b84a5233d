//! One fault: kind, target, time and probability.

use super::{FaultKind, Lasts, Target, When};
use crate::number;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use wire::time::Span;

/// Which way a faulty line is faulty.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Toward {
    /// What the device sends.
    Host,
    /// What is sent to the device.
    Device,
    /// Both, each by itself.
    #[default]
    Both,
}

/// One fault of a schedule. Times are SI; the parameters of the kind are in the units of their names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// What it strikes.
    pub target: Target,
    /// Which way, where it strikes a line; of others it says nothing.
    #[serde(default, skip_serializing_if = "is_both")]
    pub toward: Toward,
    /// What goes wrong.
    pub what: FaultKind,
    /// When it begins; where it is absent, with the run.
    #[serde(default, skip_serializing_if = "When::is_always")]
    pub when: When,
    /// How long it lasts; without, to the end of the phase that it is tied to, or of the run. For kinds that
    /// [last](Lasts) as long as the schedule says, and no others.
    #[serde(
        rename = "duration_s",
        default,
        with = "number::Duration",
        skip_serializing_if = "Option::is_none"
    )]
    pub duration: Option<Span>,
    /// Probability that it happens at all, drawn from the seed of the run.
    #[serde(default = "certain", with = "number::Share", skip_serializing_if = "is_certain")]
    pub probability: f64,
}

impl Fault {
    /// A fault that happens for certain, from the beginning of the run to its end.
    pub const fn new(target: Target, what: FaultKind) -> Self {
        let (toward, when) = (Toward::Both, When::Always);
        Self { target, toward, what, when, duration: None, probability: 1.0 }
    }

    /// Duration of the fault, if its kind or the schedule determines it.
    pub fn lasting(&self) -> Option<Span> {
        match self.what.info().lasts {
            Lasts::Scheduled => self.duration,
            Lasts::Itself => Some(Span::from_secs_f64(self.what.severity())),
            Lasts::Instant => Some(Span::ZERO),
        }
    }
}

/// `burst_loss of gyro`.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.what.name(), self.target.name())
    }
}

const fn certain() -> f64 {
    1.0
}

fn is_certain(probability: &f64) -> bool {
    *probability == 1.0
}

fn is_both(toward: &Toward) -> bool {
    *toward == Toward::Both
}
