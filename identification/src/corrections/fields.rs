//! Which reading belongs to which reference, and how it is to be read: angles that add up from the beginning of a run where the
//! package says a rate, or an increment since the row before, and axes of a gyro that are wired to, or named as, one another.

use super::{Correction, Fault, applied};
use crate::dataset::{Axis, Column, Dataset, Dimension, Kind, Role, Unit};
use crate::problem::wrap;
use crate::robust::squared_correlation;

/// Those that say which reading belongs to which reference.
pub(crate) fn fields(dataset: &Dataset) -> Vec<Correction> {
    if !matches!(dataset.kind, Kind::Series | Kind::Sensor) {
        return Vec::new();
    }
    let mut found = added_up(dataset);
    found.extend(wrong_axes(&applied(dataset, &found)));
    found
}

/// Squared correlation up to which readings do not follow their reference, and from which their changes follow it.
const DOES_NOT: f64 = 0.3;
const FOLLOWS: f64 = 0.8;

/// What adds up of a gyro and of its reference.
fn added_up(dataset: &Dataset) -> Vec<Correction> {
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
pub(super) fn read_added_up(dataset: &mut Dataset, field: &str) {
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

/// Squared correlation from which an axis follows a rotation.
const AXIS_FOLLOWS: f64 = 0.6;

/// Which axis each reference is of, where every axis of a sensor follows one and some follow another than their own.
fn wrong_axes(dataset: &Dataset) -> Vec<Correction> {
    let sensors: Vec<&Column> = dataset
        .columns
        .iter()
        .filter(|one| matches!(one.role, Role::GyroRate | Role::GyroCounts | Role::Measured))
        .filter(|one| one.axis.is_some())
        .collect();
    let is_reference = |role| matches!(role, Role::ReferenceRate | Role::Reference);
    let references: Vec<&Column> =
        dataset.columns.iter().filter(|one| is_reference(one.role) && one.axis.is_some()).collect();
    let mut found = Vec::new();
    let mut taken: Vec<&str> = Vec::new();
    for sensor in &sensors {
        let follows = |reference: &&&Column| squared_correlation(&sensor.values, &reference.values);
        let own = references.iter().find(|reference| reference.axis == sensor.axis);
        let best = references.iter().max_by(|a, b| follows(a).total_cmp(&follows(b)));
        let Some((own, best)) = own.zip(best) else { return Vec::new() };
        // Two axes cannot follow the same rotation.
        if follows(&best) < AXIS_FOLLOWS || taken.contains(&best.name.as_str()) {
            return Vec::new();
        }
        taken.push(&best.name);
        if best.name != own.name {
            if follows(&own) > DOES_NOT {
                return Vec::new();
            }
            let axis = sensor.axis.map_or(0, |axis| axis as u8);
            found.push(Correction::exact(Fault::WrongAxis, &best.name, axis.into()));
        }
    }
    // Whole axes change places.
    let is_permutation = found.iter().all(|one| {
        let number = Some(one.value as u8);
        let goes_to = references.iter().find(|other| other.axis.map(|axis| axis as u8) == number);
        goes_to.is_some_and(|other| found.iter().any(|moved| moved.field == other.name))
    });
    if is_permutation { found } else { Vec::new() }
}
