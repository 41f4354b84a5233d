//! The sign and the unit of readings against their reference.

use super::{Correction, Fault, heading_of, reference_of, turned};
use crate::dataset::{Column, Dataset, Dimension, Kind, Role, Unit};
use crate::robust::Moments;

/// Minimum squared correlation of readings and reference for a correction.
const FOLLOWS: f64 = 0.8;
/// Maximum relative deviation of the slope from a factor; a scale error may come on top. Less where a factor is small.
const WITHIN: f64 = 0.2;
const WITHIN_SMALL: f64 = 0.05;
const SMALL: f64 = 10.0;
/// Mean resultant of the error of an angle that keeps turning, from which it follows its reference, and up to which it
/// does not.
const ALIKE: f64 = 0.9;
const UNLIKE: f64 = 0.5;

/// A reading this many times the truth.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const DEGREE: f64 = 1.0 / DEGREES;

/// What is wrong with the readings of `dataset`.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found = Vec::new();
    for column in &dataset.columns {
        let heading = heading_of(dataset, column);
        let Some(reference) = heading.or_else(|| reference_of(dataset, column)) else { continue };
        let dimension = column.unit.dimension();
        let turns = dataset.kind == Kind::Sensor && dimension == Dimension::Angle;
        let factor = match heading {
            Some(heading) => factor_beside_heading(dataset, column, heading),
            None if reference.unit.dimension() != dimension => None,
            None if turns => factor_of_angle(column, reference),
            None => factor(column.unit, pairs(column, reference)),
        };
        let Some(factor) = factor else { continue };
        let name = &column.name;
        let size = factor.abs();
        let exact = |fault, field: &str, size| Correction::exact(fault, field, size);
        if size == DEGREES {
            found.push(exact(Fault::DegreesForRadians, name, DEGREES));
        } else if size == DEGREE {
            found.push(exact(Fault::RadiansForDegrees, name, DEGREE));
        } else if size > 1.0 || (size < 1.0 && heading.is_some()) {
            found.push(exact(Fault::WrongUnit, name, size));
        } else if size < 1.0 && !found.iter().any(|one| one.field == reference.name) {
            // The larger numbers are the wrong ones: readings stay in the unit that they are in.
            found.push(exact(Fault::WrongUnit, &reference.name, 1.0 / size));
        }
        if factor < 0.0 {
            found.push(Correction::exact(Fault::ReversedSign, name, -1.0));
        }
    }
    found
}

/// Thousandths for ones, and centimetres, kilometres an hour, thousandths of a degree and times the gravity of the Earth;
/// the edges of an encoder. Each can be either way.
const MILLI: f64 = 1e3;

/// Factors by which readings of that unit can be off.
fn factors(unit: Unit) -> Vec<f64> {
    let sizes: &[f64] = match unit.dimension() {
        Dimension::Angle => &[DEGREES, MILLI],
        Dimension::AngularRate => &[DEGREES, MILLI, 3600.0],
        Dimension::Length => &[100.0, MILLI],
        Dimension::Speed => &[3.6, 100.0, MILLI],
        Dimension::Acceleration => &[9.806_65, MILLI],
        Dimension::Count => &[4.0],
        Dimension::Temperature | Dimension::Time => &[],
        _ => &[MILLI],
    };
    let both = sizes.iter().flat_map(|size| [*size, 1.0 / size]);
    std::iter::once(1.0).chain(both).flat_map(|size| [size, -size]).collect()
}

fn pairs<'a>(
    column: &'a Column,
    reference: &'a Column,
) -> impl Iterator<Item = (f64, f64)> + Clone + 'a {
    let both = reference.si().zip(column.si());
    both.filter(|(truth, reading)| (truth + reading).is_finite())
}

/// The factor near the slope of a line through truth and reading; `None` if it is 1 or they do not follow a line.
fn factor(unit: Unit, pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Option<f64> {
    let Moments { xx, xy, yy, .. } = Moments::of(pairs);
    if !(xy * xy > FOLLOWS * xx * yy && xx > 0.0) {
        return None;
    }
    let near = |factor: &f64| {
        let is_small = *factor != factor.signum() && (factor.abs().ln()).abs() < SMALL.ln();
        (xy / xx / factor - 1.0).abs() < if is_small { WITHIN_SMALL } else { WITHIN }
    };
    factors(unit).into_iter().find(near).filter(|factor| *factor != 1.0)
}

/// The factor of a gyro beside a heading. Of counts, whose unit is fitted, and where time is not in seconds, it is not known.
fn factor_beside_heading(dataset: &Dataset, column: &Column, heading: &Column) -> Option<f64> {
    let dimension = column.unit.dimension();
    let in_seconds =
        dataset.column(Role::Time).is_some_and(|time| time.unit.dimension() == Dimension::Time);
    let is_told = match dimension {
        Dimension::Angle => true,
        dimension => dimension == Dimension::AngularRate && in_seconds,
    };
    let [truth, readings] = is_told.then(|| turned(dataset, column, heading))?;
    factor(column.unit, truth.into_iter().zip(readings))
}

/// The factor with which an angle that keeps turning stays with its reference.
fn factor_of_angle(column: &Column, reference: &Column) -> Option<f64> {
    let alike = |factor: f64| {
        let (mut cos, mut sin, mut count) = (0.0, 0.0, 0.0);
        for (truth, reading) in pairs(column, reference) {
            let error = reading / factor - truth;
            (cos, sin, count) = (cos + error.cos(), sin + error.sin(), count + 1.0);
        }
        f64::hypot(cos, sin) / f64::max(count, 1.0)
    };
    if alike(1.0) > UNLIKE {
        return None;
    }
    factors(column.unit).into_iter().find(|factor| alike(*factor) > ALIKE)
}

#[cfg(test)]
mod tests {
    use super::{DEGREES, factor, factor_of_angle, pairs};
    use crate::dataset::{Column, Role, Unit};
    use std::f64::consts::TAU;

    fn columns(of: impl Fn(f64) -> f64, unit: Unit) -> [Column; 2] {
        let truth: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.1).collect();
        let measured = truth.iter().map(|truth| of(*truth)).collect();
        [
            Column::new("measured", Role::Measured, unit, measured),
            Column::new("truth", Role::Reference, unit, truth),
        ]
    }

    #[test]
    fn only_what_follows_its_reference_has_a_factor() {
        let of = |of: fn(f64) -> f64, unit| {
            let [measured, truth] = columns(of, unit);
            factor(unit, pairs(&measured, &truth))
        };
        let rate = Unit::RadianPerSecond;
        assert_eq!(of(|truth| -0.97 * DEGREES * truth + 3.0, rate), Some(-DEGREES));
        assert_eq!(of(|truth| 1.1 * truth, rate), None);
        assert_eq!(of(|truth| (truth * 370.0).sin(), rate), None);
        // No volt is a degree.
        assert_eq!(of(|truth| DEGREES * truth, Unit::Volt), None);
        assert_eq!(of(|truth| 0.5 - truth, Unit::Volt), Some(-1.0));
        assert_eq!(of(|truth| -950.0 * truth, Unit::Volt), Some(-1e3));
        assert_eq!(of(|truth| 1.02e-3 * truth + 0.1, Unit::Metre), Some(1e-3));
        assert_eq!(of(|truth| 0.251 * truth, Unit::Count), Some(0.25));
        // A scale error of a sensor as it may be.
        assert_eq!(of(|truth| 3.6 * truth, Unit::Count), None);
        assert_eq!(of(|truth| 1e3 * truth, Unit::Celsius), None);
    }

    #[test]
    fn an_angle_that_keeps_turning_has_a_sign_too() {
        let of = |of: fn(f64) -> f64| {
            let [measured, truth] = columns(of, Unit::Radian);
            factor_of_angle(&measured, &truth)
        };
        assert_eq!(of(|truth| (2.0 - truth).rem_euclid(TAU)), Some(-1.0));
        assert_eq!(of(|truth| (truth + 0.4).rem_euclid(TAU)), None);
        assert_eq!(of(|truth| (truth % TAU) * DEGREES), Some(DEGREES));
    }
}
