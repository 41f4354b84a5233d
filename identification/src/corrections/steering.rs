//! The steered wheel of a tricycle: by how much its angle is scaled and offset. The sine and the cosine of the angle tell
//! both, which no straight line over it can.

use super::fit::{Fit, left, minimum};
use super::legs::{LEGS_MIN, Leg, Poses, clusters};
use super::{Correction, Fault};
use crate::dataset::{Dataset, Role, Unit};
use crate::problem::{Channels, motion};

/// Number of legs.
const LEGS: usize = 400;
/// Standard errors from which a size is not what the package says.
const SURE: f64 = 5.0;
/// A steered wheel turns by no more than this, rad, but in a parking garage.
const ANGLE_MAX: f64 = 1.75;

/// Scale and offset of the steering angle, where they matter.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    find_in(dataset).unwrap_or_default()
}

fn find_in(dataset: &Dataset) -> Option<Vec<Correction>> {
    let poses = Poses::new(dataset)?;
    let legs = poses.legs(LEGS);
    if legs.len() < LEGS_MIN {
        return None;
    }
    let motion = motion(dataset, &Channels::new(dataset)).ok()?;
    let (_, angles) = motion.steer.as_ref()?;
    let base = dataset.constants.get("wheelbase")?.si();
    // The way of the wheel itself.
    let ways: Vec<f64> = (0..angles.len())
        .map(|row| {
            let (sin, cos) = angles[row].sin_cos();
            motion.distance[row] * cos + motion.turn[row] * base * sin
        })
        .collect();
    let of = |part: fn(&Leg) -> f64| legs.iter().map(part).collect::<Vec<f64>>();
    let (along, turned) = (of(|leg| leg.along), of(|leg| leg.turned));
    let largest = angles.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
    let fit = |scale: f64, offset: f64| {
        let of = |part: fn(f64) -> f64| -> Vec<f64> {
            let row = |(way, angle): (&f64, &f64)| way * part(scale * angle + offset);
            poses.sums(&legs, &ways.iter().zip(angles).map(row).collect::<Vec<f64>>(), 0.0)
        };
        // A reference beside the axle moves with the turn.
        let turn = of(f64::sin);
        Fit(vec![left(&[&turn], &turned), left(&[&of(f64::cos), &turn], &along)])
    };
    let cost = |scale: f64, offset: f64| {
        if scale <= 0.0 || scale * largest > ANGLE_MAX.max(largest) {
            return f64::INFINITY;
        }
        fit(scale, offset).cost()
    };
    let scales = (-12..=12).map(|i| 1.2_f64.powi(i));
    let tried = scales.flat_map(|scale| [-0.2, 0.0, 0.2].map(|offset| (scale, offset)));
    let first = tried.min_by(|a, b| cost(a.0, a.1).total_cmp(&cost(b.0, b.1)))?;
    let both =
        minimum([first.0.ln(), first.1], [0.05, 0.02], |[scale, offset]| cost(scale.exp(), offset));
    let alone = minimum([0.0], [0.02], |[offset]| cost(1.0, offset));
    let ([scale, offset], [scale_error, offset_error]) = both;
    let ([offset_alone], [alone_error]) = alone;
    let name = &dataset.column(Role::SteerAngle)?.name;
    let cluster = clusters(&legs);
    let is_sure = |value: f64, error: f64| value.abs() > SURE * error;
    let mut found = Vec::new();
    let add =
        |fault, value: f64, error: f64, unit| Correction::fitted(fault, name, (value, error), unit);
    let factor = scale.exp();
    let scaled = fit(factor, offset);
    if is_sure(scale, scale_error) && scaled.is_better(&fit(1.0, offset_alone), &cluster) {
        found.push(add(Fault::SteerScale, factor, factor * scale_error, Unit::One));
        if is_sure(offset, offset_error) && scaled.is_better(&fit(factor, 0.0), &cluster) {
            found.push(add(Fault::SteerOffset, offset, offset_error, Unit::Degree));
        }
    } else if is_sure(offset_alone, alone_error)
        && fit(1.0, offset_alone).is_better(&fit(1.0, 0.0), &cluster)
    {
        found.push(add(Fault::SteerOffset, offset_alone, alone_error, Unit::Degree));
    }
    Some(found)
}
