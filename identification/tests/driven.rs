//! Driven paths: the cause that matters comes first and no richer model is reported, whatever else the robot does.

use identification::dataset::{Column, Constant, Dataset, Drive, Kind, Role, Unit};
use identification::finding::Finding;
use identification::identify::{Options, identify};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

const DT: f64 = 0.05;

/// A robot: its actual motion at a commanded speed and rate, and the distance of its reference ahead of the axle.
struct Robot {
    turn: fn(f64) -> f64,
    ahead: f64,
    /// Slip: share of the turn, redrawn every half second.
    slip: f64,
}

/// Runs of `rows` samples with the wheels' speeds and the pose.
fn drive(robot: &Robot, runs: usize, rows: usize, seed: u64) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: [Vec<f64>; 6] = Default::default();
    let mut run_of_row = Vec::new();
    for run in 0..runs {
        let (mut x, mut y, mut heading) = (0.0, 0.0, draw());
        let (speed, rate) = (0.5 + 0.2 * draw(), 0.8 * draw());
        let mut slip = 0.0;
        for row in 0..rows {
            let rate = rate + 0.3 * (row as f64 * DT / 1.3).sin();
            if row % 10 == 0 {
                slip = robot.slip * draw();
            }
            if row > 0 {
                let turned = (robot.turn)(rate) * (1.0 + slip) * DT;
                x += speed * DT * (heading + turned / 2.0).cos();
                y += speed * DT * (heading + turned / 2.0).sin();
                heading += turned;
            }
            let values = [
                row as f64 * DT,
                speed - 0.5 * rate,
                speed + 0.5 * rate,
                x + robot.ahead * heading.cos() + 0.002 * draw(),
                y + robot.ahead * heading.sin() + 0.002 * draw(),
                heading + 0.002 * draw(),
            ];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
            run_of_row.push(run);
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("left", Role::WheelLeft, Unit::MetrePerSecond),
        ("right", Role::WheelRight, Unit::MetrePerSecond),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let columns = named
        .into_iter()
        .zip(columns)
        .map(|((name, role, unit), values)| Column::new(name, role, unit, values));
    Dataset {
        name: "robot".to_owned(),
        kind: Kind::Odometry,
        drive: Some(Drive::Skid),
        constants: BTreeMap::from([
            ("wheelbase".to_owned(), Constant { value: 1.0, unit: Unit::Metre }),
            ("mean_speed".to_owned(), Constant { value: 1.0, unit: Unit::One }),
        ]),
        columns: columns.collect(),
        run_labels: (0..runs).map(|run| run.to_string()).collect(),
        run_of_row,
        notices: Vec::new(),
    }
}

fn found(dataset: &Dataset) -> Finding {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap().finding
}

/// No metric of the chosen model is worse than that of a simpler one by more than its standard error.
fn assert_sound(finding: &Finding) {
    let chosen = finding.path.iter().position(|model| model.chosen).unwrap();
    for simple in &finding.path[..chosen] {
        for (name, error) in &finding.path[chosen].held_out {
            let other = &simple.held_out[name];
            assert!(error.value <= other.value + error.standard_error.max(other.standard_error));
        }
    }
    for parameter in finding.effects.iter().flat_map(|effect| &effect.parameters) {
        if let Some([low, high]) = parameter.range {
            assert!((low..=high).contains(&parameter.value), "{parameter:?}");
        }
    }
}

#[test]
fn a_robot_that_skids_has_an_effective_track_and_little_else() {
    let robot = Robot { turn: |rate| rate / 1.8, ahead: 0.0, slip: 0.3 };
    let finding = found(&drive(&robot, 60, 60, 7));
    let first = &finding.effects[0];
    assert_eq!(first.name, "effective_track");
    // 1 / 1.8 - 1.
    assert!((first.parameters[0].value + 0.444).abs() < 0.03, "{:?}", first.parameters[0]);
    assert!(finding.effects.len() <= 3, "{:?}", finding.effects);
    assert_sound(&finding);
    let said = finding.in_words();
    assert!(said[0].contains("times as far apart"), "{said:?}");
}

#[test]
fn a_reference_that_sits_ahead_of_the_axle_is_found_also_in_one_long_run() {
    let robot = Robot { turn: |rate| rate, ahead: 0.35, slip: 0.0 };
    let finding = found(&drive(&robot, 2, 1200, 3));
    let first = &finding.effects[0];
    assert_eq!(first.name, "reference_ahead_of_axle", "{:?}", finding.effects);
    assert!((first.parameters[0].value - 0.35).abs() < 0.02, "{:?}", first.parameters[0]);
    assert!(finding.notices.iter().any(|notice| notice.contains("windows")));
    assert_sound(&finding);
}

/// A synchro drive that drifts by `drift` rad/m times the cosine of its wheels' angle to the base.
fn synchro(drift: f64, runs: usize, rows: usize) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(11);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: [Vec<f64>; 6] = Default::default();
    for run in 0..runs {
        // The base stands in any direction when a run begins.
        let (mut x, mut y, mut heading, mut steered) = (0.0, 0.0, 3.0 * draw(), 0.0);
        for row in 0..rows {
            let way = if row > 0 { 0.3 * DT } else { 0.0 };
            let turned =
                if row > 0 { 0.5 * (row as f64 / 30.0 + run as f64).cos() * DT } else { 0.0 };
            steered += turned;
            let drifts = drift * way * (steered - turned / 2.0).cos();
            let middle = heading + (turned + drifts) / 2.0;
            x += way * middle.cos();
            y += way * middle.sin();
            heading += turned + drifts;
            let pose = [x, y, heading].map(|value| value + 0.002 * draw());
            let values = [row as f64 * DT, way, turned, pose[0], pose[1], pose[2]];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let named = [
        ("time", Role::Time, Unit::Second),
        ("way", Role::DriveDistance, Unit::Metre),
        ("steer", Role::SteerAngle, Unit::Radian),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let named = named.into_iter().zip(columns);
    Dataset {
        name: "synchro".to_owned(),
        kind: Kind::Odometry,
        drive: Some(Drive::Synchro),
        constants: BTreeMap::new(),
        columns: named.map(|((name, role, unit), v)| Column::new(name, role, unit, v)).collect(),
        run_labels: (0..runs).map(|run| run.to_string()).collect(),
        run_of_row: (0..runs * rows).map(|row| row / rows).collect(),
        notices: Vec::new(),
    }
}

#[test]
fn a_wheel_of_a_synchro_drive_errs_with_its_angle_to_the_base() {
    let finding = found(&synchro(0.05, 12, 300));
    let first = &finding.effects[0];
    assert_eq!(
        (first.term.as_str(), first.drivers.as_slice()),
        ("curvature", &["harmonic_1(steer)".to_owned()][..]),
        "{:?}",
        finding.effects
    );
    assert_sound(&finding);
}

#[test]
fn counts_of_a_synchro_drive_are_as_good_as_metres_and_degrees() {
    let mut counted = synchro(0.05, 12, 300);
    let constants =
        [("metres_per_count", Unit::Metre, 1e-5), ("steer_counts_per_revolution", Unit::One, 1e6)];
    for (name, unit, value) in constants {
        counted.constants.insert(name.to_owned(), Constant { value, unit });
    }
    for (role, of_one) in
        [(Role::DriveDistance, 1e5), (Role::SteerAngle, 1e6 / std::f64::consts::TAU)]
    {
        assert!(role.dimensions().contains(&Unit::Count.dimension()));
        let column = counted.columns.iter_mut().find(|column| column.role == role).unwrap();
        column.unit = Unit::Count;
        column.values.iter_mut().for_each(|value| *value = (*value * of_one).round());
    }
    let (metres, counts) = (found(&synchro(0.05, 12, 300)), found(&counted));
    let names = |finding: &Finding| -> Vec<String> {
        finding.effects.iter().map(|effect| effect.name.clone()).collect()
    };
    assert_eq!(names(&counts), names(&metres));
    let ratio = counts.held_out.after / metres.held_out.after;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    counted.drive = Some(Drive::Tricycle);
    counted.constants.insert("wheelbase".to_owned(), Constant { value: 1.0, unit: Unit::Metre });
    let refused = identify(&counted, None, &Options::default(), &mut |_, _| {}).err().unwrap();
    assert_eq!(
        refused.to_string(),
        "`steer` is in count: the steering angle of a tricycle must be an angle"
    );
}

/// A front-driven tricycle whose steering angle is `scale` times the reported one, plus `offset`.
fn tricycle(scale: f64, offset: f64, runs: usize, rows: usize) -> Dataset {
    const BASE: f64 = 1.2;
    /// The wheel is steered also between rows.
    const PARTS: usize = 20;
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut columns: [Vec<f64>; 6] = Default::default();
    for run in 0..runs {
        let (mut x, mut y, mut heading, mut way) = (0.0, 0.0, draw(), 0.0);
        let phase = 2.0 * run as f64;
        let told = |row: f64| 0.5 * (row / 25.0 + phase).sin();
        for row in 0..rows {
            if row > 0 {
                way += 0.5 * DT;
                for part in 0..PARTS {
                    let at = row as f64 - 1.0 + (part as f64 + 0.5) / PARTS as f64;
                    let angle = scale * told(at) + offset;
                    let driven = 0.5 * DT / PARTS as f64;
                    let turned = driven * angle.sin() / BASE;
                    x += driven * angle.cos() * (heading + turned / 2.0).cos();
                    y += driven * angle.cos() * (heading + turned / 2.0).sin();
                    heading += turned;
                }
            }
            let values = [
                row as f64 * DT,
                way,
                told(row as f64),
                x + 0.001 * draw(),
                y + 0.001 * draw(),
                heading + 0.001 * draw(),
            ];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let template = drive(&Robot { turn: |rate| rate, ahead: 0.0, slip: 0.0 }, runs, rows, 1);
    let roles = [
        ("time", Role::Time, Unit::Second),
        ("way", Role::DriveDistance, Unit::Metre),
        ("steer", Role::SteerAngle, Unit::Radian),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("heading", Role::ReferenceHeading, Unit::Radian),
    ];
    let columns = roles
        .into_iter()
        .zip(columns)
        .map(|((name, role, unit), values)| Column::new(name, role, unit, values));
    Dataset {
        drive: Some(Drive::Tricycle),
        constants: BTreeMap::from([(
            "wheelbase".to_owned(),
            Constant { value: BASE, unit: Unit::Metre },
        )]),
        columns: columns.collect(),
        ..template
    }
}

#[test]
fn a_tricycle_whose_steering_is_scaled_and_offset_is_set_right() {
    let exact = found(&tricycle(1.0, 0.0, 8, 400));
    assert!(exact.held_out.before < 0.02, "kinematics alone: {:?}", exact.held_out);
    let finding = found(&tricycle(0.8, 0.05, 8, 400));
    assert!(finding.held_out.after < 0.2 * finding.held_out.before, "{:?}", finding.held_out);
    assert_eq!(exact.effects, [], "{:?}", exact.effects);
    let value = |name: &str| {
        let effect = finding.effects.iter().find(|effect| effect.name == name).unwrap();
        effect.parameters[0].value
    };
    assert!((value("steer_scale") - 0.8).abs() < 0.01, "{:?}", finding.effects);
    assert!((value("steer_offset") - 0.05_f64.to_degrees()).abs() < 0.2, "{:?}", finding.effects);
    assert!(finding.held_out.after < 0.02, "{:?}", finding.held_out);
    assert_sound(&finding);
}

/// Five times too little is neither degrees nor millimetres, though both together would nearly make it up.
#[test]
fn a_steering_angle_that_is_far_too_small_is_no_unit() {
    let mut small = tricycle(1.0, 0.0, 8, 400);
    let steer = small.columns.iter_mut().find(|column| column.name == "steer").unwrap();
    steer.values.iter_mut().for_each(|value| *value /= 5.6);
    let finding = found(&small);
    let names: Vec<&str> = finding.effects.iter().map(|effect| effect.name.as_str()).collect();
    let unit = |name: &&str| name.ends_with("_unit") || name.ends_with("for_radians");
    assert!(names[0] == "steer_scale" && !names.iter().any(unit), "{:?}", finding.effects);
    assert!((finding.effects[0].parameters[0].value - 5.6).abs() < 0.06);
}

/// Without ends of stretches, its positions counted for nothing.
#[test]
fn one_long_run_is_judged_by_its_positions_also_where_the_reference_is_sparse() {
    let robot = Robot { turn: |rate| rate, ahead: 0.35, slip: 0.0 };
    let mut data = drive(&robot, 1, 1200, 3);
    let is_reference = |column: &&mut Column| column.role.is_reference();
    for column in data.columns.iter_mut().filter(is_reference) {
        let rows = column.values.iter_mut().enumerate();
        rows.filter(|(row, _)| row % 5 > 0).for_each(|(_, value)| *value = f64::NAN);
    }
    let finding = found(&data);
    assert_eq!(finding.effects[0].name, "reference_ahead_of_axle", "{:?}", finding.effects);
    let judged: Vec<&String> = finding.path[0].held_out.keys().collect();
    assert_eq!(judged, ["final_heading", "final_position"]);
    assert_sound(&finding);
}
