//! What a package states wrongly about its fields is set right before anything else: signs, units, axes, how and when a
//! reference reads.

use identification::dataset::{Axis, Column, Constant, Dataset, Drive, Kind, Role, Unit};
use identification::finding::{Effect, Finding};
use identification::identify::{Identified, Options, identify, predict};
use identification::model::Model;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

pub fn found(dataset: &Dataset) -> Identified {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap()
}

pub fn effect<'a>(finding: &'a Finding, name: &str) -> &'a Effect {
    finding.effects.iter().find(|effect| effect.name == name).unwrap_or_else(|| {
        panic!("no {name} in {:?}", finding.effects);
    })
}

const DT: f64 = 0.05;
const ROWS: usize = 300;

/// A robot whose `track` is 5 % more than the package says, with its reference `late` by that much, s.
pub fn robot(late: f64, slips: f64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(3);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let (runs, shift) = (10, (late / DT).round() as usize);
    let mut columns: [Vec<f64>; 6] = Default::default();
    for run in 0..runs {
        let mut poses = vec![(0.0_f64, 0.0_f64, draw())];
        let mut wheels = vec![(0.0, 0.0)];
        for row in 1..ROWS {
            let at = row as f64 * DT + 7.0 * run as f64;
            let (speed, rate) = (0.5 + 0.3 * (at / 1.7).sin(), 0.9 * (at / 1.1).cos());
            let (left, right) = ((speed - 0.2 * rate) * DT, (speed + 0.2 * rate) * DT);
            wheels.push((left, right));
            // Slips are heavy in their tails, and larger in motion.
            let mut slip = || 1.0 + slips * draw() / draw().abs().max(0.3);
            let (left, right) = (left * slip(), right * slip());
            let track = if slips > 0.0 { 0.4 } else { 0.42 };
            let (x, y, heading) = poses[row - 1];
            let turned = (right - left) / track;
            let (middle, way) = (heading + turned / 2.0, (left + right) / 2.0);
            poses.push((x + way * middle.cos(), y + way * middle.sin(), heading + turned));
        }
        for row in 0..ROWS {
            let (x, y, heading) = poses[row.saturating_sub(shift)];
            let values = [
                row as f64 * DT,
                wheels[row].0,
                wheels[row].1,
                x + 0.002 * draw(),
                y + 0.002 * draw(),
                heading + 0.003 * draw(),
            ];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("left", Role::WheelLeft, Unit::Metre),
        ("right", Role::WheelRight, Unit::Metre),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let track = Constant { value: 0.4, unit: Unit::Metre };
    let columns = named.into_iter().zip(columns);
    Dataset {
        drive: Some(Drive::Differential),
        constants: BTreeMap::from([("wheelbase".to_owned(), track)]),
        ..Dataset::new(
            "robot",
            Kind::Odometry,
            columns.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect(),
            (0..runs * ROWS).map(|row| row / ROWS).collect(),
        )
    }
}

pub fn change(dataset: &mut Dataset, name: &str, by: impl Fn(f64) -> f64) {
    let column = dataset.columns.iter_mut().find(|column| column.name == name).unwrap();
    column.values.iter_mut().for_each(|value| *value = by(*value));
}

#[test]
fn a_counter_and_a_heading_that_run_backwards_are_told_by_name() {
    let right = found(&robot(0.0, 0.0)).finding;
    assert_eq!(right.effects.len(), 1, "{:?}", right.effects);
    let mut wrong = robot(0.0, 0.0);
    change(&mut wrong, "left", |value| -value);
    change(&mut wrong, "heading", |value| -value);
    let identified = found(&wrong);
    let finding = &identified.finding;
    let reversed: Vec<&str> = finding
        .effects
        .iter()
        .filter(|effect| effect.name == "reversed_sign")
        .map(|effect| effect.drivers[0].as_str())
        .collect();
    assert_eq!(reversed.len(), 2, "{:?}", finding.effects);
    assert!(reversed.contains(&"left") && reversed.contains(&"heading"), "{reversed:?}");
    let track = effect(finding, "effective_track").parameters[0].value;
    assert!((track + 0.05 / 1.05).abs() < 0.003, "{track}");
    assert!(finding.held_out.after < 0.05 * finding.held_out.before, "{:?}", finding.held_out);
    // The model carries the corrections to other data.
    let model = Model::from_toml(&identified.model.to_toml()).unwrap();
    let told = predict(&wrong, &model).unwrap();
    assert!(told.rmse.after < 0.05 * told.rmse.before, "{:?}", told.rmse);
    assert!(found(&wrong).finding.in_words().contains(&"left has the wrong sign.".to_owned()));
}

#[test]
fn a_reference_that_comes_late_or_looks_askew_is_told_with_its_size() {
    let mut late = robot(0.15, 0.0);
    change(&mut late, "heading", |value| value + 0.06);
    let finding = found(&late).finding;
    let delay = &effect(&finding, "delay").parameters[0];
    assert!((delay.value + 0.15).abs() < 0.01, "{delay:?}");
    let offset = &effect(&finding, "reference_heading_offset").parameters[0];
    assert!((offset.value - 0.06_f64.to_degrees()).abs() < 0.3, "{offset:?}");
    effect(&finding, "effective_track");
    assert!(finding.held_out.after < 0.1 * finding.held_out.before, "{:?}", finding.held_out);
}

#[test]
fn a_reference_beside_the_middle_of_the_axle_is_told_with_its_side() {
    let clean = found(&robot(0.0, 0.0)).finding;
    for left in [0.12, -0.2] {
        let mut beside = robot(0.0, 0.0);
        let heading = beside.column(Role::ReferenceHeading).unwrap().values.clone();
        let mut at = |role: Role, by: fn(f64) -> f64| {
            let column = beside.columns.iter_mut().find(|column| column.role == role).unwrap();
            column.values.iter_mut().zip(&heading).for_each(|(value, h)| *value += left * by(*h));
        };
        at(Role::ReferenceX, |heading| -heading.sin());
        at(Role::ReferenceY, f64::cos);
        let identified = found(&beside);
        let told = &effect(&identified.finding, "reference_left_of_axle").parameters[0];
        assert!((told.value - left).abs() < 0.01, "{told:?}");
        let track = effect(&identified.finding, "effective_track").parameters[0].value;
        assert!((track + 0.05 / 1.05).abs() < 0.003, "{track}");
        let ratio = identified.finding.held_out.after / clean.held_out.after;
        assert!(ratio < 1.3, "{ratio}");
        let after = predict(&beside, &identified.model).unwrap().rmse.after;
        assert!(after < 2.0 * clean.held_out.after, "{after}");
    }
}

#[test]
fn a_robot_that_only_slips_has_no_effect() {
    let finding = found(&robot(0.0, 0.03)).finding;
    assert_eq!(finding.effects, [], "{:?}", finding.effects);
}

/// Three axes of a gyro against three of a reference that comes `late`, s.
pub fn shaken(late: f64, reads: impl Fn([f64; 3]) -> [f64; 3]) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(9);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let rate = |axis: usize, at: f64| {
        let beat = 1.0 + axis as f64 * 0.37;
        1.5 * (at * 2.9 * beat).sin() * (at * 0.31 * beat).cos()
    };
    let mut columns: [Vec<f64>; 7] = Default::default();
    for run in 0..4 {
        for row in 0..1500 {
            let at = row as f64 * 0.01;
            let of =
                |shift: f64| [0, 1, 2].map(|axis| rate(axis, at + 50.0 * f64::from(run) - shift));
            columns[0].push(at);
            for (axis, value) in reads(of(0.0)).into_iter().enumerate() {
                columns[1 + axis].push(value + 0.01 * draw());
            }
            for (axis, value) in of(late).into_iter().enumerate() {
                columns[4 + axis].push(value + 0.003 * draw());
            }
        }
    }
    let rad = Unit::RadianPerSecond;
    let named = [
        ("time", Role::Time, Unit::Second, None),
        ("gx", Role::GyroRate, rad, Some(Axis::X)),
        ("gy", Role::GyroRate, rad, Some(Axis::Y)),
        ("gz", Role::GyroRate, rad, Some(Axis::Z)),
        ("rx", Role::ReferenceRate, rad, Some(Axis::X)),
        ("ry", Role::ReferenceRate, rad, Some(Axis::Y)),
        ("rz", Role::ReferenceRate, rad, Some(Axis::Z)),
    ];
    let columns = named.into_iter().zip(columns).map(|((name, role, unit, axis), values)| Column {
        axis,
        ..Column::new(name, role, unit, values)
    });
    Dataset::new("shaken", Kind::Series, columns.collect(), (0..6000).map(|i| i / 1500).collect())
}

#[test]
fn axes_that_changed_places_are_told_with_their_unit_sign_and_delay() {
    let degrees = f64::to_degrees;
    let finding = found(&shaken(0.008, |[x, y, z]| [degrees(y), degrees(-x), degrees(z)])).finding;
    let wrong = finding.effects.iter().filter(|effect| effect.name == "wrong_axis");
    let wrong: Vec<_> = wrong.map(|effect| (effect.axis, effect.drivers[0].as_str())).collect();
    assert!(wrong.contains(&(Some(Axis::X), "ry")), "{:?}", finding.effects);
    assert!(wrong.contains(&(Some(Axis::Y), "rx")) && wrong.len() == 2, "{wrong:?}");
    assert_eq!(effect(&finding, "degrees_for_radians").axis, None);
    assert_eq!(effect(&finding, "reversed_sign").axis, Some(Axis::Y));
    let delays: Vec<f64> = finding
        .effects
        .iter()
        .filter(|effect| effect.name == "delay")
        .map(|effect| effect.parameters[0].value)
        .collect();
    assert_eq!(delays.len(), 3, "{:?}", finding.effects);
    // Also of the axis that is reversed.
    assert!(delays.iter().all(|delay| (delay + 0.008).abs() < 5e-4), "{delays:?}");
    let errors = std::iter::once(&finding.held_out).chain(&finding.held_out_also);
    assert!(errors.clone().all(|error| error.after < 0.012), "{:?}", errors.collect::<Vec<_>>());
}

/// A reference that was put on the wrong way round, and not quite.
#[test]
fn a_reference_is_mounted_once() {
    let mut wrong = robot(0.0, 0.0);
    change(&mut wrong, "heading", |value| value + std::f64::consts::PI + 0.03);
    let identified = found(&wrong);
    let told: Vec<&Effect> = identified
        .finding
        .effects
        .iter()
        .filter(|effect| effect.name == "reference_heading_offset")
        .collect();
    assert_eq!(told.len(), 1, "{told:?}");
    let offset = &told[0].parameters[0];
    let degrees = offset.value.rem_euclid(360.0);
    assert!((degrees - 180.0 - 0.03_f64.to_degrees()).abs() < 0.3, "{offset:?}");
    assert!(offset.standard_error.is_some());
}
