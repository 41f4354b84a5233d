//! Turns of the rotary table.

use super::columns::{Columns, Field, middle};
use identification::dataset::{Role, Unit};
use plan::observation::Observation;
use plan::quantities::{self, Quantity};

/// The observation that marks a turn: the angle by the gyro, unsigned.
pub static QUANTITY: &Quantity = &quantities::TABLE_ANGLE;

const FIELDS: [Field; 9] = [
    ("time", Role::Time, Unit::Second),
    ("direction", Role::Direction, Unit::One),
    ("gyro_angle", Role::GyroAngle, Unit::Degree),
    ("reference_angle", Role::ReferenceAngle, Unit::Degree),
    ("temperature", Role::Temperature, Unit::Celsius),
    ("table_rate", Role::TableRate, Unit::DegreePerSecond),
    ("duration", Role::Duration, Unit::Second),
    ("bias", Role::Bias, Unit::DegreePerSecond),
    ("heading", Role::Heading, Unit::Degree),
];

/// One row per turn, angles counter-clockwise positive.
pub fn columns(turns: &[Observation]) -> Columns {
    let mut columns = Columns::new(&FIELDS);
    for turn in turns {
        let tag = |name: &str| turn.tags.get(name).copied();
        let direction = tag("direction");
        let row = [
            middle(tag),
            direction,
            direction.map(|sign| sign * turn.value),
            tag("angle"),
            tag("temperature"),
            direction.zip(tag("table_rate")).map(|(sign, rate)| sign * rate),
            tag("duration"),
            tag("bias"),
            tag("heading"),
        ];
        columns.push(tag("run").unwrap_or(1.0).to_string(), &row);
    }
    columns
}
