//! A log at rest.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::number;
use crate::survey::Survey;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::time::Span;

/// Interval of a log. Assumption: 720 points in the two hours of Fig. 2.
pub const LOG_INTERVAL: Span = Span::from_secs(10);
/// Shortest interval of a log: the interval at which a controller at rest reports its rate.
pub const LOG_INTERVAL_MIN: Span = Span::from_secs(1);

fn log_interval() -> Span {
    LOG_INTERVAL
}

/// A log of rate and temperature at rest (Fig. 2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// How long.
    #[serde(rename = "duration_s", with = "number::Duration")]
    pub duration: Span,
    /// One observation each so often.
    #[serde(rename = "interval_s", default = "log_interval", with = "number::Duration")]
    pub interval: Span,
}

impl StepKind for Log {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (duration, interval) = (self.duration.as_secs_f64(), self.interval.as_secs_f64());
        write!(f, "log at rest for {duration} s, each {interval} s")
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Log { duration: self.duration, interval: self.interval }])
    }

    fn check<'a>(&'a self, _: &mut Survey<'a>, at: &Place) -> Checked {
        if self.interval >= LOG_INTERVAL_MIN {
            return Ok(());
        }
        let (found, least) = (self.interval.as_secs_f64(), LOG_INTERVAL_MIN.as_secs_f64());
        let message = format!("interval_s = {found}, expected at least {least}");
        let help = "a controller at rest tells its rate once a second".to_owned();
        Err(at.key("interval_s").mistake(message).help(help))
    }

    fn rest(&self) -> Span {
        self.duration
    }
}
