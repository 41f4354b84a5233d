//! Rules of the search, each at work on a small record.

use super::block::{identify_block, keep_better};
use super::choose::{Contender, plainest_first};
use super::found::{Asked, Step};
use super::jointly::{Joint, Outliers};
use super::record::Record;
use super::roughly::{doubtful, estimates, unreportable};
use super::scene::Score;
use super::state::{BESIDE_COLOUR, State, is_within_physics};
use super::{finish, values};
use crate::candidates::{Candidate, Family};
use crate::dataset::{Column, Dataset, Kind, Role, Unit};
use crate::fit::Data;
use crate::judge::{Holding, Judge};
use crate::model::{Acts, Driver, Form, Shape, Wrap};
use crate::noise::{Coloured, Layout, NoiseModel};
use crate::problem::{Known, Problem};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Runs of readings at rest, one a second.
const RUNS: usize = 6;
const ROWS: usize = 200;
/// Noise of a reading, deg/s.
const NOISE: f64 = 0.01;
/// Risk of a false alarm, in nats.
const THRESHOLD: f64 = 4.5;

fn draws(seed: u64) -> Vec<f64> {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    (0..RUNS * ROWS).map(|_| StandardNormal.sample(&mut random)).collect()
}

/// Noise that forgets within `memory_s`, of variance 1.
fn slow(memory_s: f64, seed: u64) -> Vec<f64> {
    let keep = (-1.0 / memory_s).exp();
    let mut state = 0.0;
    let next = |(row, z): (usize, f64)| {
        let new = (1.0 - keep * keep).sqrt() * z;
        state = if row % ROWS == 0 { z } else { keep * state + new };
        state
    };
    draws(seed).into_iter().enumerate().map(next).collect()
}

/// A gyro at rest that reads `error` (deg/s), beside these auxiliary channels.
fn at_rest(error: &[f64], beside: &[(&str, &[f64])]) -> Problem {
    turning(&vec![0.0; error.len()], error, beside)
}

/// The same, turning at these rates (deg/s).
fn turning(rates: &[f64], error: &[f64], beside: &[(&str, &[f64])]) -> Problem {
    let rate = |name: &str, role, values| Column::new(name, role, Unit::DegreePerSecond, values);
    let rows = error.len();
    let time = (0..rows).map(|row| row as f64).collect();
    let mut columns = vec![
        Column::new("time", Role::Time, Unit::Second, time),
        rate("reference", Role::ReferenceRate, rates.to_vec()),
        rate("gyro", Role::GyroRate, rates.iter().zip(error).map(|(rate, e)| rate + e).collect()),
    ];
    columns.extend(
        beside
            .iter()
            .map(|(name, values)| Column::new(name, Role::Auxiliary, Unit::Volt, values.to_vec())),
    );
    let run = (0..rows).map(|row| row * RUNS / rows).collect();
    let dataset = Dataset::new("rest", Kind::Series, columns, run);
    Problem::new(&dataset, Known::default()).expect("a whole set")
}

/// Calls `work` with the plain model of `problem` under `noise`.
fn with_state<T>(
    problem: &Problem,
    noise: Option<NoiseModel>,
    work: impl FnOnce(State<'_>, &Judge<'_>) -> T,
) -> T {
    let block = &problem.blocks[0];
    let layout = Layout::new(block, &problem.channels);
    let data = Data::new(block, &problem.channels, &layout);
    let record = Record::new(data, None);
    let mut state = State {
        record: &record,
        data,
        base: 1,
        terms: vec![Shape::constant("bias", Acts::Bias)],
        families: Vec::new(),
        noise: noise.clone().unwrap_or_else(|| NoiseModel::white(RUNS)),
    };
    if noise.is_none() {
        state.fit_noise();
    }
    work(state, &Judge { data, path: None, holding: Holding::Spread })
}

fn over(name: &str) -> Candidate {
    let shape = Shape::new(name, Acts::Bias, Driver::plain(name), Form::Linear);
    Candidate { shape: shape.with("origin", 0.0), family: Family::Library }
}

/// Slope to apply, and the reported one, of a model over `load`; its noise is said to be slow.
fn slopes(error: &[f64], load: &[f64]) -> [f64; 2] {
    let problem = at_rest(error, &[("load", load)]);
    let coloured = vec![Coloured { correlation_s: 1000.0, variance: 100.0 }];
    let noise = NoiseModel { coloured, ..NoiseModel::white(RUNS) };
    with_state(&problem, Some(noise), |mut state, judge| {
        state.add(over("load"));
        let joint = Joint::new(&state, Outliers::Less);
        let mut fit = finish::of_noise(&state, &joint, Vec::new());
        values::of_noise(&mut fit, &state, judge);
        [&fit.applied[1], &fit.effects[0]].map(|found| found.coefficients[0].0.to_degrees())
    })
}

/// The gyro follows the load, and the load is read with an error of its own: from one reading to the next, only that
/// error moves.
#[test]
fn weights_for_slow_noise_that_predict_worse_are_equal_when_applied() {
    let load: Vec<f64> = (0..RUNS * ROWS).map(|row| (TAU * row as f64 / 150.0).sin()).collect();
    let read: Vec<f64> = load.iter().zip(draws(1)).map(|(load, e)| load + 0.15 * e).collect();
    let white = draws(2);
    let of_load: Vec<f64> = load.iter().zip(&white).map(|(load, e)| load + NOISE * e).collect();
    let [applied, reported] = slopes(&of_load, &read);
    assert!(reported < 0.8 && applied > 0.9, "{applied} {reported}");
    // Here it follows what is read, and what is slow differs from run to run: the weights predict better, and stay.
    let of_run = |row: usize| if (row / ROWS).is_multiple_of(2) { 0.5 } else { -0.5 };
    let of_reading: Vec<f64> =
        (0..load.len()).map(|i| read[i] + of_run(i) * load[i] + NOISE * white[i]).collect();
    let [applied, reported] = slopes(&of_reading, &read);
    assert!((applied / reported - 1.0).abs() < 0.01, "{applied} {reported}");
}

/// Slopes to apply over all of these channels, deg/s, of a model with an effect of each; the noise is white.
fn applied(error: &[f64], beside: &[(&str, &[f64])]) -> Vec<f64> {
    with_state(&at_rest(error, beside), Some(NoiseModel::white(RUNS)), |mut state, judge| {
        beside.iter().for_each(|(name, _)| state.add(over(name)));
        let joint = Joint::new(&state, Outliers::Less);
        let mut fit = finish::of_noise(&state, &joint, Vec::new());
        values::of_noise(&mut fit, &state, judge);
        fit.applied[1..].iter().map(|found| found.coefficients[0].0.to_degrees()).collect()
    })
}

/// In a short record, noise follows anything a little, and many things by a good part of its size.
#[test]
fn what_explains_no_more_than_noise_would_is_not_applied() {
    let (rows, names) = (72, ["a", "b", "c", "d", "e", "f", "g", "h"]);
    let mut gone = 0;
    for seed in 0..10 {
        let noise: Vec<f64> = draws(50 + seed)[..rows].iter().map(|z| NOISE * z).collect();
        let draws = draws(60);
        let beside: Vec<(&str, &[f64])> = names.into_iter().zip(draws.chunks(rows)).collect();
        gone += applied(&noise, &beside).iter().filter(|slope| **slope == 0.0).count();
    }
    // Two thirds of squares of normal noise are below 1.
    assert!(gone > 40, "{gone} of 80");
}

#[test]
fn effects_that_stand_for_one_another_are_applied_together() {
    let (load, own) = (draws(71), draws(72));
    let like: Vec<f64> = load.iter().zip(&own).map(|(load, own)| load + 1e-3 * own).collect();
    let error: Vec<f64> =
        load.iter().zip(draws(73)).map(|(load, white)| NOISE * (load + white)).collect();
    let found = applied(&error, &[("load", &load), ("like", &like)]);
    let sum = found.iter().sum::<f64>() / NOISE;
    assert!((sum - 1.0).abs() < 0.1, "{found:?}");
}

/// A constant within its error is no effect, unless a function has its zero from it.
#[test]
fn a_constant_within_its_error_is_doubtful() {
    let (load, white) = (draws(81), draws(82));
    let mean = white.iter().sum::<f64>() / white.len() as f64;
    let is_doubtful = |offset: f64, slope: f64| {
        let row = |(load, z): (&f64, &f64)| NOISE * (z - mean + offset + slope * load);
        let error: Vec<f64> = load.iter().zip(&white).map(row).collect();
        with_state(&at_rest(&error, &[("load", &load)]), None, |mut state, _| {
            state.base = 0;
            state.families.push(Family::Library);
            if slope > 0.0 {
                state.add(over("load"));
            }
            doubtful(&state).is_some()
        })
    };
    assert!(is_doubtful(0.0, 0.0) && !is_doubtful(1.0, 0.0) && !is_doubtful(0.0, 1.0));
}

/// What one constant in twenty would be by chance, one of several is more often.
#[test]
fn a_constant_is_reported_against_all_that_the_model_could_have() {
    let white = draws(83);
    let mean = white.iter().sum::<f64>() / white.len() as f64;
    let rates: Vec<f64> =
        (0..RUNS * ROWS).map(|row| 10.0 * (TAU * row as f64 / 50.0).sin()).collect();
    let mut between = 0;
    for size in 0..40 {
        let offset = 0.005 * f64::from(size);
        let error: Vec<f64> = white.iter().map(|z| NOISE * (z - mean + offset)).collect();
        let mut problem = turning(&rates, &error, &[]);
        problem.blocks[0].constants.clear();
        with_state(&problem, None, |mut state, _| {
            state.base = 0;
            state.families.push(Family::Library);
            let shapes = state.record.candidates().iter().map(|seen| &seen.candidate.shape);
            let tried = shapes.filter(|shape| shape.drivers.is_empty()).count() as f64;
            let strength = estimates(&state).terms[0].strength;
            assert_eq!(
                unreportable(&state, 1.0).is_none(),
                strength >= (20.0 * tried).ln(),
                "{strength}"
            );
            between += usize::from((20_f64.ln()..(20.0 * tried).ln()).contains(&strength));
        });
    }
    assert!(between > 0);
}

/// Whether a step adds an effect of the load, and its strength beyond the threshold.
fn added(problem: &Problem) -> (bool, f64, bool) {
    with_state(problem, None, |mut state, _| {
        let strongest = state.round(THRESHOLD).into_iter();
        let strength = strongest
            .filter(|one| one.candidate.shape.drivers == [Driver::plain("load")])
            .map(|one| one.strength - THRESHOLD)
            .fold(f64::NEG_INFINITY, f64::max);
        let is_coloured = state.noise.is_coloured();
        (state.step(THRESHOLD, false).is_ok(), strength, is_coloured)
    })
}

/// In slow noise, an effect must be surer than in white noise: otherwise more nulls give an alarm than the risk says.
#[test]
fn beside_slow_noise_an_effect_must_be_surer() {
    let load: Vec<f64> = (0..RUNS * ROWS).map(|row| (TAU * row as f64 / 37.0).sin()).collect();
    let (mut between, mut between_white) = (0, 0);
    for seed in 0..4 {
        let (white, slow) = (draws(10 + seed), slow(20.0, 20 + seed));
        for size in 0..30 {
            let of = |slow_part: f64| -> Vec<f64> {
                let noise = white.iter().zip(&slow).map(|(w, s)| w + slow_part * s);
                let size = 0.02 * f64::from(size);
                noise.zip(&load).map(|(noise, load)| NOISE * (noise + size * load)).collect()
            };
            let is_between = |strength: f64| (0.0..BESIDE_COLOUR).contains(&strength);
            let (adds, strength, is_coloured) = added(&at_rest(&of(1.5), &[("load", &load)]));
            assert!(is_coloured, "{seed}");
            if is_between(strength) {
                assert!(!adds, "{seed} {size} {strength}");
                between += 1;
            }
            let (adds, strength, is_coloured) = added(&at_rest(&of(0.0), &[("load", &load)]));
            if is_between(strength) && !is_coloured {
                assert!(adds, "{seed} {size} {strength}");
                between_white += 1;
            }
        }
    }
    assert!(between > 2 && between_white > 2, "{between} {between_white}");
}

/// A channel that is nearly the sum of two causes is found before them. It stays only as long as it ranks first.
#[test]
fn a_stand_in_gives_way_to_the_cause() {
    let (a, b, own) = (draws(31), draws(32), draws(33));
    let mut right = 0;
    for seed in 0..10 {
        let white = draws(40 + seed);
        let row = |f: &dyn Fn(usize) -> f64| (0..RUNS * ROWS).map(f).collect::<Vec<f64>>();
        let mix = row(&|i| 0.6 * a[i] + b[i] + 0.25 * own[i]);
        let error = row(&|i| NOISE * (0.5 * a[i] + 0.5 * b[i] + white[i]));
        let problem = at_rest(&error, &[("a", &a), ("b", &b), ("mix", &mix)]);
        right += usize::from(with_state(&problem, None, |state, judge| {
            let asked = Asked { share: 1.0, effects_max: 6, noise: None, timing: None };
            let fit = identify_block(state.data, judge, state.terms, asked, &mut |_| {});
            let drivers = fit.effects.iter().map(|one| one.shape.drivers[0].field.as_str());
            let mut drivers: Vec<&str> = drivers.collect();
            drivers.sort_unstable();
            drivers == ["a", "b"]
        }));
    }
    assert!(right >= 9, "{right}");
}

/// Candidates of these names, families and statistics, in the order in which they are tried.
fn order(of: [(&str, Family, f64); 2]) -> Vec<String> {
    let contender = |(name, family, statistic): (&str, Family, f64)| {
        let shape = match (name, family) {
            ("constant", _) => Shape::constant(name, Acts::Turn),
            (_, Family::Smooth) => {
                Shape::new(name, Acts::Turn, Driver::plain(name), Form::Spline).unnamed()
            }
            (_, Family::Periodic) => {
                Shape::new(name, Acts::Turn, Driver::new(Wrap::Periodic, name), Form::Periodic)
            }
            _ => Shape::new(name, Acts::Turn, Driver::plain(name), Form::Linear),
        };
        let score = Score { statistic, width: 1, surprise: statistic / 2.0 };
        Contender::new(Candidate { shape, family }, score, statistic / 2.0, 1000.0)
    };
    let mut contenders = of.map(contender).to_vec();
    contenders.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    plainest_first(&mut contenders, THRESHOLD);
    contenders.into_iter().map(|one| one.candidate.shape.name).collect()
}

#[test]
fn a_named_cause_goes_before_a_shape_and_nothing_before_the_likelier_cause() {
    let named =
        |family, statistic| [("shape", Family::Smooth, 100.0), ("named", family, statistic)];
    assert_eq!(order(named(Family::Library, 70.0)), ["named", "shape"]);
    assert_eq!(order(named(Family::Library, 50.0)), ["shape", "named"]);
    // That something repeats says when and not why.
    assert_eq!(order(named(Family::Periodic, 70.0)), ["shape", "named"]);
    let likelier =
        |statistic| [("cause", Family::Library, 100.0), ("constant", Family::Library, statistic)];
    assert_eq!(order(likelier(90.0)), ["cause", "constant"]);
    assert_eq!(order(likelier(98.0)), ["constant", "cause"]);
}

/// What a low-pass takes too much, a delay that leads gives back: together they say how a signal is smoothed both ways, which
/// no sensor does.
#[test]
fn beside_a_low_pass_nothing_leads() {
    let tone = |row: f64| 9.0 * (0.11 * row).sin() + 7.0 * (0.19 * row + 1.0).sin();
    let rates: Vec<f64> = (0..RUNS * ROWS).map(|row| tone(row as f64)).collect();
    let late = |wrap, name: &str, number: f64| {
        let driver = Driver::new(wrap, "reference");
        let shape = Shape::new("late", Acts::Delay, driver, Form::Delay).with(name, number);
        Candidate { shape, family: Family::Library }
    };
    let low_pass = late(Wrap::LagOf, "time_constant", 1.5);
    for (delay, stands) in [(0.6, true), (-0.6, false)] {
        let delayed = late(Wrap::Plain, "delay", delay);
        let on_time = turning(&rates, &vec![0.0; rates.len()], &[]);
        let both = with_state(&on_time, None, |state, _| {
            [(&low_pass, 1.5), (&delayed, delay)].map(|(one, number)| {
                let column = state.data.columns(&one.shape).swap_remove(0);
                column.into_iter().map(|value| (number * value).to_degrees()).collect::<Vec<f64>>()
            })
        });
        let noise = draws(3);
        let error: Vec<f64> =
            (0..noise.len()).map(|i| both[0][i] + both[1][i] + NOISE * noise[i]).collect();
        with_state(&turning(&rates, &error, &[]), None, |mut state, _| {
            state.add(low_pass.clone());
            assert!(is_within_physics(&state), "{delay}");
            state.add(delayed.clone());
            assert_eq!(is_within_physics(&state), stands, "{delay}");
        });
    }
}

/// The load is read with an error of its own, on which weights for slow noise rest.
#[test]
fn of_one_model_with_other_weights_that_stands_which_predicts_better() {
    let load: Vec<f64> = (0..RUNS * ROWS).map(|row| (TAU * row as f64 / 150.0).sin()).collect();
    let read: Vec<f64> = load.iter().zip(draws(1)).map(|(load, e)| load + 0.15 * e).collect();
    let error: Vec<f64> = load.iter().zip(draws(2)).map(|(load, e)| load + NOISE * e).collect();
    let coloured = vec![Coloured { correlation_s: 1000.0, variance: 100.0 }];
    let noise = NoiseModel { coloured, ..NoiseModel::white(RUNS) };
    with_state(&at_rest(&error, &[("load", &read)]), Some(noise), |plain, judge| {
        let mut weighted = plain.clone();
        weighted.add(over("load"));
        let mut equal = weighted.clone();
        equal.noise = NoiseModel::white(RUNS);
        for order in [[&weighted, &equal], [&equal, &weighted]] {
            let [one, other] = order.map(|state| Step::new(state.clone(), judge));
            let mut path = vec![Step::new(plain.clone(), judge), one, other];
            keep_better(&mut path);
            let [_, kept] = &path[..] else { panic!("{}", path.len()) };
            assert!(!kept.state.noise.is_coloured());
        }
    });
}
