//! Which plan is chosen for causes that one warm-up leaves in doubt.

use super::{Doubt, Experiment, Gain, cases, gains, menu, next};
use crate::dataset::{Column, Dataset, Kind, Role, Unit};
use crate::model::{Acts, Driver, Form, Shape, Wrap};
use crate::noise::{Layout, NoiseModel};
use crate::problem::Problem;
use crate::select::{BlockFit, Data, RivalFound, fit_terms};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

/// Table runs of one warm-up: 48 s each, for two hours, and their rates in deg/s.
const RUNS: usize = 150;
const NOISE_DEG: f64 = 0.01;

/// Turns both ways while the gyro warms from 22 to 40 degC; `rates` take turns.
fn warm_up(rates: &[f64]) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
    let mut values: [Vec<f64>; 7] = Default::default();
    let mut run_of_row = Vec::new();
    for run in 0..RUNS {
        for (turn, direction) in [-1.0, 1.0].into_iter().enumerate() {
            let time = 48.0 * run as f64 + 34.0 + 14.0 * turn as f64;
            let rate = rates[run % rates.len()];
            let noise: f64 = StandardNormal.sample(&mut random);
            let row = [
                time,
                direction,
                360.0 * direction + NOISE_DEG * noise,
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
        .map(|((name, role, unit), values)| Column { name: name.to_owned(), role, axis: None, unit, values })
        .collect();
    Dataset {
        name: "warm-up".to_owned(),
        kind: Kind::Turns,
        drive: None,
        constants: BTreeMap::new(),
        columns,
        run_of_row,
        run_labels: (0..RUNS).map(|run| run.to_string()).collect(),
        notices: Vec::new(),
    }
}

/// The experiment for `effect` of that size (coefficient, SI) against `rivals`, and what each plan brings.
fn experiment(
    dataset: &Dataset,
    effect: &Shape,
    size: f64,
    rivals: &[Shape],
) -> (Experiment, BTreeMap<&'static str, Vec<Gain>>) {
    let mut problem = Problem::new(dataset, None).unwrap();
    let columns = effect.observed(&problem.blocks[0], &problem.channels).unwrap();
    for (value, part) in problem.blocks[0].residual.iter_mut().zip(&columns[0]) {
        *value += size * part;
    }
    let block = &problem.blocks[0];
    let layout = Layout::new(block, &problem.channels);
    let data = Data { block, channels: &problem.channels, layout: &layout };
    let noise = NoiseModel::white(layout.runs());
    let shapes = [
        Shape::constant("bias", Acts::Bias),
        Shape::constant("scale_factor", Acts::Scale),
        effect.clone(),
    ];
    let mut base = fit_terms(data, &shapes, &noise, &[]);
    let mut found = base.pop().unwrap();
    found.strength = 20.0;
    found.rivals =
        rivals.iter().map(|shape| RivalFound { shape: shape.clone(), behind: 0.5 }).collect();
    let fit = BlockFit {
        base,
        effects: vec![found],
        noise,
        floor: NOISE_DEG.to_radians(),
        left: Vec::new(),
        left_out: Vec::new(),
    };
    let doubts = [Doubt { data, fit: &fit }];
    let cases = cases(&doubts);
    let each = menu(dataset.kind, &[])
        .iter()
        .filter_map(|plan| Some((plan.name, gains(dataset, &problem, &doubts, plan, &cases)?)))
        .collect();
    (next(dataset, &problem, &doubts).unwrap(), each)
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

#[test]
fn shupe_against_a_lag_takes_a_changing_room() {
    let (found, _) = experiment(&warm_up(&[30.0]), &shupe(), 2e-3, &[bias_lag()]);
    assert!(found.name.starts_with("ambient-"), "{found:?}");
    assert_eq!(found.separates, ["shupe", "bias_temperature_lag"]);
    assert!(found.expected_gain.contains("against"), "{}", found.expected_gain);
    let (found, _) = experiment(&warm_up(&[30.0]), &lag(), 3e-5, &[over_rate_of_temperature()]);
    assert!(found.name.starts_with("ambient-"), "{found:?}");
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
    assert!(["hot-restart", "ambient-steps", "ambient-sine-fast", "ambient-sine-slow"].contains(&found.name.as_str()), "{found:?}");
    // One warm-up says nothing between them, and another like it neither.
    assert!(each["hot-restart"].iter().all(|gain| gain.now < 1.0), "{each:?}");
    assert!(found.lambda > each["heading-stations"][0].then);
    assert!(found.by_rival.len() == 2);
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
