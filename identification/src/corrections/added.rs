//! Angles that add up from the beginning of a run where the package says a rate, or an increment since the row before.

use super::axes::squared_correlation;
use super::{Correction, Fault};
use crate::dataset::{Axis, Column, Dataset, Dimension, Role, Unit};
use crate::problem::wrap;

/// Squared correlation up to which readings do not follow their reference, and from which their changes follow it.
const DOES_NOT: f64 = 0.3;
const FOLLOWS: f64 = 0.8;

/// What adds up of a gyro and of its reference.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found: Vec<Correction> = Vec::new();
    for gyro in dataset.columns.iter().filter(|column| column.role.is_gyro()) {
        let mine = |one: &&Column| Axis::agree(one.axis, gyro.axis);
        let Some(reference) = dataset.columns_of(Role::ReferenceRate).find(mine) else { continue };
        let follows = |one: &[f64], other: &[f64]| squared_correlation(one, other);
        if follows(&gyro.values, &reference.values) > DOES_NOT {
            continue;
        }
        let is_known = |name: &str| found.iter().any(|one: &Correction| one.field == name);
        let field = if follows(&changes(dataset, gyro), &reference.values) > FOLLOWS {
            &gyro.name
        } else if follows(&gyro.values, &changes(dataset, reference)) > FOLLOWS {
            &reference.name
        } else {
            continue;
        };
        if !is_known(field) {
            found.push(Correction::exact(Fault::AddedUp, field, 1.0));
        }
    }
    found
}

/// The angle that a rate is of.
fn angle(unit: Unit) -> Unit {
    match unit {
        Unit::RadianPerSecond => Unit::Radian,
        Unit::DegreePerSecond | Unit::DegreePerHour => Unit::Degree,
        Unit::MetrePerSecond => Unit::Metre,
        other => other,
    }
}

/// Change of each row since the row before in its run; none in the first. An angle may wrap.
fn changes(dataset: &Dataset, column: &Column) -> Vec<f64> {
    let unit = angle(column.unit);
    let values = &column.values;
    let change = |row: usize| {
        if row == 0 || dataset.run_of_row[row] != dataset.run_of_row[row - 1] {
            return f64::NAN;
        }
        let change = values[row] - values[row - 1];
        let turns = unit.dimension() == Dimension::Angle;
        if turns { wrap(change * unit.si()) / unit.si() } else { change }
    };
    (0..values.len()).map(change).collect()
}

/// Reads `field` of `dataset` as what adds up.
pub(super) fn apply(dataset: &mut Dataset, field: &str) {
    let Some(at) = dataset.columns.iter().position(|column| column.name == field) else { return };
    let changes = changes(dataset, &dataset.columns[at]);
    let column = &mut dataset.columns[at];
    let is_rate = angle(column.unit) != column.unit;
    column.unit = angle(column.unit);
    match column.role {
        Role::ReferenceRate => column.role = Role::ReferenceHeading,
        Role::GyroRate => (column.role, column.values) = (Role::GyroAngleIncrement, changes),
        // The motion of a wheel is taken from its angle or its way.
        _ if is_rate => {}
        _ => column.values = changes,
    }
}
