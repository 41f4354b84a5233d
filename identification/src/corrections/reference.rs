//! The noise of a reference. A model that takes its input as exact sees an error of the sensor in it: the input is too
//! uncertain, so a lag, a play or a dead zone that evens it out predicts the readings better (errors in variables;
//! Fuller 1987). What evens it out best from both sides alike, in the manner of Wiener, is no property of a sensor, which
//! sees the past alone.

mod evened;
mod fit;

use super::{Correction, Fault, reference_of};
use crate::dataset::{Column, Dataset, Dimension, Kind, Role, Unit};
use crate::problem::{segments, unwrap, wrap};
use evened::evened;
use fit::{Stretch, width};

/// Minimum number of rows.
const ROWS_MIN: usize = 400;
/// Minimum number of rows of a stretch of time that takes part.
const STRETCH_MIN: usize = 40;

/// Time over which each noisy reference is best evened out.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found: Vec<Correction> = Vec::new();
    for column in &dataset.columns {
        let Some(reference) = reference_of(dataset, column) else { continue };
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

/// Whether what a sensor reads is an angle, which repeats after a turn.
pub(super) fn turns(kind: Kind, column: &Column) -> bool {
    kind == Kind::Sensor && column.unit.dimension() == Dimension::Angle
}

/// Readings and their reference in each stretch of time.
fn stretches(dataset: &Dataset, column: &Column, reference: &Column) -> Option<Vec<Stretch>> {
    let time =
        dataset.column(Role::Time).filter(|time| time.unit.dimension() == Dimension::Time)?;
    let times: Vec<f64> = time.si().collect();
    let turns = turns(dataset.kind, reference);
    let (read, truth): (Vec<f64>, Vec<f64>) = (column.si().collect(), reference.si().collect());
    let mut found = Vec::new();
    for range in segments(&times, &dataset.run_of_row) {
        let rows: Vec<usize> =
            range.filter(|&row| (read[row] + truth[row] + times[row]).is_finite()).collect();
        if rows.len() < STRETCH_MIN {
            continue;
        }
        let of = |values: &[f64]| -> Vec<f64> { rows.iter().map(|&row| values[row]).collect() };
        let mut reference = of(&truth);
        if turns {
            unwrap(&mut reference);
        }
        let reading = |(&row, now): (&usize, &f64)| {
            let error = read[row] - truth[row];
            now + if turns { wrap(error) } else { error }
        };
        let readings = rows.iter().zip(&reference).map(reading).collect();
        found.push(Stretch { times: of(&times), reference, readings });
    }
    let rows: usize = found.iter().map(|stretch| stretch.times.len()).sum();
    // A sparse reference is not evened out: its values lie too far apart.
    (rows >= ROWS_MIN && 2 * rows >= dataset.rows()).then_some(found)
}

/// Evens out `column` over `width` s.
pub(super) fn apply(dataset: &Dataset, column: &Column, width: f64) -> Vec<f64> {
    let mut values = column.values.clone();
    let Some(time) = dataset.column(Role::Time) else { return values };
    let times: Vec<f64> = time.si().collect();
    let turns = turns(dataset.kind, column);
    let si = column.unit.si();
    for range in segments(&times, &dataset.run_of_row) {
        let rows: Vec<usize> =
            range.filter(|&row| (values[row] + times[row]).is_finite()).collect();
        let of_rows: Vec<f64> = rows.iter().map(|&row| times[row]).collect();
        let mut level: Vec<f64> = rows.iter().map(|&row| values[row]).collect();
        if turns {
            level.iter_mut().for_each(|value| *value *= si);
            unwrap(&mut level);
            level.iter_mut().for_each(|value| *value /= si);
        }
        for (&row, value) in rows.iter().zip(evened(&of_rows, &level, width)) {
            values[row] = value;
        }
    }
    values
}

#[cfg(test)]
mod tests;
