//! The noise of a reference. A model that takes its input as exact sees an error of the sensor in it: the input is too
//! uncertain, so a lag, a play or a dead zone that evens it out predicts the readings better (errors in variables;
//! Fuller 1987). What evens it out best from both sides alike, in the manner of Wiener, is no property of a sensor, which
//! sees the past alone.

mod evened;
mod fit;

use super::{Correction, Fault};
use crate::dataset::{Column, Dataset, Dimension, Kind, Role, Unit};
use crate::problem::{segments, wrap};
pub(super) use evened::evened;
use fit::{Stretch, width};

/// Minimum number of rows.
const ROWS_MIN: usize = 400;
/// Minimum number of rows of a stretch of time that takes part.
const STRETCH_MIN: usize = 40;

/// Time over which each noisy reference is best evened out.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found: Vec<Correction> = Vec::new();
    for column in &dataset.columns {
        let reference = match (dataset.kind, column.role) {
            (Kind::Sensor, Role::Measured) => dataset.column(Role::Reference),
            (Kind::Series, Role::GyroRate | Role::GyroCounts) => dataset
                .columns_of(Role::ReferenceRate)
                .find(|one| one.axis.is_none() || column.axis.is_none() || one.axis == column.axis),
            _ => None,
        };
        let Some(reference) = reference else { continue };
        if found.iter().any(|one| one.field == reference.name) {
            continue;
        }
        let Some(stretches) = stretches(dataset, column, reference) else { continue };
        if let Some(value) = width(&stretches) {
            found.push(Correction {
                fault: Fault::ReferenceNoise,
                field: reference.name.clone(),
                value,
                unit: Unit::Second,
                standard_error: None,
            });
        }
    }
    found
}

/// Readings and their reference in each stretch of time.
fn stretches(dataset: &Dataset, column: &Column, reference: &Column) -> Option<Vec<Stretch>> {
    let time =
        dataset.column(Role::Time).filter(|time| time.unit.dimension() == Dimension::Time)?;
    let times: Vec<f64> = time.si().collect();
    let turns = dataset.kind == Kind::Sensor && reference.unit.dimension() == Dimension::Angle;
    let (read, truth): (Vec<f64>, Vec<f64>) = (column.si().collect(), reference.si().collect());
    let mut found = Vec::new();
    for range in segments(&times, &dataset.run_of_row) {
        let mut stretch = Stretch::default();
        for row in range.filter(|&row| (read[row] + truth[row] + times[row]).is_finite()) {
            let mut now = truth[row];
            if let Some(last) = stretch.reference.last().filter(|_| turns) {
                now = last + wrap(now - last);
            }
            let error = read[row] - truth[row];
            stretch.times.push(times[row]);
            stretch.reference.push(now);
            stretch.readings.push(now + if turns { wrap(error) } else { error });
        }
        if stretch.times.len() >= STRETCH_MIN {
            found.push(stretch);
        }
    }
    let rows: usize = found.iter().map(|stretch| stretch.times.len()).sum();
    // A sparse reference is not evened out: its values lie too far apart.
    (rows >= ROWS_MIN && 2 * rows > dataset.rows()).then_some(found)
}

/// Evens out `column` over `width` s.
pub(super) fn apply(dataset: &Dataset, column: &Column, width: f64) -> Vec<f64> {
    let mut values = column.values.clone();
    let Some(time) = dataset.column(Role::Time) else { return values };
    let times: Vec<f64> = time.si().collect();
    let turn = std::f64::consts::TAU / column.unit.si();
    let turns = dataset.kind == Kind::Sensor && column.unit.dimension() == Dimension::Angle;
    for range in segments(&times, &dataset.run_of_row) {
        let rows: Vec<usize> =
            range.filter(|&row| (values[row] + times[row]).is_finite()).collect();
        let of_rows: Vec<f64> = rows.iter().map(|&row| times[row]).collect();
        let mut level: Vec<f64> = Vec::with_capacity(rows.len());
        for &row in &rows {
            let last = level.last().copied().filter(|_| turns);
            level.push(last.map_or(values[row], |last| {
                last + (values[row] - last) - turn * ((values[row] - last) / turn).round()
            }));
        }
        for (&row, value) in rows.iter().zip(evened(&of_rows, &level, width)) {
            values[row] = value;
        }
    }
    values
}

#[cfg(test)]
mod tests;
