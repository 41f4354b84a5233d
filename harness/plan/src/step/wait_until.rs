//! Waits for a condition.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::number;
use crate::quantity::QuantityName;
use crate::survey::Survey;
use crate::time_limits::CONDITION_LIMIT;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// Something to wait for, at a value that comes during the step: what was known before counts only in a window. Of the paper's
/// robot, the quantity is one that is seen at rest: `gyro.temperature`, `gyro.rate`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Condition {
    /// The quantity is steady: all its values within a window differ by no more than so much.
    Steady {
        /// What is watched.
        quantity: QuantityName,
        /// Largest minus smallest value, in the quantity's unit.
        #[serde(with = "number::Positive")]
        change_at_most: f64,
        /// Length of the window.
        #[serde(rename = "over_s", with = "number::Duration")]
        over: Span,
    },
    /// The quantity is below a limit.
    Below {
        /// What is watched.
        quantity: QuantityName,
        /// The limit, in the quantity's unit.
        #[serde(with = "number::Finite")]
        limit: f64,
        /// And has been for so long.
        #[serde(rename = "for_s", default, with = "number::DurationOrZero")]
        hold: Span,
    },
    /// The quantity is above a limit.
    Above {
        /// What is watched.
        quantity: QuantityName,
        /// The limit, in the quantity's unit.
        #[serde(with = "number::Finite")]
        limit: f64,
        /// And has been for so long.
        #[serde(rename = "for_s", default, with = "number::DurationOrZero")]
        hold: Span,
    },
}

impl Condition {
    /// The watched quantity.
    pub const fn quantity(&self) -> &QuantityName {
        match self {
            Self::Steady { quantity, .. }
            | Self::Below { quantity, .. }
            | Self::Above { quantity, .. } => quantity,
        }
    }

    /// Length of the observed window.
    pub const fn window(&self) -> Span {
        match self {
            Self::Steady { over, .. } => *over,
            Self::Below { hold, .. } | Self::Above { hold, .. } => *hold,
        }
    }

    /// Whether it holds if the values in its [`window`](Self::window) range from `low` to `high`.
    pub fn holds(&self, low: f64, high: f64) -> bool {
        match self {
            Self::Steady { change_at_most, .. } => high - low <= *change_at_most,
            Self::Below { limit, .. } => high < *limit,
            Self::Above { limit, .. } => low > *limit,
        }
    }

    /// The key that names this kind of condition.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Steady { .. } => "steady",
            Self::Below { .. } => "below",
            Self::Above { .. } => "above",
        }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Steady { quantity, change_at_most, over } => {
                let seconds = over.as_secs_f64();
                write!(f, "{quantity} changes by at most {change_at_most} in {seconds} s")
            }
            Self::Below { quantity, limit, .. } => write!(f, "{quantity} is below {limit}"),
            Self::Above { quantity, limit, .. } => write!(f, "{quantity} is above {limit}"),
        }
    }
}

impl StepKind for Condition {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "wait until {self}")
    }

    fn judges(&self) -> bool {
        true
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Condition(self.clone())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        let here = at.key(self.name()).key("quantity");
        survey.subject.awaited(self.quantity(), &here)
    }

    fn limit(&self) -> Span {
        CONDITION_LIMIT
    }
}
