//! What a finding must not depend on or claim: where somebody put the zero of an angle, a scale that a reference does not tell,
//! a limit that no reading reaches, noise of readings that are held.

use identification::dataset::{Axis, Column, Dataset, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

fn found(dataset: &Dataset) -> Finding {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

fn names(finding: &Finding) -> Vec<&str> {
    let mut names: Vec<&str> = finding.effects.iter().map(|one| one.name.as_str()).collect();
    names.sort_unstable();
    names
}

fn normals(seed: u64) -> impl FnMut() -> f64 {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    move || StandardNormal.sample(&mut random)
}

/// A record of what reads `reads` beside `truth`, every 20 ms.
fn record(kind: Kind, unit: Unit, truth: Vec<f64>, reads: Vec<f64>) -> Dataset {
    let [measured, reference] = match kind {
        Kind::Series => [Role::GyroRate, Role::ReferenceRate],
        _ => [Role::Measured, Role::Reference],
    };
    let rows = truth.len();
    let time = (0..rows).map(|row| 0.02 * row as f64).collect();
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("reads", measured, unit, reads),
        Column::new("truth", reference, unit, truth),
    ];
    Dataset::new("record", kind, columns, vec![0; rows])
}

/// A resolver on an axis that goes there and back, late, with cycles, and louder where it is fast; its zero and that of its
/// reference are turned by `shift`.
fn resolver(shift: f64) -> Dataset {
    let angle = |t: f64| 180.0 - 178.0 * (TAU * t / 19.0).cos();
    let mut normal = normals(11);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    for row in 0..4000 {
        let t = 0.02 * f64::from(row);
        let (now, seen) = (angle(t), angle(t - 0.034));
        let cycles =
            0.45 * (seen.to_radians() + 0.3).cos() + 0.48 * (2.0 * seen.to_radians()).sin();
        let fast = (TAU * t / 19.0).sin().abs();
        truth.push(now + shift);
        reads.push(seen + shift + cycles + (0.01 + 0.06 * fast) * normal());
    }
    record(Kind::Sensor, Unit::Degree, truth, reads)
}

/// What a scale factor takes up of a cycle is given back to it.
#[test]
fn where_the_zero_of_an_angle_is_changes_nothing() {
    for shift in [0.0, 90.0, -90.0, 180.0, -360.0] {
        let finding = found(&resolver(shift));
        assert_eq!(names(&finding), ["delay", "once_a_turn", "twice_a_turn"], "{shift}");
        assert!(finding.held_out.after < 0.06, "{shift}: {:?}", finding.held_out);
    }
}

/// An axis that moves once: what is late then may be a delay, or a clock that has gone wrong until then.
#[test]
fn of_a_delay_and_a_clock_that_explain_as_much_the_delay_is_told() {
    for loud in [0.0, 0.3] {
        let angle = |t: f64| 30.0 * ((t - 30.0) / 1.5).tanh();
        let mut normal = normals(12);
        let (mut truth, mut reads) = (Vec::new(), Vec::new());
        for row in 0..3000 {
            let t = 0.02 * f64::from(row);
            let speed = 1.0 - ((t - 30.0) / 1.5).tanh().powi(2);
            truth.push(angle(t));
            reads.push(angle(t - 0.05) + (0.3 + loud * speed) * normal());
        }
        let finding = found(&record(Kind::Sensor, Unit::Degree, truth, reads));
        let effect = &finding.effects[0];
        assert_eq!((&*effect.name, finding.effects.len()), ("delay", 1), "{:?}", finding.effects);
        let rivals: Vec<&str> = effect.rivals.iter().map(|one| one.name.as_str()).collect();
        assert!(rivals.contains(&"sample_clock"), "{loud}: {rivals:?}");
    }
}

/// A voltage standard, whose own meter is noisy, beside a meter that drifts.
#[test]
fn a_scale_that_the_reference_does_not_tell_is_not_fitted_and_it_is_said() {
    let mut normal = normals(13);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    let mut drift = 0.0;
    for _ in 0..3000 {
        drift = 0.999 * drift + 0.05 * normal();
        truth.push(0.3 * normal());
        reads.push(25.0 + drift + 0.2 * normal());
    }
    let data = record(Kind::Sensor, Unit::Volt, truth, reads);
    let found_here = identify(&data, None, &Options::default(), &mut |_, _| ()).unwrap();
    let finding = &found_here.finding;
    let scale = finding.base.iter().find(|one| one.name == "scale_factor").unwrap();
    assert_eq!((scale.value, scale.standard_error), (-1.0, None));
    let said = |what: &str| finding.notices.iter().any(|notice| notice.contains(what));
    assert!(said("`truth` does not tell the scale of `reads`"), "{:?}", finding.notices);
    // The noise of the reference is not in what is predicted.
    let error = predict(&data, &found_here.model).unwrap().rmse.after;
    assert!((error - finding.held_out.after).abs() < 0.2 * error, "{error} {:?}", finding.held_out);
    // One that shows nothing of what moves is a finding.
    let mut normal = normals(14);
    let truth: Vec<f64> = (0..3000).map(|row| 3.0 * (f64::from(row) / 40.0).sin()).collect();
    let reads = truth.iter().map(|_| 3.0 + 0.5 * normal()).collect();
    let finding = found(&record(Kind::Sensor, Unit::Volt, truth, reads));
    let scale = finding.base.iter().find(|one| one.name == "scale_factor").unwrap();
    assert!((scale.value + 1.0).abs() < 0.05, "{scale:?}");
}

/// A gyro beside a reference about an axis that it does not turn about: whatever it is a share of, it is no scale, and no limit
/// stands for one.
#[test]
fn a_scale_of_a_gyro_stays_within_its_range() {
    let mut normal = normals(18);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    for row in 0..4000 {
        let rate = 6.0 * (f64::from(row) / 25.0).sin();
        truth.push(rate);
        reads.push(-0.12 * rate + 2.0 * (f64::from(row) / 90.0).cos() + 0.3 * normal());
    }
    let finding = found(&record(Kind::Series, Unit::DegreePerSecond, truth, reads));
    let scale = finding.base.iter().find(|one| one.name == "scale_factor").unwrap();
    assert_eq!((scale.value, scale.standard_error), (-1.0, None));
    assert!(!names(&finding).contains(&"saturation"), "{:?}", finding.effects);
    assert!(finding.notices.iter().any(|said| said.contains("no gyro does that")));
}

/// What a gyro is compared with goes beyond one end of its range, and not beyond the other.
#[test]
fn an_end_of_the_range_that_no_reading_shows_is_not_told() {
    let mut normal = normals(15);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    for row in 0..4000 {
        let row = f64::from(row);
        let rate = -9.0 + 14.0 * (row / 31.0).sin() + 6.0 * (row / 83.0).cos();
        truth.push(rate);
        reads.push(f64::max(rate + 0.1 + 0.05 * normal(), -15.0));
    }
    let finding = found(&record(Kind::Series, Unit::DegreePerSecond, truth, reads));
    let clipped = finding.effects.iter().find(|one| one.name == "saturation").unwrap();
    let limits: Vec<&str> = clipped.parameters.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(limits, ["gain", "lower_limit"], "{:?}", clipped.parameters);
}

/// A gyro that is read four times as fast as it measures.
#[test]
fn readings_that_are_held_do_not_hide_their_noise() {
    let mut normal = normals(16);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    let mut held = 0.0;
    for row in 0..6000 {
        let t = 0.02 * f64::from(row);
        let rate = 30.0 * (t / 3.0).sin() + 12.0 * (t / 7.7).cos();
        if row % 4 == 0 {
            held = rate + 0.002 * rate * rate.abs() + 0.5 * normal();
        }
        truth.push(rate);
        reads.push(held);
    }
    let floor = found(&record(Kind::Series, Unit::DegreePerSecond, truth, reads)).noise_floor.value;
    assert!((0.3..1.0).contains(&floor), "{floor}");
}

/// The level of a test that each of three axes takes is a third of that of all.
#[test]
fn the_level_that_is_told_is_the_one_that_was_used() {
    let mut normal = normals(17);
    let (mut truth, mut reads) = (Vec::new(), Vec::new());
    for row in 0..1500 {
        let rate = 20.0 * (f64::from(row) / 60.0).sin();
        truth.push(rate);
        reads.push(rate + 0.2 * normal());
    }
    let mut data = record(Kind::Series, Unit::DegreePerSecond, truth, reads);
    data.columns[1].axis = Some(Axis::X);
    for (axis, name) in [(Axis::Y, "y"), (Axis::Z, "z")] {
        let values = data.columns[2].values.iter().map(|rate| rate + 0.2 * normal()).collect();
        let column = Column::new(name, Role::GyroRate, Unit::DegreePerSecond, values);
        data.columns.push(Column { axis: Some(axis), ..column });
    }
    let notices = found(&data).notices;
    let white = notices.iter().filter(|said| said.contains("is white at the level of 0.333 %"));
    assert_eq!(white.count(), 3, "{notices:?}");
}

/// A course over ground that is as wrong from one reading to the next as it wanders: no part of it is white noise of a reading.
#[test]
fn the_noise_of_a_heading_is_what_is_new_in_it() {
    let mut normal = normals(19);
    let (mut time, mut rates, mut course) = (Vec::new(), Vec::new(), Vec::new());
    let (mut heading, mut wander) = (0.0, 0.0);
    for row in 0..1500 {
        let t = 0.2 * f64::from(row);
        let rate = 0.2 * (t / 7.0).sin() + 0.1 * (t / 2.3).cos();
        let before = rates.last().copied().unwrap_or(rate);
        heading += 0.1 * (rate + before);
        wander += 0.003 * normal();
        time.push(t);
        rates.push(rate);
        course.push(heading + wander);
    }
    let columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        Column::new("yaw", Role::GyroRate, Unit::RadianPerSecond, rates),
        Column::new("course", Role::ReferenceHeading, Unit::Radian, course),
    ];
    let finding = found(&Dataset::new("car", Kind::Series, columns, vec![0; 1500]));
    let floor = finding.noise_floor.value;
    assert!((0.0015..0.006).contains(&floor), "{floor}");
    let said = finding.in_words();
    assert!(!said.iter().any(|one| one.contains("times the noise")), "{said:?}");
}
