//! What is wrong with the wheels of a robot or with its reference: how they are to be read, where the reference looks and
//! sits, and when it comes.

use super::fit::{Fit, left, minimum};
use super::legs::{LEGS_MIN, Leg, Poses, clusters};
use super::wheels::Wheels;
use super::{Correction, Fault, applied, steering};
use crate::dataset::{Constant, Dataset, Dimension, Drive, Role, Unit};

/// Number of legs from which times and directions are told.
const SHORT: usize = 1500;
/// Standard errors from which a size is not zero: it was chosen as the most likely one.
const SURE: f64 = 5.0;
/// Smallest offset of a heading worth a correction, rad: what a careful mount reaches.
const OFFSET_MIN: f64 = 0.005;

/// What `dataset`, which is read rightly, states wrongly.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let mut found = Vec::new();
    if dataset.drive == Some(Drive::Tricycle) {
        found.extend(steering::find(dataset));
    }
    for next in [offset, delay, beside] {
        found.extend(next(&applied(dataset, &found)));
    }
    found
}

/// An offset of the heading of the reference: on a straight line the robot seems to drive askew.
fn offset(dataset: &Dataset) -> Option<Correction> {
    let poses = Poses::new(dataset)?;
    let legs = poses.legs(SHORT);
    if legs.len() < LEGS_MIN {
        return None;
    }
    let of = |part: fn(&Leg) -> f64| legs.iter().map(part).collect::<Vec<f64>>();
    let (along, turned, aside) = (of(|leg| leg.along), of(|leg| leg.turned), of(|leg| leg.aside));
    // A reference ahead of the axle or beside it moves with the turn.
    let fit = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let askew: Vec<f64> =
            aside.iter().zip(&along).map(|(aside, along)| cos * aside - sin * along).collect();
        Fit(vec![left(&[&turned], &askew)])
    };
    let ([angle], [error]) = minimum([0.0], [0.02], |[angle]| fit(angle).cost());
    let sure = angle.abs() > (SURE * error).max(OFFSET_MIN) && angle.abs() < 0.8;
    let name = &dataset.column(Role::ReferenceHeading)?.name;
    (sure && fit(angle).is_better(&fit(0.0), &clusters(&legs)))
        .then(|| Correction::fitted(Fault::HeadingOffset, name, (-angle, error), Unit::Degree))
}

/// Smallest distance beside the axle worth a correction, m.
const BESIDE_MIN: f64 = 0.003;

/// How far beside the middle of the axle the reference sits: ahead of a turn to the left it lags behind.
fn beside(dataset: &Dataset) -> Option<Correction> {
    let poses = Poses::new(dataset)?;
    let legs = poses.legs(SHORT);
    if legs.len() < LEGS_MIN {
        return None;
    }
    let stated = |name| dataset.constants.get(name).map_or(0.0, Constant::si);
    let late = stated(Constant::REFERENCE_DELAY);
    let distance = poses.sums(&legs, &Wheels::new(dataset)?.distance, late);
    let stated = stated(Constant::REFERENCE_LEFT);
    let fit = |left_of: f64| {
        let moved = |leg: &Leg| leg.along + (stated + left_of) * leg.turned;
        let along: Vec<f64> = legs.iter().map(moved).collect();
        Fit(vec![left(&[&distance], &along)])
    };
    let ([aside], [error]) = minimum([0.0], [0.05], |[aside]| fit(aside).cost());
    let sure = aside.abs() > (SURE * error).max(BESIDE_MIN) && aside.abs() < 5.0;
    let name = &dataset.column(Role::ReferenceX)?.name;
    (sure && fit(aside).is_better(&fit(0.0), &clusters(&legs)))
        .then(|| Correction::fitted(Fault::ReferenceLeft, name, (aside, error), Unit::Metre))
}

/// Maximum delay of a reference, s.
const LATE_MAX: f64 = 1.0;
/// Number of delays tried at first, on either side of none.
const TRIED: i32 = 25;

/// How much later than the wheels the reference comes.
fn delay(dataset: &Dataset) -> Option<Correction> {
    let poses = Poses::new(dataset)?;
    let is_timed = dataset.column(Role::Time)?.unit.dimension() == Dimension::Time;
    let legs = poses.legs(SHORT);
    if !is_timed || legs.len() < LEGS_MIN {
        return None;
    }
    let wheels = Wheels::new(dataset)?;
    let of = |part: fn(&Leg) -> f64| legs.iter().map(part).collect::<Vec<f64>>();
    let (along, turned) = (of(|leg| leg.along), of(|leg| leg.turned));
    let fit = |late: f64| {
        let distance = poses.sums(&legs, &wheels.distance, late);
        let side = poses.sums(&legs, &wheels.side, late);
        let both: [&[f64]; 2] = [&distance, &side];
        Fit(vec![left(&both, &turned), left(&both, &along)])
    };
    let step = LATE_MAX / f64::from(TRIED);
    let tried = (-TRIED..=TRIED).map(|i| f64::from(i) * step);
    let first = tried.min_by(|a, b| fit(*a).cost().total_cmp(&fit(*b).cost()))?;
    let ([late], [error]) = minimum([first], [step / 2.0], |[late]| fit(late).cost());
    let name = &dataset.column(Role::ReferenceHeading)?.name;
    let sure = late.abs() > SURE * error && late.abs() < LATE_MAX;
    (sure && fit(late).is_better(&fit(0.0), &clusters(&legs)))
        .then(|| Correction::fitted(Fault::ReferenceDelay, name, (late, error), Unit::Second))
}
