//! What is wrong with the wheels of a robot or with its reference: signs, exchanged wheels, the unit of the heading,
//! where the reference looks and when it comes.

use super::fit::{Fit, left, minimum};
use super::legs::{Leg, Poses, clusters};
use super::steering;
use super::{Correction, Fault, applied};
use crate::dataset::{Constant, Dataset, Dimension, Drive, Role, Unit};
use crate::linear::dot;
use crate::problem::{Channels, motion};

/// Number of legs from which signs are told: long, so that they are motion and not noise.
const LONG: usize = 600;
/// Number of legs from which times and directions are told.
const SHORT: usize = 1500;
/// Maximum number of legs that have no pair of runs and no certainty.
const LEGS_MIN: usize = 24;
/// Range of the turn and of the distance over what the wheels say, with signs set right.
const TURN: [f64; 2] = [0.2, 1.5];
const DISTANCE: [f64; 2] = [0.5, 2.0];
/// Share of what the package leaves that signs set right must leave at most.
const LEAVES_MAX: f64 = 0.5;
/// Standard errors from which a size is not zero: it was chosen as the most likely one.
const SURE: f64 = 5.0;
/// Smallest offset of a heading worth a correction, rad: what a careful mount reaches.
const OFFSET_MIN: f64 = 0.005;

/// Motion of each row by the wheels, if a metre counts as half a radian of both: the distance, and half the difference.
pub(super) struct Wheels {
    pub distance: Vec<f64>,
    pub side: Vec<f64>,
    /// Metres of `side` for a turn of one radian, as the package says.
    metres_per_radian: f64,
}

impl Wheels {
    fn new(dataset: &Dataset) -> Option<Self> {
        let channels = Channels::new(dataset);
        let found = motion(dataset, &channels).ok()?;
        let names = ["wheelbase", "track", "track_width", "wheel_base", "wheel_track"];
        let track = names.iter().find_map(|name| dataset.constants.get(*name));
        let is_pair = dataset.column(Role::WheelLeft).is_some();
        let metres_per_radian = match track {
            Some(track) if is_pair => track.si() / 2.0,
            _ => 1.0,
        };
        let side = found.turn.iter().map(|turn| turn * metres_per_radian).collect();
        Some(Self { distance: found.distance, side, metres_per_radian })
    }
}

/// What `dataset` states wrongly.
pub(super) fn find(dataset: &Dataset) -> Vec<Correction> {
    let Some(poses) = Poses::new(dataset) else { return Vec::new() };
    let mut found = signs(dataset, &poses).unwrap_or_default();
    let add = |more: Vec<Correction>, found: &mut Vec<Correction>| found.extend(more);
    if dataset.drive == Some(Drive::Tricycle) {
        add(steering::find(&applied(dataset, &found)), &mut found);
    }
    let right = applied(dataset, &found);
    add(offset(&right).into_iter().collect(), &mut found);
    let right = applied(dataset, &found);
    add(delay(&right).into_iter().collect(), &mut found);
    let right = applied(dataset, &found);
    add(beside(&right).into_iter().collect(), &mut found);
    found
}

/// One way to read the wheels and the heading.
struct Reading {
    corrections: Vec<Correction>,
    /// Factor of the heading.
    heading: f64,
    /// Signs of distance and side, and whether the two change places.
    distance: f64,
    side: f64,
    crossed: bool,
}

fn readings(dataset: &Dataset) -> Vec<Reading> {
    let name = |role| dataset.column(role).map(|column| column.name.clone());
    let heading = name(Role::ReferenceHeading).unwrap_or_default();
    let reversed = |field: &Option<String>| {
        Correction::exact(Fault::ReversedSign, field.as_deref().unwrap_or_default(), -1.0)
    };
    let looks_back = || Correction {
        unit: Unit::Degree,
        ..Correction::exact(Fault::HeadingOffset, &heading, 180.0)
    };
    let (left, right) = (name(Role::WheelLeft), name(Role::WheelRight));
    let exchanged =
        || Correction::exact(Fault::ExchangedWheels, left.as_deref().unwrap_or_default(), 1.0);
    let mut wheels: Vec<(f64, f64, bool, Vec<Correction>)> = vec![(1.0, 1.0, false, Vec::new())];
    if left.is_some() {
        wheels.extend([
            (1.0, 1.0, true, vec![reversed(&left)]),
            (-1.0, -1.0, true, vec![reversed(&right)]),
            (1.0, -1.0, false, vec![exchanged()]),
            (-1.0, -1.0, false, vec![reversed(&left), reversed(&right)]),
            (-1.0, 1.0, false, vec![looks_back()]),
            (1.0, -1.0, true, vec![reversed(&left), exchanged()]),
            (-1.0, 1.0, true, vec![reversed(&right), exchanged()]),
        ]);
    } else {
        let (way, steer) = (name(Role::DriveDistance), name(Role::SteerAngle));
        let both = match dataset.drive {
            Some(Drive::Tricycle) => vec![reversed(&way)],
            _ => vec![reversed(&way), reversed(&steer)],
        };
        wheels.extend([
            (1.0, -1.0, false, vec![reversed(&steer)]),
            (-1.0, 1.0, false, vec![looks_back()]),
            (-1.0, -1.0, false, both),
        ]);
    }
    let degree = Unit::Degree.si();
    let is_radian =
        dataset.column(Role::ReferenceHeading).is_some_and(|column| column.unit == Unit::Radian);
    let (unit, factor) = match is_radian {
        true => (Correction::exact(Fault::DegreesForRadians, &heading, 1.0 / degree), degree),
        false => (Correction::exact(Fault::RadiansForDegrees, &heading, degree), 1.0 / degree),
    };
    let backwards = Correction::exact(Fault::ReversedSign, &heading, -1.0);
    let headings = [
        (1.0, Vec::new()),
        (-1.0, vec![backwards.clone()]),
        (factor, vec![unit.clone()]),
        (-factor, vec![unit, backwards]),
    ];
    let mut found = Vec::new();
    for (heading, first) in headings {
        for (distance, side, crossed, more) in &wheels {
            let corrections = first.iter().chain(more).cloned().collect();
            let (distance, side, crossed) = (*distance, *side, *crossed);
            found.push(Reading { corrections, heading, distance, side, crossed });
        }
    }
    found
}

/// Signs, exchanged wheels and the unit of the heading: of all readings the one that follows the reference best, where
/// it leaves much less than the package's own.
fn signs(dataset: &Dataset, poses: &Poses) -> Option<Vec<Correction>> {
    let wheels = Wheels::new(dataset)?;
    let mut best: Option<(f64, Vec<Correction>)> = None;
    let mut stated = f64::NAN;
    let mut legs: Vec<Leg> = Vec::new();
    let (mut heading, mut distance, mut side) = (f64::NAN, Vec::new(), Vec::new());
    for reading in readings(dataset) {
        if heading != reading.heading {
            heading = reading.heading;
            legs = poses.legs(LONG, heading);
            if legs.len() < LEGS_MIN {
                return None;
            }
            distance = poses.sums(&legs, &wheels.distance, 0.0);
            side = poses.sums(&legs, &wheels.side, 0.0);
        }
        let (ahead, around) = if reading.crossed { (&side, &distance) } else { (&distance, &side) };
        let turn: Vec<f64> =
            around.iter().map(|side| reading.side * side / wheels.metres_per_radian).collect();
        let ahead: Vec<f64> = ahead.iter().map(|way| reading.distance * way).collect();
        let of = |part: fn(&Leg) -> f64| legs.iter().map(part).collect::<Vec<f64>>();
        let leaves = (leaves(&turn, &of(|leg| leg.turned), TURN)
            + leaves(&ahead, &of(|leg| leg.along), DISTANCE))
            / 2.0;
        if stated.is_nan() {
            stated = leaves;
        }
        if best.as_ref().is_none_or(|(least, _)| leaves < 0.9 * least) {
            best = Some((leaves, reading.corrections));
        }
    }
    let (leaves, corrections) = best?;
    (leaves < LEAVES_MAX * stated && leaves < LEAVES_MAX).then_some(corrections)
}

/// Share of the squares of `seen` that the best multiple of `said` within `range` leaves.
fn leaves(said: &[f64], seen: &[f64], range: [f64; 2]) -> f64 {
    let (square, total) = (dot(said, said), dot(seen, seen));
    if !(square > 0.0 && total > 0.0) {
        return 1.0;
    }
    let slope = (dot(said, seen) / square).clamp(range[0], range[1]);
    let left: f64 = said.iter().zip(seen).map(|(said, seen)| (seen - slope * said).powi(2)).sum();
    left / total
}

/// An offset of the heading of the reference: on a straight line the robot seems to drive askew.
fn offset(dataset: &Dataset) -> Option<Correction> {
    let poses = Poses::new(dataset)?;
    let legs = poses.legs(SHORT, 1.0);
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
    let legs = poses.legs(SHORT, 1.0);
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
    let legs = poses.legs(SHORT, 1.0);
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
