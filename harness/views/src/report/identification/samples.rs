//! Findings and their diagnostics, for tests.

use identification::dataset::Kind;
use identification::finding::{
    Effect, Figure, Finding, HeldOut, Left, NextExperiment, Parameter, PathError, PathModel, Rival,
    SCHEMA, Verdict,
};
use identification::model::{Acts, Driver, Form, Model, Term};
use identification::outcome::{BlockDiagnostics, Diagnostics, EffectCurve, RunError, Series};
use std::collections::BTreeMap;

fn parameter(name: &str, value: f64, unit: &str) -> Parameter {
    Parameter {
        name: name.into(),
        value,
        standard_error: Some(value / 10.0),
        unit: unit.into(),
        range: None,
    }
}

pub(super) fn effect(name: &str, drivers: &[&str]) -> Effect {
    Effect {
        name: name.into(),
        known: true,
        term: "bias".into(),
        axis: None,
        drivers: drivers.iter().map(ToString::to_string).collect(),
        form: "linear".into(),
        knots: Vec::new(),
        knots_2: Vec::new(),
        parameters: vec![parameter("h", 0.01, "deg/s/(K/s)")],
        p_value: 1e-9,
        held_out_before: 0.21,
        held_out_after: 0.06,
        rivals: Vec::new(),
    }
}

/// Two models, the second of which is chosen.
fn path() -> Vec<PathModel> {
    let model = |effects: &[&str], value, chosen| {
        let error = PathError { value, standard_error: value / 10.0, unit: "deg".into() };
        PathModel {
            effects: effects.iter().map(ToString::to_string).collect(),
            held_out: BTreeMap::from([("gyro_angle".to_owned(), error)]),
            chosen,
        }
    };
    vec![model(&[], 0.21, false), model(&["shupe"], 0.06, true)]
}

/// A finding with all its parts.
pub(super) fn finding() -> Finding {
    let rival = Rival {
        name: "bias_over_temperature".into(),
        term: "bias".into(),
        drivers: vec!["temperature".into()],
        probability: 0.2,
        separated_by: Some("hot-restart.toml".into()),
    };
    Finding {
        schema: SCHEMA,
        dataset: "bench".into(),
        kind: Kind::Turns,
        drive: None,
        rows: 300,
        runs: 30,
        seed: 1,
        verdict: Verdict::StructureLeft,
        noise_floor: Figure { value: 0.05, unit: "deg".into() },
        held_out: HeldOut {
            metric: "rmse".into(),
            quantity: None,
            unit: "deg".into(),
            before: 0.21,
            after: 0.06,
            ci95: [0.055, 0.066],
            folds: 5,
        },
        held_out_also: Vec::new(),
        base: vec![parameter("scale_factor", 0.001, "1")],
        effects: vec![Effect { rivals: vec![rival], ..effect("shupe", &["rate_of(temperature)"]) }],
        path: path(),
        left: vec![Left {
            drivers: vec!["trend(time)".into()],
            shape: "bias_ageing".into(),
            share_of_residual_variance: 0.1,
        }],
        compensation: None,
        compensation_also: Vec::new(),
        next_experiment: Some(NextExperiment {
            plan: "next-experiment.toml".into(),
            separates: vec!["shupe".into(), "bias_over_temperature".into()],
            expected_gain: "decided in 9 of 10 cases".into(),
        }),
        set_aside: Vec::new(),
        notices: vec!["`V` is constant".into()],
    }
}

pub(super) fn model() -> Model {
    let term = Term {
        name: "shupe".into(),
        known: true,
        term: Acts::Bias,
        axis: None,
        quantity: None,
        drivers: Driver::parse("rate_of(temperature)").into_iter().collect(),
        form: Form::Linear,
        knots: Vec::new(),
        knots_2: Vec::new(),
        parameters: vec![parameter("h", 0.01, "deg/s/(K/s)")],
    };
    let scale = Term {
        name: "scale_factor".into(),
        term: Acts::Scale,
        drivers: Vec::new(),
        form: Form::Constant,
        parameters: vec![parameter("value", 0.001, "1")],
        ..term.clone()
    };
    let given = Term { parameters: vec![parameter("value", 0.002, "1")], ..scale.clone() };
    Model {
        schema: SCHEMA,
        kind: Kind::Turns,
        dataset: Some("bench".into()),
        fields: BTreeMap::new(),
        counts_per_rad_per_s: None,
        closing_lever_m: None,
        corrections: Vec::new(),
        compensation: None,
        compensation_also: Vec::new(),
        terms: vec![scale, term],
        plain: vec![given],
    }
}

/// Returns a number between -1 and 1, without a pattern that a plot of this size shows.
pub(super) fn noise(index: usize) -> f64 {
    let mixed = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// A block of `count` observations, in which noise hides an effect over a slow driver.
pub(super) fn block(count: usize) -> BlockDiagnostics {
    let driver = |i: usize| (i as f64 * 20.0 / count as f64).sin();
    let gain = 0.01;
    let after: Vec<f64> = (0..count).map(|i| 0.02 * noise(i)).collect();
    let curve = EffectCurve {
        name: "shupe".into(),
        driver: "rate_of(temperature)".into(),
        driver_unit: "K/s".into(),
        unit: "deg/s".into(),
        points: (0..=80).map(|i| f64::from(i) / 40.0 - 1.0).map(|x| (x, gain * x)).collect(),
        observed: (0..count).map(|i| (driver(i), gain * driver(i) + after[i])).collect(),
    };
    let lags = |scale: f64| (0..60).map(|i| scale * noise(i)).collect();
    BlockDiagnostics {
        label: "gyro_angle".into(),
        unit: "deg".into(),
        time: (0..count).map(|i| i as f64).collect(),
        time_unit: "s".into(),
        run: (0..count).map(|i| i / 10).collect(),
        before: (0..count).map(|i| gain * driver(i) + after[i]).collect(),
        after,
        outliers: (0..count).map(|i| i == 7).collect(),
        channels: ["temperature", "voltage"]
            .map(|name| Series {
                name: name.into(),
                unit: "Cel".into(),
                values: (0..count).map(driver).collect(),
            })
            .into(),
        effects: vec![curve],
        autocorrelation: (lags(0.9), lags(0.1)),
        allan: (0..20).map(|i| 1.5_f64.powi(i)).map(|t| (t, 0.1, 0.05 / t.sqrt())).collect(),
        by_run: (0..count.div_ceil(10))
            .map(|run| RunError { run, before: 0.2 + 0.1 * noise(run), after: 0.1 })
            .collect(),
        noise: vec![
            parameter("white", 0.05, "deg"),
            parameter("correlated_over_12.500_s", 0.02, "deg"),
        ],
    }
}

pub(super) fn diagnostics(count: usize) -> Diagnostics {
    let block = block(count);
    let run_labels = (1..=block.by_run.len()).map(|run| format!("turn {run}")).collect();
    Diagnostics { blocks: vec![block], run_labels }
}
