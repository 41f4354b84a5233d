//! A curve that was fitted over some range of its driver is held beyond that range, and not extrapolated.

use crate::recorded::{Recorded, recorded};
use identification::dataset::{Dataset, Role};
use identification::identify::{Options, identify, predict};
use identification::model::{Form, Model};

/// deg/s
const SIGMA: f64 = 0.02;
/// deg/s/K^2
const CURVE: f64 = 4e-3;
/// The temperatures of the recording, and wider ones, degC.
const SEEN: [f64; 2] = [19.0, 31.0];
const WIDE: [f64; 2] = [18.0, 32.0];

/// A gyro whose bias follows the square of the temperature in this range (degC), and is constant beyond.
fn gyro(recorded: &Recorded, seed: u64, [low, high]: [f64; 2]) -> Dataset {
    let white = recorded.white(seed);
    let bias = |row: usize| CURVE * (recorded.temperature[row].clamp(low, high) - 25.0).powi(2);
    let error: Vec<f64> = (0..white.len()).map(|row| bias(row) + SIGMA * white[row]).collect();
    recorded.series(&error)
}

fn model(dataset: &Dataset) -> Model {
    identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap().model
}

#[test]
fn a_curve_is_held_beyond_what_was_seen() {
    let recorded = recorded(4, 900, 1.0);
    let model = model(&gyro(&recorded, 1, SEEN));
    let curve = model.terms.iter().find(|term| term.form == Form::Quadratic).unwrap();
    let number = |name: &str| curve.parameter(name).map(|one| (one.value.round(), &*one.unit));
    assert_eq!(
        [number("seen_from"), number("seen_to")],
        [Some((19.0, "Cel")), Some((31.0, "Cel"))]
    );
    // The same gyro in a hot room.
    let mut hot = recorded;
    hot.temperature.iter_mut().for_each(|value| *value += 40.0);
    let found =
        predict(&gyro(&hot, 2, SEEN), &Model::from_toml(&model.to_toml()).unwrap()).unwrap();
    assert!(found.rmse.after < 1.2 * SIGMA, "{:?}", found.rmse);
}

#[test]
fn other_data_may_go_beyond_what_a_given_model_saw() {
    let mut wide = recorded(4, 900, 1.0);
    let narrow = model(&gyro(&wide, 1, WIDE));
    wide.temperature.iter_mut().for_each(|value| *value = 25.0 + 1.15 * (*value - 25.0));
    let set = gyro(&wide, 2, WIDE);
    let again = identify(&set, Some(&narrow), &Options::default(), &mut |_, _| ()).unwrap();
    let curve = again.model.terms.iter().find(|term| term.form == Form::Quadratic).unwrap();
    assert_eq!(curve.parameter("seen_to").map(|one| one.value.round()), Some(32.0));
    assert!(set.column(Role::Temperature).is_some());
    assert_eq!(again.finding.effects.len(), 0, "{:?}", again.finding.effects);
}
