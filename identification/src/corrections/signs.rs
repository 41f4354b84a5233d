//! How the wheels and the poses of a robot are to be read: signs, exchanged fields, units, counts that add up.

use super::legs::{Frame, LEGS_MIN, Leg, Poses, Wheels, leaves};
use super::{Correction, Fault, applied};
use crate::dataset::{Column, Dataset, Dimension, Drive, Role, Unit};
use crate::problem::TRACK;

/// Number of legs: long, so that they are motion and not noise.
const LONG: usize = 600;
/// Range of the turn and of the distance over what the wheels say, with signs set right.
const TURN: [f64; 2] = [0.2, 1.5];
const DISTANCE: [f64; 2] = [0.5, 2.0];
/// The same of the distance where a factor is set right: what is nearly halfway is no factor.
const NEAR: [f64; 2] = [0.8, 1.25];
/// Share of the motion, and of what the package leaves of it, that signs set right must leave at most; half as much where
/// a factor is.
const LEAVES_MAX: f64 = 0.5;
/// Share of the motion that a further correction must explain.
const GAIN: f64 = 0.01;
/// A package that leaves less of it is read rightly.
const LEAVES_LITTLE: f64 = 0.1;
/// Share of the turn that the best reading leaves where noise is most of it, as on a straight road: the distance alone tells
/// there.
const TURN_TELLS: f64 = 0.5;

/// One mistake, or several, and what it does to what is compared.
#[derive(Clone)]
struct Reading<T> {
    corrections: Vec<Correction>,
    does: T,
}

impl<T> Reading<T> {
    fn new(corrections: Vec<Correction>, does: T) -> Self {
        Self { corrections, does }
    }
}

/// Signs of distance and side, and whether the two change places.
type Wheel = (f64, f64, bool);
const AS_STATED: Wheel = (1.0, 1.0, false);
/// Times what the wheels say of distance and turn.
type Size = (f64, f64);

/// Of all readings the one with the fewest corrections that follows the reference best, where it leaves much less than
/// the package's own.
pub(super) fn find(dataset: &Dataset) -> Option<Vec<Correction>> {
    let poses = &Poses::new(dataset)?;
    let legs = poses.legs(LONG);
    if legs.len() < LEGS_MIN {
        return None;
    }
    let stated =
        Seen::new(&legs, &Wheels::new(dataset)?, poses).leaves(AS_STATED, (1.0, 1.0), DISTANCE);
    if stated.of_both() < LEAVES_LITTLE {
        return None;
    }
    let (wheels, frames) = (wheels(dataset), frames(dataset));
    let sizes = sizes(dataset);
    let mut tried: Vec<(Leaves, Vec<Correction>)> = Vec::new();
    let given = added_up(dataset).into_iter().chain(one_wheel(dataset));
    for given in std::iter::once(Reading::new(Vec::new(), ())).chain(given) {
        let said = Wheels::new(&applied(dataset, &given.corrections))?;
        for frame in &frames {
            let legs = poses.legs_in(LONG, &frame.does);
            let seen = Seen::new(&legs, &said, poses);
            for wheel in &wheels {
                // Two factors of a turn make up for any that it has.
                let factors = usize::from(!given.corrections.is_empty())
                    + usize::from(frame.does.heading.abs() != 1.0);
                let alone = |size: &&Reading<Size>| factors + usize::from(size.does.1 != 1.0) < 2;
                for size in sizes.iter().filter(alone) {
                    let is_stated = size.does == (1.0, 1.0) && !is_count(&given.corrections);
                    let range = if is_stated { DISTANCE } else { NEAR };
                    let parts = [&given.corrections, &frame.corrections, &wheel.corrections];
                    let corrections = [&parts[..], &[&size.corrections]].concat();
                    let corrections = corrections.into_iter().flatten().cloned().collect();
                    tried.push((seen.leaves(wheel.does, size.does, range), corrections));
                }
            }
        }
    }
    let least = tried.iter().map(|(leaves, _)| leaves.turn).fold(f64::INFINITY, f64::min);
    let of = if least < TURN_TELLS { Leaves::of_both } else { |leaves: &Leaves| leaves.distance };
    let stated = of(&stated);
    if stated < LEAVES_LITTLE {
        return None;
    }
    let mut tried: Vec<(f64, Vec<Correction>)> =
        tried.into_iter().map(|(leaves, corrections)| (of(&leaves), corrections)).collect();
    tried.sort_by_key(|(_, corrections)| corrections.len());
    // What is right leaves so little that more corrections gain nothing.
    let better = |best: (f64, Vec<Correction>), one: (f64, Vec<Correction>)| {
        let is_simpler = one.1.len() == best.1.len();
        let gains = one.0 < 0.9 * best.0 && (is_simpler || best.0 - one.0 > GAIN);
        if gains { one } else { best }
    };
    let (leaves, corrections) = tried.into_iter().reduce(better)?;
    let is_factor = |one: &Correction| matches!(one.fault, Fault::WrongUnit | Fault::AddedUp);
    let limit = if corrections.iter().any(is_factor) { LEAVES_MAX / 2.0 } else { LEAVES_MAX };
    (leaves < limit * stated.min(1.0)).then_some(corrections)
}

/// Shares of the reference's turn and distance that the wheels leave.
struct Leaves {
    turn: f64,
    distance: f64,
}

impl Leaves {
    fn of_both(&self) -> f64 {
        (self.turn + self.distance) / 2.0
    }
}

/// Motion over legs by the wheels and by the reference.
struct Seen {
    distance: Vec<f64>,
    side: Vec<f64>,
    metres_per_radian: f64,
    along: Vec<f64>,
    turned: Vec<f64>,
}

impl Seen {
    fn new(legs: &[Leg], said: &Wheels, poses: &Poses) -> Self {
        Self {
            distance: poses.sums(legs, &said.distance, 0.0),
            side: poses.sums(legs, &said.side, 0.0),
            metres_per_radian: said.metres_per_radian,
            along: legs.iter().map(|leg| leg.along).collect(),
            turned: legs.iter().map(|leg| leg.turned).collect(),
        }
    }

    /// Shares of the reference's motion that the wheels leave if they are read so, and the distance is within `range` of theirs.
    fn leaves(
        &self,
        (distance, side, crossed): Wheel,
        (far, around): Size,
        range: [f64; 2],
    ) -> Leaves {
        let (ahead, turn) = match crossed {
            true => (&self.side, &self.distance),
            false => (&self.distance, &self.side),
        };
        let times = |factor: f64, range: [f64; 2]| range.map(|end| end * factor);
        let [low, high] = times(side / self.metres_per_radian * around, TURN);
        let turn = leaves(turn, &self.turned, [low.min(high), low.max(high)]);
        let [low, high] = times(distance * far, range);
        let distance = leaves(ahead, &self.along, [low.min(high), low.max(high)]);
        Leaves { turn, distance }
    }
}

fn name(dataset: &Dataset, role: Role) -> Option<String> {
    dataset.column(role).map(|column| column.name.clone())
}

/// What the wheels say of the way.
pub(super) fn wheels_of(dataset: &Dataset) -> impl Iterator<Item = &Column> {
    let roles = [Role::WheelLeft, Role::WheelRight, Role::DriveDistance];
    dataset.columns.iter().filter(move |one| roles.contains(&one.role))
}

fn reversed(field: &str) -> Correction {
    Correction::exact(Fault::ReversedSign, field, -1.0)
}

/// Signs of the wheels, and wheels that changed places.
fn wheels(dataset: &Dataset) -> Vec<Reading<Wheel>> {
    let name = |role| name(dataset, role).unwrap_or_default();
    let looks_back = || Correction {
        unit: Unit::Degree,
        ..Correction::exact(Fault::HeadingOffset, &name(Role::ReferenceHeading), 180.0)
    };
    let mut found = vec![Reading::new(Vec::new(), AS_STATED)];
    let mut add = |does, corrections| found.push(Reading::new(corrections, does));
    if dataset.column(Role::WheelLeft).is_some() {
        let left = || reversed(&name(Role::WheelLeft));
        let right = || reversed(&name(Role::WheelRight));
        let exchanged = || Correction::exact(Fault::ExchangedWheels, &name(Role::WheelLeft), 1.0);
        add((1.0, 1.0, true), vec![left()]);
        add((-1.0, -1.0, true), vec![right()]);
        add((1.0, -1.0, false), vec![exchanged()]);
        add((-1.0, -1.0, false), vec![left(), right()]);
        add((-1.0, 1.0, false), vec![looks_back()]);
        add((1.0, -1.0, true), vec![left(), exchanged()]);
        add((-1.0, 1.0, true), vec![right(), exchanged()]);
    } else {
        let way = || reversed(&name(Role::DriveDistance));
        let steer = || reversed(&name(Role::SteerAngle));
        add((1.0, -1.0, false), vec![steer()]);
        add((-1.0, 1.0, false), vec![looks_back()]);
        let both = match dataset.drive {
            Some(Drive::Tricycle) => vec![way()],
            _ => vec![way(), steer()],
        };
        add((-1.0, -1.0, false), both);
    }
    found
}

/// Signs and the unit of the heading, and positions in which x and y, or a sign of one, are exchanged.
fn frames(dataset: &Dataset) -> Vec<Reading<Frame>> {
    let name = |role| name(dataset, role).unwrap_or_default();
    let heading = name(Role::ReferenceHeading);
    let degree = Unit::Degree.si();
    let is_radian =
        dataset.column(Role::ReferenceHeading).is_some_and(|column| column.unit == Unit::Radian);
    let (unit, factor) = match is_radian {
        true => (Correction::exact(Fault::DegreesForRadians, &heading, 1.0 / degree), degree),
        false => (Correction::exact(Fault::RadiansForDegrees, &heading, degree), 1.0 / degree),
    };
    let headings = [
        (1.0, Vec::new()),
        (-1.0, vec![reversed(&heading)]),
        (factor, vec![unit.clone()]),
        (-factor, vec![unit, reversed(&heading)]),
    ];
    let plain = Frame::default();
    let exchanged = Correction::exact(Fault::ExchangedAxes, &name(Role::ReferenceX), 1.0);
    let positions = [
        (plain, Vec::new()),
        (Frame { is_exchanged: true, ..plain }, vec![exchanged]),
        (Frame { y: -1.0, ..plain }, vec![reversed(&name(Role::ReferenceY))]),
        (Frame { x: -1.0, ..plain }, vec![reversed(&name(Role::ReferenceX))]),
    ];
    let of_position = |(frame, moved): (Frame, Vec<Correction>)| {
        headings.clone().map(|(heading, corrections)| {
            Reading::new([corrections, moved.clone()].concat(), Frame { heading, ..frame })
        })
    };
    positions.into_iter().flat_map(of_position).collect()
}

/// Wheels that count from the beginning where the package says since the row before, or a speed; a steering angle in
/// another unit.
fn added_up(dataset: &Dataset) -> Vec<Reading<()>> {
    let added = |one: &&Column| {
        let dimension = one.unit.dimension();
        matches!(dimension, Dimension::Count | Dimension::AngularRate | Dimension::Speed)
    };
    let sums = wheels_of(dataset).filter(added);
    let sums: Vec<Correction> =
        sums.map(|one| Correction::exact(Fault::AddedUp, &one.name, 1.0)).collect();
    let degree = Unit::Degree.si();
    let steer = dataset.columns_of(Role::SteerAngle).filter_map(|one| match one.unit {
        Unit::Radian => Some((one, Fault::DegreesForRadians, 1.0 / degree)),
        Unit::Degree => Some((one, Fault::RadiansForDegrees, degree)),
        _ => None,
    });
    let steer: Vec<Correction> =
        steer.map(|(one, fault, value)| Correction::exact(fault, &one.name, value)).collect();
    let found = [sums, steer].into_iter().filter(|corrections| !corrections.is_empty());
    found.map(|corrections| Reading::new(corrections, ())).collect()
}

/// Edges that count four times or twice, or once in so many, at one of the wheels.
const EDGES: [f64; 4] = [4.0, 2.0, 0.5, 0.25];

fn one_wheel(dataset: &Dataset) -> Vec<Reading<()>> {
    let counts = |one: &&Column| one.unit.dimension() == Dimension::Count;
    let pair = [Role::WheelLeft, Role::WheelRight].map(|role| dataset.column(role).filter(counts));
    let [Some(left), Some(right)] = pair else { return Vec::new() };
    let of = |one: &Column| {
        EDGES.map(|times| {
            Reading::new(vec![Correction::exact(Fault::WrongUnit, &one.name, times)], ())
        })
    };
    [left, right].into_iter().flat_map(of).collect()
}

/// Whether one of them says that a wheel counts wrongly.
fn is_count(corrections: &[Correction]) -> bool {
    corrections.iter().any(|one| EDGES.contains(&one.value))
}

/// Metres in millimetres: of the reference, of the wheels, of the distance between them; speeds of the wheels in km/h; radians
/// of the wheels in degrees; and encoders whose edges count four times, or once in four.
fn sizes(dataset: &Dataset) -> Vec<Reading<Size>> {
    const MILLI: f64 = 1e3;
    const KMH: f64 = 3.6;
    let of_field = |factor: f64, role: Role| {
        name(dataset, role).map(|field| Correction::exact(Fault::WrongUnit, &field, factor))
    };
    let of_constants = |factor: f64, is_one: &dyn Fn(&str) -> bool| -> Vec<Correction> {
        let names = dataset.constants.keys().filter(|name| is_one(name));
        names.map(|name| Correction::exact(Fault::WrongUnit, name, factor)).collect()
    };
    let is_size = |name: &str| {
        name.starts_with("wheel_diameter")
            || name.starts_with("wheel_radius")
            || name.ends_with("metres_per_count")
    };
    let is_way =
        |one: &&Column| matches!(one.unit.dimension(), Dimension::Length | Dimension::Speed);
    let ways = wheels_of(dataset).filter(is_way);
    let mut sizes: Vec<Correction> =
        ways.map(|one| Correction::exact(Fault::WrongUnit, &one.name, MILLI)).collect();
    if sizes.is_empty() {
        sizes = of_constants(MILLI, &is_size);
    }
    let track = TRACK.iter().find(|name| dataset.constants.contains_key(**name));
    let track: Vec<Correction> =
        track.map(|name| Correction::exact(Fault::WrongUnit, name, MILLI)).into_iter().collect();
    let reference: Vec<Correction> = [Role::ReferenceX, Role::ReferenceY]
        .into_iter()
        .filter_map(|role| of_field(MILLI, role))
        .collect();
    // Times distance and turn, as the wheels say them.
    let parts = [
        Reading::new(reference, (MILLI, 1.0)),
        Reading::new(sizes, (1.0 / MILLI, 1.0 / MILLI)),
        Reading::new(track, (1.0, MILLI)),
    ];
    let mut found = vec![Reading::new(Vec::new(), (1.0, 1.0))];
    for part in parts.iter().filter(|part| !part.corrections.is_empty()) {
        let both = |other: &Reading<Size>| {
            let corrections = [other.corrections.clone(), part.corrections.clone()].concat();
            let (far, around) = (other.does.0 * part.does.0, other.does.1 * part.does.1);
            Reading::new(corrections, (far, around))
        };
        found.extend(found.clone().iter().map(both));
    }
    let counts = wheels_of(dataset).any(|one| one.unit.dimension() == Dimension::Count);
    for times in [4.0, 0.25].into_iter().filter(|_| counts) {
        let ticks = of_constants(1.0 / times, &|name| name.contains("ticks_per_revolution"));
        let per_count = of_constants(times, &|name| name.ends_with("metres_per_count"));
        let corrections = if ticks.is_empty() { per_count } else { ticks };
        found.push(Reading::new(corrections, (1.0 / times, 1.0 / times)));
    }
    let is_speed = |one: &&Column| one.unit.dimension() == Dimension::Speed;
    let of = |one: &Column| Correction::exact(Fault::WrongUnit, &one.name, KMH);
    let speeds = wheels_of(dataset).filter(is_speed).map(of).collect();
    found.push(Reading::new(speeds, (1.0 / KMH, 1.0 / KMH)));
    let degrees = 1.0 / Unit::Degree.si();
    let turns = |one: &&Column| matches!(one.unit, Unit::Radian | Unit::RadianPerSecond);
    let of = |one: &Column| Correction::exact(Fault::DegreesForRadians, &one.name, degrees);
    let corrections: Vec<Correction> = wheels_of(dataset).filter(turns).map(of).collect();
    found.push(Reading::new(corrections, (1.0 / degrees, 1.0 / degrees)));
    // What cannot be wrong here, and what is wrong all over alike, is nothing.
    found.retain(|one| one.corrections.is_empty() == (one.does == (1.0, 1.0)));
    found
}
