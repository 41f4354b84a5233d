//! Tests the generator against itself: the noise has the stated size, and the truth is what is scored.

use evaluation::catalogue::{Case, Purpose, cases};
use evaluation::design::norm;
use evaluation::random::{MASTER_TEST, MASTER_TRAIN};
use evaluation::run::{Identifier, run};
use evaluation::world::{Strength, World, known_best, oracle, strength_of};
use identification::dataset::{Dataset, Kind, Role};
use identification::finding::{
    Effect, Figure, Finding, HeldOut, Parameter, Prediction, Rival, RmsePair, SCHEMA, Verdict,
};
use statrs::distribution::{ChiSquared, ContinuousCDF};

fn of(group: &str, effect: &str, z: f64) -> Vec<Case> {
    let found: Vec<Case> = cases()
        .into_iter()
        .filter(|case| {
            case.group == group && case.effect == effect && case.purpose == Purpose::Effect(z)
        })
        .collect();
    assert!(!found.is_empty(), "{group} {effect}");
    found
}

/// p value of the effect's column in data without the effect.
fn p_of_nothing(world: &dyn World, noise: f64) -> f64 {
    let (strength, _) = strength_of(world, 10.0).expect("sized");
    let design = world.design();
    let projector = design.projector();
    let none = Strength { sizes: vec![0.0; strength.sizes.len()], noise };
    let mut base_only = world.observed(&none);
    if let Some(nominal) = world.nominal() {
        base_only.iter_mut().zip(nominal).for_each(|(x, nominal)| *x -= nominal);
    }
    let project = |column: &[f64]| {
        let mut column = design.whiten(column);
        projector.project(&mut column);
        column
    };
    let effect = project(&world.contribution(0, strength.sizes[0]));
    let residual = project(&base_only);
    let along: f64 = effect.iter().zip(&residual).map(|(e, r)| e * r).sum::<f64>() / norm(&effect);
    let chi = ChiSquared::new(1.0).expect("one degree of freedom");
    chi.sf(along * along / (noise * noise))
}

/// Kolmogorov's distance of sorted numbers from the uniform distribution.
fn kolmogorov(mut p: Vec<f64>) -> f64 {
    p.sort_by(f64::total_cmp);
    let n = p.len() as f64;
    let distance = |(k, p): (usize, &f64)| (p - k as f64 / n).max((k + 1) as f64 / n - p);
    p.iter().enumerate().map(distance).fold(0.0, f64::max)
}

#[test]
fn the_oracles_p_is_uniform_where_there_is_nothing() {
    /// Kolmogorov's 0.1 % point of the distance, times the root of the number.
    const POINT: f64 = 1.95;
    // Every case of these groups has its own programme and its own noise.
    for group in ["series", "series-headings", "turns", "laps", "laps-odometry", "odometry-synchro"]
    {
        let mut p = Vec::new();
        for case in cases().iter().filter(|case| case.group == group) {
            let small = group != "series" || matches!(case.repeat, 0 | 1 | 5);
            let linear =
                !matches!(case.family, "nonlinearity" | "time" | "noise" | "axis" | "pair");
            if small && linear && case.purpose == Purpose::Effect(10.0) {
                p.push(p_of_nothing(case.world(MASTER_TRAIN).as_ref(), 1.0));
                p.push(p_of_nothing(case.world(MASTER_TEST).as_ref(), 1.0));
            }
        }
        assert!(p.len() >= 24, "{group}: {}", p.len());
        let distance = kolmogorov(p.clone()) * (p.len() as f64).sqrt();
        assert!(distance < POINT, "{group}: {distance} of {}", p.len());
    }
}

#[test]
fn the_oracle_finds_its_effect_with_the_error_that_z_says() {
    // The factor's standard error is 1/z: the mean square of its normalised error is one.
    let mut errors = Vec::new();
    for z in [6.0, 10.0, 30.0] {
        for effect in ["shupe", "supply", "asymmetry", "magnetic"] {
            for case in
                of("series", effect, z).iter().filter(|case| matches!(case.repeat, 0 | 1 | 5))
            {
                let (train, test) = (case.world(MASTER_TRAIN), case.world(MASTER_TEST));
                let (strength, _) = strength_of(train.as_ref(), z).expect("sized");
                let oracle = oracle(train.as_ref(), test.as_ref(), &strength).expect("independent");
                errors.push((oracle.factors[0] - 1.0) * z);
                let (before, after) = oracle.test_rmse.expect("direct");
                assert!(after < before || z < 10.0, "{}: {before} {after}", case.name());
            }
        }
    }
    let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
    // chi2 of 36 over 36: 99.9 % within these.
    assert!((0.38..2.0).contains(&mean_square), "{mean_square}");
}

#[test]
fn the_oracle_finds_the_effects_of_paths_as_well() {
    /// Number of standard errors that no normal deviate exceeds in a hundred draws.
    const FAR: f64 = 4.5;
    for case in cases().iter().filter(|case| case.purpose == Purpose::Effect(30.0)) {
        if case.kind == Kind::Odometry && case.repeat < 2 || case.group == "laps-odometry" {
            let (train, test) = (case.world(MASTER_TRAIN), case.world(MASTER_TEST));
            let (strength, _) = strength_of(train.as_ref(), 30.0).expect("sized");
            let oracle = oracle(train.as_ref(), test.as_ref(), &strength).expect("independent");
            let error = (oracle.factors[0] - 1.0) * 30.0;
            assert!(error.abs() < FAR, "{}: {error}", case.name());
        }
    }
}

#[test]
fn an_effect_is_in_the_file_as_it_is_in_the_truth() {
    let case = &of("series", "shupe", 30.0)[0];
    let world = case.world(MASTER_TRAIN);
    let (strength, _) = strength_of(world.as_ref(), 30.0).expect("sized");
    let none = Strength { sizes: vec![0.0], noise: 1.0 };
    let rate = |dataset: Dataset| dataset.column(Role::GyroRate).expect("a gyro").values.clone();
    let (with, without) = (rate(world.dataset(&strength)), rate(world.dataset(&none)));
    let added = world.contribution(0, strength.sizes[0]);
    for ((with, without), added) in with.iter().zip(without).zip(added) {
        // Each reading is rounded to a twentieth of the noise.
        assert!((with - without - added).abs() <= 0.05 * 0.02 + 1e-9);
    }
}

#[test]
fn headings_wrap_and_are_sparse() {
    let case = &of("series-headings", "supply", 10.0)[0];
    let world = case.world(MASTER_TRAIN);
    let (strength, _) = strength_of(world.as_ref(), 10.0).expect("sized");
    let dataset = world.dataset(&strength);
    let headings = &dataset.column(Role::ReferenceHeading).expect("headings").values;
    let fixes: Vec<f64> = headings.iter().copied().filter(|x| !x.is_nan()).collect();
    assert_eq!(fixes.len() * 5, dataset.rows());
    assert!(fixes.iter().all(|x| (0.0..360.0).contains(x)));
    assert!(fixes.windows(2).any(|w| (w[1] - w[0]).abs() > 300.0), "it wraps somewhere");
    assert!(dataset.column(Role::ReferenceRate).is_none());
}

#[test]
fn training_and_test_data_differ_in_all_but_their_constants() {
    let case = &of("turns", "supply", 10.0)[0];
    let none = Strength { sizes: vec![0.0], noise: 1.0 };
    let angles = |master| case.world(master).observed(&none);
    let (train, test) = (angles(MASTER_TRAIN), angles(MASTER_TEST));
    assert_ne!(train, test);
    assert_eq!(angles(MASTER_TRAIN), train, "the same seed, the same data");
    let fit = |master| {
        let world = case.world(master);
        world.design().fit(&world.observed(&none), &[]).expect("independent")
    };
    let (train, test) = (fit(MASTER_TRAIN), fit(MASTER_TEST));
    assert!((train[1] - test[1]).abs() < 1e-4, "one scale: {train:?} {test:?}");
}

/// An identifier that returns preset findings.
struct Parrot {
    term: &'static str,
    drivers: &'static [&'static str],
    rival: bool,
    rmse_after: f64,
}

impl Identifier for Parrot {
    type Model = ();

    fn identify(&self, dataset: &Dataset, _: Option<usize>) -> Result<(Finding, ()), String> {
        let drivers = || self.drivers.iter().map(|&d| d.to_owned()).collect::<Vec<_>>();
        let rival = Rival {
            name: "rival".into(),
            term: self.term.into(),
            drivers: drivers(),
            probability: 0.2,
            separated_by: None,
        };
        let effect = Effect {
            name: "found".into(),
            known: true,
            term: if self.rival { "curvature".into() } else { self.term.into() },
            axis: None,
            drivers: drivers(),
            form: "linear".into(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: vec![Parameter {
                name: "k".into(),
                value: 0.0,
                standard_error: Some(1e9),
                unit: "deg/s/(K/s)".into(),
                range: None,
            }],
            p_value: 1e-9,
            held_out_before: 1.0,
            held_out_after: 0.5,
            rivals: if self.rival { vec![rival] } else { Vec::new() },
        };
        let silent = self.term.is_empty();
        let finding = Finding {
            schema: SCHEMA,
            dataset: dataset.name.clone(),
            kind: dataset.kind,
            drive: None,
            rows: dataset.rows(),
            runs: dataset.run_labels.len(),
            seed: 1,
            verdict: if silent { Verdict::NothingMissing } else { Verdict::Explained },
            noise_floor: Figure { value: 0.02, unit: "deg/s".into() },
            held_out: HeldOut {
                metric: "rmse".into(),
                quantity: None,
                unit: "deg/s".into(),
                before: 1.0,
                after: 0.5,
                ci95: [0.4, 0.6],
                folds: 5,
            },
            held_out_also: Vec::new(),
            base: Vec::new(),
            effects: if silent { Vec::new() } else { vec![effect] },
            path: Vec::new(),
            left: Vec::new(),
            compensation: None,
            compensation_also: Vec::new(),
            next_experiment: None,
            set_aside: Vec::new(),
            notices: Vec::new(),
        };
        Ok((finding, ()))
    }

    fn predict(&self, dataset: &Dataset, (): &()) -> Result<Prediction, String> {
        Ok(Prediction {
            schema: SCHEMA,
            dataset: dataset.name.clone(),
            kind: dataset.kind,
            rows: dataset.rows(),
            quantity: "rate".into(),
            unit: "deg/s".into(),
            rmse: RmsePair { before: 1.0, after: self.rmse_after },
            at: Vec::new(),
            predicted: Vec::new(),
            residual: Vec::new(),
            also: Vec::new(),
            set_aside: Vec::new(),
        })
    }
}

#[test]
fn answers_are_scored_by_what_they_say() {
    let case = &of("series", "shupe", 30.0)[0];
    let say = |term, drivers, rival| Parrot { term, drivers, rival, rmse_after: 1.0 };
    let score = |parrot: &Parrot| run(case, parrot, &|| 0.0);

    let right = score(&say("bias", &["rate_of(temperature)"], false));
    assert!(right.detected && right.explained && right.first && right.within);
    assert_eq!(right.covered, Some(true));
    assert!(right.gain_ratio.expect("direct") < 0.0, "an error of 1 deg/s is far worse than none");

    let rival = score(&say("bias", &["rate_of(temperature)"], true));
    assert!(!rival.first && rival.within && rival.rivals == Some(1) && rival.covered.is_none());

    let wrong = score(&say("bias", &["temperature"], false));
    assert!(wrong.detected && !wrong.first && !wrong.within);

    let silent = score(&say("", &[], false));
    assert!(!silent.detected && !silent.first && silent.rivals.is_none());
}

#[test]
fn the_plain_model_gains_nothing_and_the_oracle_all() {
    let case = &of("series", "shupe", 30.0)[0];
    let (train, test) = (case.world(MASTER_TRAIN), case.world(MASTER_TEST));
    let (strength, _) = strength_of(train.as_ref(), 30.0).expect("sized");
    let oracle = oracle(train.as_ref(), test.as_ref(), &strength).expect("independent");
    let (before, after) = oracle.test_rmse.expect("direct");
    for (rmse_after, gain) in [(before, 0.0), (after, 1.0)] {
        let parrot = Parrot { term: "bias", drivers: &[], rival: false, rmse_after };
        let ratio = run(case, &parrot, &|| 0.0).gain_ratio.expect("direct");
        assert!((ratio - gain).abs() < 1e-9, "{ratio}");
    }
}

#[test]
fn an_effect_in_noise_alone_is_an_alarm_unless_it_is_the_noise() {
    let null = |class: &str| {
        let mut nulls = cases().into_iter().filter(|case| matches!(case.purpose, Purpose::Null(_)));
        nulls.find(|case| case.effect == class).expect("some")
    };
    let alarm = |class, term| {
        let parrot = Parrot { term, drivers: &[], rival: false, rmse_after: 1.0 };
        run(&null(class), &parrot, &|| 0.0).false_alarm
    };
    assert!(!alarm("white", ""));
    assert!(alarm("white", "bias") && alarm("white", "noise"));
    assert!(!alarm("autoregressive", "noise") && alarm("autoregressive", "bias"));
    assert!(!alarm("quantised", "quantisation") && alarm("quantised", "scale"));
}

#[test]
fn the_ceiling_is_high_for_large_effects_and_low_for_what_noise_hides() {
    let share = |z: f64| {
        let of_turns = |case: &Case| case.group == "turns" && case.purpose == Purpose::Effect(30.0);
        let named = cases().into_iter().filter(of_turns).filter_map(|case| {
            let (world, all) = (case.world(MASTER_TRAIN), case.with_every_effect(MASTER_TRAIN));
            let (strength, _) = strength_of(world.as_ref(), z)?;
            known_best(world.as_ref(), &strength, all.as_ref(), z)
        });
        let named: Vec<bool> = named.collect();
        named.iter().filter(|named| **named).count() as f64 / named.len() as f64
    };
    assert!(share(100.0) > 0.95, "{}", share(100.0));
    // Of 16 candidates, some are alike.
    assert!(share(0.01) < 0.4, "{}", share(0.01));
}
