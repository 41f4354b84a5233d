//! What is wrong with the wheels of a robot or with its reference: by how much a steered wheel is scaled and offset, where the
//! reference looks and sits, and when it comes.

use super::fit::{Fit, left, minimum};
use super::legs::{LEGS_MIN, Leg, Poses, Wheels, clusters};
use super::signs::wheels_of;
use super::{Correction, Fault, applied};
use crate::dataset::{Column, Constant, Dataset, Dimension, Drive, Role, Unit};
use crate::fit::Data;
use crate::model::{Acts, Shape};
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Channels, Known, Problem, motion};

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
        found.extend(steering(dataset).unwrap_or_default());
    }
    for next in [mean_speed, offset, delay, beside] {
        found.extend(next(&applied(dataset, &found)));
    }
    found
}

/// Legs from which times and directions are told, without those over which the robot turned so far that the headings at their
/// ends do not tell how often.
fn legs(poses: &Poses, dataset: &Dataset) -> Option<Vec<Leg>> {
    let wheels = Wheels::new(dataset)?;
    let legs = poses.legs(SHORT);
    let side = poses.sums(&legs, &wheels.side, 0.0);
    let is_told = |(leg, side): &(Leg, f64)| {
        (side / wheels.metres_per_radian - leg.turned).abs() < std::f64::consts::PI
    };
    Some(legs.into_iter().zip(side).filter(is_told).map(|(leg, _)| leg).collect())
}

/// Speeds that are means since the row before, where the reference is likelier so, beside the delay that it needs each way: a mean
/// is half a row late, and needs none.
fn mean_speed(dataset: &Dataset) -> Option<Correction> {
    let is_speed =
        |one: &&Column| matches!(one.unit.dimension(), Dimension::Speed | Dimension::AngularRate);
    let name = &wheels_of(dataset).find(is_speed)?.name;
    let mean = Correction::exact(Fault::MeanSpeed, name, 1.0);
    if dataset.constants.contains_key(Constant::MEAN_SPEED) {
        return None;
    }
    let means = applied(dataset, std::slice::from_ref(&mean));
    let read = [dataset, &means].map(|one| {
        let late = delay(one);
        (applied(one, late.as_slice()), late.map_or(0.0, |_| SURE * SURE / 2.0))
    });
    let [stated, other] = likelihoods([&read[0].0, &read[1].0])?;
    ((other - read[1].1) - (stated - read[0].1) > LIKELIER).then_some(mean)
}

/// Surprise from which one way of reading speeds is likelier than the other, in nats: 1 %.
const LIKELIER: f64 = 4.6;

/// Logarithms of the likelihoods of the poses as two readings of one path have them, with the constants of the drive and noise
/// at their best for each.
fn likelihoods(read: [&Dataset; 2]) -> Option<[f64; 2]> {
    let problems = read.map(|one| Problem::new(one, Known::default()).ok());
    let [Some(stated), Some(other)] = &problems else { return None };
    let acts = [Acts::Turn, Acts::Curvature, Acts::Drive, Acts::Reference];
    let shapes = acts.map(|acts| Shape::constant("constant", acts));
    let noise = |problem: &Problem, start: Option<&NoiseModel>| {
        let block = problem.blocks.first().filter(|block| block.pose.is_some())?;
        let channels = problem.channels_of(block);
        let layout = Layout::new(block, channels);
        let data = Data::new(block, channels, &layout);
        let columns = data.all_columns(&shapes);
        let residual = data.residual(&columns);
        Some(start.map_or_else(|| (residual.fit(), 0.0), |start| residual.retune(start)))
    };
    // The same readings count as outliers in both.
    let (start, _) = noise(stated, None)?;
    let of = |problem| noise(problem, Some(&start)).map(|(_, likelihood)| likelihood);
    Some([of(stated)?, of(other)?])
}

/// An offset of the heading of the reference: on a straight line the robot seems to drive askew.
fn offset(dataset: &Dataset) -> Option<Correction> {
    let poses = Poses::new(dataset)?;
    let legs = legs(&poses, dataset)?;
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
    let legs = legs(&poses, dataset)?;
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
struct Timing {
    late: f64,
    error: f64,
    /// What is left of turns and distances with that, and without.
    best: Fit,
    at_once: Fit,
    cluster: Vec<usize>,
}

impl Timing {
    fn of(dataset: &Dataset) -> Option<Self> {
        let poses = Poses::new(dataset)?;
        let is_timed = dataset.column(Role::Time)?.unit.dimension() == Dimension::Time;
        let legs = legs(&poses, dataset)?;
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
        Some(Self { late, error, best: fit(late), at_once: fit(0.0), cluster: clusters(&legs) })
    }
}

fn delay(dataset: &Dataset) -> Option<Correction> {
    let Timing { late, error, best, at_once, cluster } = Timing::of(dataset)?;
    let name = &dataset.column(Role::ReferenceHeading)?.name;
    let sure = late.abs() > SURE * error && late.abs() < LATE_MAX;
    (sure && best.is_better(&at_once, &cluster))
        .then(|| Correction::fitted(Fault::ReferenceDelay, name, (late, error), Unit::Second))
}

/// Number of legs from which the angle is told.
const LEGS: usize = 400;
/// A steered wheel turns by no more than this, rad, but in a parking garage.
const ANGLE_MAX: f64 = 1.75;

/// Scale and offset of the steered wheel of a tricycle, where they matter. The sine and the cosine of its angle tell both, which
/// no straight line over it can.
fn steering(dataset: &Dataset) -> Option<Vec<Correction>> {
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
