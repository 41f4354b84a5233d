//! Which plan is chosen for causes that one warm-up leaves in doubt.

use super::step::{BASE, Programme, RATE, SIDE, SPEED, Step, laps};
use super::surroundings::Thermal;
use super::{Doubt, Experiment, Gain, cases, gains, menu, next, planned, timeline};
use crate::dataset::{Column, Dataset, Kind, Role, Unit};
use crate::fit::{Data, RivalFound, fit_terms};
use crate::model::{Acts, Driver, Form, Shape, Wrap};
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Known, Problem};
use crate::select::BlockFit;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

/// Table runs of one warm-up: 48 s each, for two hours, and their rates in deg/s.
const RUNS: usize = 150;
const NOISE_DEG: f64 = 0.01;

/// Turns both ways while the gyro warms from 22 to 40 degC; `rates` alternate.
fn warm_up(rates: &[f64]) -> Dataset {
    let mut values: [Vec<f64>; 7] = Default::default();
    let mut run_of_row = Vec::new();
    for run in 0..RUNS {
        for (turn, direction) in [-1.0, 1.0].into_iter().enumerate() {
            let time = 48.0 * run as f64 + 34.0 + 14.0 * turn as f64;
            let rate = rates[run % rates.len()];
            let row = [
                time,
                direction,
                360.0 * direction,
                360.0 * direction,
                40.0 - 18.0 * (-time / 2100.0_f64).exp(),
                rate * direction,
                360.0 / rate + rate / 15.0,
            ];
            for (column, value) in values.iter_mut().zip(row) {
                column.push(value);
            }
            run_of_row.push(run);
        }
    }
    let fields = [
        ("time", Role::Time, Unit::Second),
        ("direction", Role::Direction, Unit::One),
        ("gyro_angle", Role::GyroAngle, Unit::Degree),
        ("reference_angle", Role::ReferenceAngle, Unit::Degree),
        ("temperature", Role::Temperature, Unit::Celsius),
        ("table_rate", Role::TableRate, Unit::DegreePerSecond),
        ("duration", Role::Duration, Unit::Second),
    ];
    let columns = fields
        .into_iter()
        .zip(values)
        .map(|((name, role, unit), values)| Column::new(name, role, unit, values))
        .collect();
    Dataset::new("warm-up", Kind::Turns, columns, run_of_row)
}

/// The experiment for `effect` of that size (coefficient, SI) against `rivals`, and each plan's gains.
fn experiment(
    dataset: &Dataset,
    effect: &Shape,
    size: f64,
    rivals: &[Shape],
) -> (Experiment, BTreeMap<&'static str, Vec<Gain>>) {
    let mut problem = Problem::new(dataset, Known::default()).unwrap();
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(6);
    let columns = effect.observed(&problem.blocks[0], &problem.channels).unwrap();
    for (value, part) in problem.blocks[0].residual.iter_mut().zip(&columns[0]) {
        let noise: f64 = StandardNormal.sample(&mut random);
        *value += size * part + (NOISE_DEG * noise).to_radians();
    }
    let block = &problem.blocks[0];
    let layout = Layout::new(block, &problem.channels);
    let data = Data::new(block, &problem.channels, &layout);
    let noise = NoiseModel::white(layout.runs());
    let mut shapes: Vec<Shape> =
        block.constants.iter().map(|known| Shape::constant(known.name, known.acts)).collect();
    shapes.push(effect.clone());
    let mut base = fit_terms(data, &shapes, &noise);
    let mut found = base.pop().unwrap();
    found.strength = 20.0;
    found.rivals =
        rivals.iter().map(|shape| RivalFound { shape: shape.clone(), behind: 0.5 }).collect();
    let fit = BlockFit {
        path: Vec::new(),
        chosen: 0,
        nested: Vec::new(),
        goes: None,
        base,
        applied: Vec::new(),
        effects: vec![found],
        noise,
        floor: NOISE_DEG.to_radians(),
        scale: NOISE_DEG.to_radians(),
        left: Vec::new(),
    };
    let doubts = [Doubt { data, fit: &fit }];
    let cases = cases(&doubts);
    let each = menu(dataset.kind, &[])
        .iter()
        .filter_map(|plan| Some((plan.name, gains(dataset, &problem, &doubts, plan, &cases)?)))
        .collect();
    (next(dataset, &problem, &doubts, &cases).unwrap(), each)
}

fn shape(name: &str, acts: Acts, wrap: Wrap, field: &str, form: Form) -> Shape {
    Shape::new(name, acts, Driver::new(wrap, field), form)
}

fn lag() -> Shape {
    shape("coil_temperature_lag", Acts::Scale, Wrap::LagOf, "temperature", Form::Linear)
        .with("origin", 35.0)
        .with("time_constant", 300.0)
}

fn over_rate_of_temperature() -> Shape {
    shape("scale_over_rate_of_temperature", Acts::Scale, Wrap::RateOf, "temperature", Form::Linear)
}

fn shupe() -> Shape {
    shape("shupe", Acts::Bias, Wrap::RateOf, "temperature", Form::Linear)
}

fn bias_lag() -> Shape {
    shape("bias_temperature_lag", Acts::Bias, Wrap::LagOf, "temperature", Form::Linear)
        .with("origin", 35.0)
        .with("time_constant", 300.0)
}

fn changes_the_room(found: &Experiment) -> bool {
    found.plan_toml.contains("gyro.ambient_celsius")
}

#[test]
fn shupe_against_a_lag_takes_a_changing_room() {
    let (found, _) = experiment(&warm_up(&[30.0]), &shupe(), 2e-3, &[bias_lag()]);
    assert!(changes_the_room(&found), "{found:?}");
    assert_eq!(found.separates, ["shupe", "bias_temperature_lag"]);
    assert!(found.expected_gain.contains("against"), "{}", found.expected_gain);
    let (found, _) = experiment(&warm_up(&[30.0]), &lag(), 3e-5, &[over_rate_of_temperature()]);
    assert!(changes_the_room(&found), "{found:?}");
}

#[test]
fn powers_of_the_rate_take_a_ladder() {
    let line = shape("scale_over_rate", Acts::Scale, Wrap::Abs, "table_rate", Form::Linear);
    let square =
        shape("scale_over_rate_quadratic", Acts::Scale, Wrap::Plain, "table_rate", Form::Quadratic);
    let (found, each) = experiment(&warm_up(&[25.0, 35.0]), &line, 1e-3, &[square]);
    assert!(found.name.contains("ladder"), "{found:?}");
    assert!(each["hours-apart"][0].then < each["rate-ladder"][0].then);
}

#[test]
fn a_warm_up_against_temperature_takes_a_restart_or_a_changing_room() {
    let warm_up_term = shape("warm_up", Acts::Bias, Wrap::Plain, "time", Form::Exponential)
        .with("time_constant", 2100.0);
    let over_temperature =
        shape("bias_over_temperature", Acts::Bias, Wrap::Plain, "temperature", Form::Linear)
            .with("origin", 35.0);
    let rivals = [over_temperature, shupe()];
    let (found, each) = experiment(&warm_up(&[30.0]), &warm_up_term, 2e-5, &rivals);
    assert!(found.name == "hot-restart" || changes_the_room(&found), "{found:?}");
    // One warm-up does not separate them, and a second one like it does not either.
    assert!(each["hot-restart"].iter().all(|gain| gain.now < 1.0), "{each:?}");
    let chosen = &each[&*found.name];
    assert!(chosen.len() == 2);
    assert!(chosen.iter().all(|gain| gain.then > each["heading-stations"][0].then));
}

#[test]
fn larger_effects_are_farther_apart() {
    let data = warm_up(&[30.0]);
    let lambdas: Vec<f64> = [5e-4, 1e-3, 2e-3, 4e-3]
        .into_iter()
        .map(|size| experiment(&data, &shupe(), size, &[bias_lag()]).1["ambient-sine-slow"][0].then)
        .collect();
    assert!(lambdas.windows(2).all(|pair| pair[0] < pair[1]), "{lambdas:?}");
}

#[test]
fn more_rows_never_bring_causes_nearer() {
    let (_, each) = experiment(&warm_up(&[30.0]), &shupe(), 1e-3, &[bias_lag()]);
    for (plan, gains) in each {
        assert!(gains[0].then >= gains[0].now - 1e-6, "{plan}: {gains:?}");
        assert!((0.0..=1.0).contains(&gains[0].probability), "{plan}: {gains:?}");
    }
}

/// Data of a robot that drives `steps` from a cold start, in `fields`.
fn driven(kind: Kind, fields: &[(&str, Role, Unit)], steps: Vec<Step>) -> Dataset {
    let mut template = warm_up(&[30.0]);
    template.kind = kind;
    let wheelbase = crate::dataset::Constant { value: 0.3, unit: Unit::Metre };
    template.constants.insert("wheelbase".to_owned(), wheelbase);
    template.columns = fields
        .iter()
        .map(|&(name, role, unit)| {
            Column::new(name, role, unit, vec![0.0; template.run_of_row.len()])
        })
        .collect();
    let thermal = Thermal::of(&template);
    let programme =
        Programme { name: "", title: "", reason: "", devices: BASE, warm: false, steps };
    let phases = timeline::phases(&programme, thermal);
    let celsius = |phase: &timeline::Phase, time: f64| {
        thermal.after(phase.celsius, phase.ambient, time - phase.start)
    };
    planned::planned(&template, 1.0, None, &phases, celsius).unwrap().dataset
}

#[test]
fn what_only_forward_motion_cannot_tell_takes_driving_back() {
    let fields = [
        ("t", Role::Time, Unit::Second),
        ("way", Role::DriveDistance, Unit::MetrePerSecond),
        ("steer", Role::SteerAngle, Unit::DegreePerSecond),
        ("x", Role::ReferenceX, Unit::Metre),
        ("y", Role::ReferenceY, Unit::Metre),
        ("psi", Role::ReferenceHeading, Unit::Degree),
    ];
    let data = driven(Kind::Odometry, &fields, vec![Step::again(5, laps(SIDE, SPEED, RATE))]);
    let leakage =
        shape("drive_to_steer_leakage", Acts::Curvature, Wrap::Sign, "speed", Form::Linear);
    let wheels = Shape::constant("unequal_wheels", Acts::Curvature);
    let (found, each) = experiment(&data, &leakage, 2e-3, &[wheels]);
    assert!(["speed-ladder", "straights-at-headings"].contains(&found.name.as_str()), "{found:?}");
    assert!(each["laps-of-two-sizes"][0].then < 0.1 * each[&*found.name][0].then);
}

#[test]
fn laps_from_a_cold_start_take_a_restart_or_other_rooms() {
    let fields = [
        ("time", Role::Time, Unit::Second),
        ("direction", Role::Direction, Unit::One),
        ("gyro", Role::GyroAngle, Unit::Degree),
        ("temperature", Role::Temperature, Unit::Celsius),
        ("duration", Role::Duration, Unit::Second),
    ];
    let data = driven(Kind::Laps, &fields, vec![Step::again(40, laps(SIDE, SPEED, RATE))]);
    let warm_up_term = shape("warm_up", Acts::Bias, Wrap::Plain, "time", Form::Exponential)
        .with("time_constant", 2100.0);
    let over_temperature =
        shape("bias_over_temperature", Acts::Bias, Wrap::Plain, "temperature", Form::Linear)
            .with("origin", 30.0);
    let (found, each) = experiment(&data, &warm_up_term, 1e-5, &[over_temperature]);
    assert!(
        ["laps-after-hot-restart", "laps-in-three-rooms"].contains(&found.name.as_str()),
        "{found:?}"
    );
    assert!(!each.contains_key("straights-at-headings"), "no lap, no row");
}
