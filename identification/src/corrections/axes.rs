//! Axes of a gyro that are wired to, or named as, one another.

use super::{AXES, Correction, Fault};
use crate::dataset::{Column, Dataset, Role};
use crate::robust::Moments;

/// Squared correlation from which an axis follows a rotation, and up to which it does not follow its own.
const FOLLOWS: f64 = 0.6;
const DOES_NOT: f64 = 0.3;

/// Which axis each reference is of, where every axis of the gyro follows one and some follow another than their own.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let gyros: Vec<&Column> = dataset
        .columns
        .iter()
        .filter(|one| matches!(one.role, Role::GyroRate | Role::GyroCounts) && one.axis.is_some())
        .collect();
    let references: Vec<&Column> =
        dataset.columns_of(Role::ReferenceRate).filter(|one| one.axis.is_some()).collect();
    let mut found = Vec::new();
    let mut taken: Vec<&str> = Vec::new();
    for gyro in &gyros {
        let follows = |reference: &&&Column| squared_correlation(&gyro.values, &reference.values);
        let own = references.iter().find(|reference| reference.axis == gyro.axis);
        let best = references.iter().max_by(|a, b| follows(a).total_cmp(&follows(b)));
        let Some((own, best)) = own.zip(best) else { return Vec::new() };
        // Two axes cannot follow the same rotation.
        if follows(&best) < FOLLOWS || taken.contains(&best.name.as_str()) {
            return Vec::new();
        }
        taken.push(&best.name);
        if best.name != own.name {
            if follows(&own) > DOES_NOT {
                return Vec::new();
            }
            let axis = AXES.iter().position(|axis| gyro.axis == Some(*axis)).unwrap_or(0);
            found.push(Correction::exact(Fault::WrongAxis, &best.name, axis as f64));
        }
    }
    // Whole axes change places.
    let is_permutation = found.iter().all(|one| {
        let goes_to = references.iter().find(|other| {
            AXES.iter().position(|axis| other.axis == Some(*axis)) == Some(one.value as usize)
        });
        goes_to.is_some_and(|other| found.iter().any(|moved| moved.field == other.name))
    });
    if is_permutation { found } else { Vec::new() }
}

/// Squared correlation of the rows in which both are known.
pub(crate) fn squared_correlation(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().copied().zip(b.iter().copied());
    let Moments { xx, xy, yy, .. } = Moments::of(pairs.filter(|(a, b)| (a + b).is_finite()));
    if xx > 0.0 && yy > 0.0 { xy * xy / (xx * yy) } else { 0.0 }
}
