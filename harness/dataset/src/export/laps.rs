//! Laps of a closed path.

use super::columns::{Columns, Field, middle};
use controller::mission::HeadingSource;
use identification::dataset::{Role, Unit};
use plan::observation::Observation;
use plan::quantities as q;
use std::collections::BTreeMap;

const FIELDS: [Field; 13] = [
    ("time", Role::Time, Unit::Second),
    ("direction", Role::Direction, Unit::One),
    ("gyro_angle", Role::GyroAngle, Unit::Degree),
    ("reference_angle", Role::ReferenceAngle, Unit::Degree),
    ("reference_x", Role::ReferenceX, Unit::Metre),
    ("reference_y", Role::ReferenceY, Unit::Metre),
    ("reference_heading", Role::ReferenceHeading, Unit::Degree),
    ("odometry_x", Role::OdometryX, Unit::Metre),
    ("odometry_y", Role::OdometryY, Unit::Metre),
    ("odometry_heading", Role::OdometryHeading, Unit::Degree),
    ("temperature", Role::Temperature, Unit::Celsius),
    ("duration", Role::Duration, Unit::Second),
    ("bias", Role::Bias, Unit::DegreePerSecond),
];

/// Degrees of a lap.
const LAP_DEG: f64 = 360.0;

/// Whether rows of laps are made from this quantity.
pub fn is_of_lap(quantity: &str) -> bool {
    q::find(quantity).is_some_and(|quantity| quantity.made_by == "lap")
}

/// One row per lap. Positions and headings are at the end of the lap, seen from its start.
pub fn columns(observations: &[(Observation, HeadingSource)]) -> Columns {
    let mut columns = Columns::new(&FIELDS);
    // All observations of a lap have the same time.
    for lap in
        observations.chunk_by(|(one, _), (other, _)| one.tags.get("time") == other.tags.get("time"))
    {
        let Some((first, source)) = lap.first() else { continue };
        let values: BTreeMap<&str, f64> =
            lap.iter().map(|(observed, _)| (observed.quantity.as_str(), observed.value)).collect();
        let value = |quantity: &q::Quantity| values.get(quantity.name).copied();
        let tag = |name: &str| first.tags.get(name).copied();
        let heading = value(&q::LAP_RETURN_HEADING);
        let direction = tag("direction");
        let turned = direction.zip(heading).map(|(sign, heading)| sign * LAP_DEG + heading);
        // Errors are multiplied by the direction (Eq. 1); the export has the angle itself.
        let by = |error: &q::Quantity| Some(turned? + direction? * value(error)?);
        let odometry_angle = by(&q::LAP_ODOMETRY_ERROR);
        let odometry_heading =
            odometry_angle.zip(direction).map(|(angle, sign)| angle - sign * LAP_DEG);
        // Dead reckoning with the gyro's heading is not odometry.
        let reckoned = |reference: &q::Quantity, off: &q::Quantity| match source {
            HeadingSource::Odometry => Some(value(reference)? - value(off)?),
            HeadingSource::Gyro => None,
        };
        let row = [
            middle(tag),
            direction,
            by(&q::LAP_GYRO_ERROR),
            turned,
            value(&q::LAP_RETURN_X),
            value(&q::LAP_RETURN_Y),
            heading,
            reckoned(&q::LAP_RETURN_X, &q::UMBMARK_X),
            reckoned(&q::LAP_RETURN_Y, &q::UMBMARK_Y),
            odometry_heading,
            tag("temperature"),
            tag("duration"),
            tag("bias"),
        ];
        columns.push(tag("run").unwrap_or(1.0).to_string(), &row);
    }
    columns
}
