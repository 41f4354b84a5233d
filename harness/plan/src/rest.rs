//! Steps at rest: bias tests, logs, waiting.

use super::name::{Name, ParameterName};
use super::number;
use super::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;
use wire::time::Span;

/// The paper's static bias test: 20 s.
pub const BIAS_TEST: Span = Span::from_secs(20);
/// Interval of a log. Assumption: 720 points in the two hours of Fig. 2.
pub const LOG_INTERVAL: Span = Span::from_secs(10);

/// The shortest interval of a log: a controller at rest tells its rate so often.
pub const LOG_INTERVAL_MIN: Span = Span::from_secs(1);

fn bias_test() -> Span {
    BIAS_TEST
}

fn log_interval() -> Span {
    LOG_INTERVAL
}

/// A static bias test: the mean of the readings at rest is subtracted from now on.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BiasTest {
    /// How long to average.
    #[serde(rename = "duration_s", default = "bias_test", deserialize_with = "number::duration")]
    #[schemars(
        schema_with = "number::schema::duration",
        extend("default" = number::schema::written(BIAS_TEST.as_secs_f64()))
    )]
    pub duration: Span,
}

/// A window at rest, compared with what each method of bias correction predicts for it: the last bias
/// test, the temperature table, and none. Changes nothing.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BiasResidual {
    /// How long to average.
    #[serde(rename = "duration_s", default = "bias_test", deserialize_with = "number::duration")]
    #[schemars(
        schema_with = "number::schema::duration",
        extend("default" = number::schema::written(BIAS_TEST.as_secs_f64()))
    )]
    pub duration: Span,
}

/// A log of rate and temperature at rest (Fig. 2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// How long.
    #[serde(rename = "duration_s", deserialize_with = "number::duration")]
    #[schemars(schema_with = "number::schema::duration")]
    pub duration: Span,
    /// One observation each so often.
    #[serde(
        rename = "interval_s",
        default = "log_interval",
        deserialize_with = "number::duration"
    )]
    #[schemars(
        schema_with = "number::schema::duration",
        extend("default" = number::schema::written(LOG_INTERVAL.as_secs_f64()))
    )]
    pub interval: Span,
}

/// Nothing happens.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wait {
    /// For so long.
    #[serde(rename = "duration_s", deserialize_with = "number::duration")]
    #[schemars(schema_with = "number::schema::duration")]
    pub duration: Span,
}

/// Something to wait for. The quantity is one that is seen at rest: `gyro.temperature`, `gyro.rate`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Condition {
    /// The quantity is steady: all its values within a window differ by no more than so much.
    Steady {
        /// What is watched.
        quantity: QuantityName,
        /// Largest minus smallest value, in the quantity's unit.
        #[serde(deserialize_with = "number::positive")]
        #[schemars(schema_with = "number::schema::positive")]
        change_at_most: f64,
        /// Length of the window.
        #[serde(rename = "over_s", deserialize_with = "number::duration")]
        #[schemars(schema_with = "number::schema::duration")]
        over: Span,
    },
    /// The quantity is below a limit.
    Below {
        /// What is watched.
        quantity: QuantityName,
        /// The limit, in the quantity's unit.
        #[serde(deserialize_with = "number::finite")]
        #[schemars(schema_with = "number::schema::finite")]
        limit: f64,
        /// And has been for so long.
        #[serde(rename = "for_s", default, deserialize_with = "number::duration_or_zero")]
        #[schemars(schema_with = "number::schema::duration_or_zero")]
        hold: Span,
    },
    /// The quantity is above a limit.
    Above {
        /// What is watched.
        quantity: QuantityName,
        /// The limit, in the quantity's unit.
        #[serde(deserialize_with = "number::finite")]
        #[schemars(schema_with = "number::schema::finite")]
        limit: f64,
        /// And has been for so long.
        #[serde(rename = "for_s", default, deserialize_with = "number::duration_or_zero")]
        #[schemars(schema_with = "number::schema::duration_or_zero")]
        hold: Span,
    },
}

impl Condition {
    /// What is watched.
    pub const fn quantity(&self) -> &QuantityName {
        match self {
            Self::Steady { quantity, .. }
            | Self::Below { quantity, .. }
            | Self::Above { quantity, .. } => quantity,
        }
    }

    /// How far back it looks.
    pub const fn window(&self) -> Span {
        match self {
            Self::Steady { over, .. } => *over,
            Self::Below { hold, .. } | Self::Above { hold, .. } => *hold,
        }
    }

    /// Does it hold where the values of its [`window`](Self::window) go from `low` to `high`?
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

/// A device is switched off and on again: cold after a long pause, hot after a short one.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerCycle {
    /// Role of the device.
    pub device: Name,
    /// How long it stays off.
    #[serde(rename = "off_s", deserialize_with = "number::duration")]
    #[schemars(schema_with = "number::schema::duration")]
    pub off: Span,
}

/// A parameter is set until it is set again. In simulation the world does so; on a bench the operator is
/// asked to.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SetParameter {
    /// Which.
    pub parameter: ParameterName,
    /// To what.
    #[serde(deserialize_with = "number::finite")]
    #[schemars(schema_with = "number::schema::finite")]
    pub value: f64,
}
