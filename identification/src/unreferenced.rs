//! Readings of what was before the record: where a sensor is late, the first ones of each stretch of time have no reference.

use crate::dataset::{Dataset, Kind, Role};
use crate::model::{Acts, Driver, Form, Model, Wrap};
use crate::problem::segments;

/// Sets aside the readings in `dataset` whose reference lies outside its stretch of time, by the delays of `model`. Returns
/// whether there are any.
pub(crate) fn set_aside(dataset: &mut Dataset, model: &Model) -> bool {
    if !matches!(dataset.kind, Kind::Series | Kind::Sensor) {
        return false;
    }
    let Some(time) = dataset.column(Role::Time) else { return false };
    let times: Vec<f64> = time.si().collect();
    let stretches = segments(&times, &dataset.run_of_row);
    let mut found = false;
    for (axis, delay) in delays(model) {
        let is_reading = |role| matches!(role, Role::Measured | Role::GyroRate | Role::GyroCounts);
        let mine = dataset
            .columns
            .iter_mut()
            .filter(|column| is_reading(column.role) && (axis.is_none() || column.axis == axis));
        for column in mine {
            for rows in &stretches {
                let ends = [times[rows.start], times[rows.end - 1]];
                let outside = |row: &usize| {
                    let at = times[*row] - delay;
                    at < ends[0] || at > ends[1]
                };
                let step = (ends[1] - ends[0]) / (rows.len() - 1).max(1) as f64;
                // Within a sample the reference is near. Of a stretch that is shorter than the delay nothing would be left.
                if delay.abs() < step || rows.clone().filter(outside).count() * 2 > rows.len() {
                    continue;
                }
                for row in rows.clone().filter(outside) {
                    found |= column.values[row].is_finite();
                    column.values[row] = f64::NAN;
                }
            }
        }
    }
    found
}

/// Axis and size, s, of each delay in `model`.
fn delays(model: &Model) -> Vec<(Option<crate::dataset::Axis>, f64)> {
    let is_plain = |driver: &Driver| driver.wrap == Wrap::Plain;
    let late = model.terms.iter().filter(|term| {
        term.term == Acts::Delay && term.form == Form::Delay && term.drivers.iter().all(is_plain)
    });
    late.filter_map(|term| {
        let delay = term.parameter("delay")?;
        Some((term.axis, delay.value * crate::units::si_factor(&delay.unit)?))
    })
    .collect()
}
