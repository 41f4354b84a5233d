//! A turn of the rotary table.

use super::turn::paper_rate;
use super::{Known, Op, StepKind};
use crate::number;
use crate::time_limits::trapezoid;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use wire::table::Command;
use wire::time::Span;
use wire::units::{Angle, AngularAcceleration, AngularRate};

/// Ramps of the table. Assumption: 15 deg/s^2 give the paper's 48 s for one run.
pub const TABLE_ACCELERATION: AngularAcceleration = AngularAcceleration::from_deg_per_s2(15.0);
/// Time after a turn for the end of the table's ramp and the gyro's last samples. Assumption: ten periods of a 100 Hz
/// stream and its latency.
const TABLE_SETTLE: Span = Span::from_millis(200);

fn table_acceleration() -> AngularAcceleration {
    TABLE_ACCELERATION
}

/// A turn of the rotary table, the gyro on it (Eqs 1 and 2).
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TableTurn {
    /// How far; counter-clockwise is positive.
    #[serde(rename = "angle_deg", with = "number::Turn")]
    pub angle: Angle,
    /// Steady rate.
    #[serde(rename = "rate_deg_per_s", default = "paper_rate", with = "number::Rate")]
    pub rate: AngularRate,
    /// Ramps.
    #[serde(
        rename = "acceleration_deg_per_s2",
        default = "table_acceleration",
        with = "number::AngularAcceleration"
    )]
    pub acceleration: AngularAcceleration,
}

impl StepKind for TableTurn {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (angle, rate) = (self.angle.deg(), self.rate.deg_per_s());
        write!(f, "table turn by {angle:.1} deg at {rate:.1} deg/s")
    }

    fn script(&self, known: &Known<'_>) -> Result<Vec<Op>, String> {
        let steps = |value: f64| (value / known.table_step.rad()).round();
        Ok(vec![
            Op::StateBefore,
            // Casts saturate; the plan's own limits are far below.
            Op::Table(Command::TopRate(steps(self.rate.rad_per_s()) as u32)),
            Op::Table(Command::Ramp(steps(self.acceleration.rad_per_s2()) as u32)),
            Op::Table(Command::Distance(steps(self.angle.rad()) as i32)),
            Op::Table(Command::Go),
            Op::TableAtRest,
            Op::Pause(TABLE_SETTLE),
            Op::StateAfter,
            Op::ObserveTableTurn(self.clone()),
        ])
    }

    fn motion(&self) -> Span {
        let (angle, rate) = (self.angle.abs().rad(), self.rate.rad_per_s());
        trapezoid(angle, rate, self.acceleration.rad_per_s2())
    }
}
