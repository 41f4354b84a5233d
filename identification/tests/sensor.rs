//! Any sensor against its reference: a cause of each kind that such sensors have, and noise alone.

use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use identification::finding::{Effect, Verdict};
use identification::identify::{Identified, Options, identify, predict};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RUNS: usize = 6;
const ROWS: usize = 500;

/// Recordings of a sensor of `unit` with the reference `truth` and the readings `measured`.
fn dataset(
    unit: Unit,
    truth: impl Fn(f64) -> f64,
    measured: impl Fn(&[f64], usize) -> f64,
    sigma: f64,
    seed: u64,
) -> Dataset {
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
    let (mut time, mut reference, mut reads, mut warm) = (vec![], vec![], vec![], vec![]);
    let mut run_of_row = Vec::new();
    for run in 0..RUNS {
        let begin = 1000.0 * run as f64;
        let course: Vec<f64> = (0..ROWS).map(|row| truth(begin + row as f64)).collect();
        for row in 0..ROWS {
            let noise: f64 = StandardNormal.sample(&mut random);
            time.push(begin + row as f64);
            reads.push(measured(&course, row) + sigma * noise);
            reference.push(course[row]);
            warm.push(25.0 + 8.0 * ((begin + row as f64) / 170.0).sin());
            run_of_row.push(run);
        }
    }
    Dataset::new(
        "sensor",
        Kind::Sensor,
        vec![
            Column::new("time", Role::Time, Unit::Second, time),
            Column::new("reads", Role::Measured, unit, reads),
            Column::new("truth", Role::Reference, unit, reference),
            Column::new("warmth", Role::Temperature, Unit::Celsius, warm),
        ],
        run_of_row,
    )
}

fn found(dataset: &Dataset) -> Identified {
    let found = identify(dataset, None, &Options::default(), &mut |_, _| ()).unwrap();
    if !found.finding.effects.is_empty() {
        let told = predict(dataset, &found.model).unwrap();
        assert!(told.rmse.after < told.rmse.before);
    }
    found
}

/// Asserts that it is the first effect or a rival of it.
fn assert_names(found: &Identified, name: &str) {
    let first = found.finding.effects.first();
    let named = first.is_some_and(|effect| {
        effect.name == name || effect.rivals.iter().any(|rival| rival.name == name)
    });
    assert!(named, "{name}: {:?} {:?}", found.finding.effects, found.finding.left);
}

fn wander(t: f64) -> f64 {
    3.0 * (t / 23.0).sin() + 2.0 * (t / 61.0).cos()
}

#[test]
fn cycles_a_turn_of_a_resolver_are_counted() {
    let angle = |t: f64| (1.7 * t).rem_euclid(360.0);
    for order in [1, 2, 7] {
        let error = |course: &[f64], row: usize| {
            course[row] + 0.2 * (f64::from(order) * course[row].to_radians() + 0.4).cos()
        };
        let found = found(&dataset(Unit::Degree, angle, error, 0.1, 3));
        let effect = &found.finding.effects[0];
        assert_eq!(effect.drivers, [format!("harmonic_{order}(truth)")]);
        assert_eq!(found.finding.effects.len(), 1);
    }
}

#[test]
fn nonlinearity_lag_delay_and_hysteresis_have_their_names() {
    let lagged = |course: &[f64], row: usize| {
        let keep = (-1.0_f64 / 4.0).exp();
        course[..=row].iter().fold(course[0], |state, value| keep * state + (1.0 - keep) * value)
    };
    let play = |course: &[f64], row: usize| {
        let mut at = course[0];
        for value in &course[..=row] {
            at = at.clamp(value - 0.4, value + 0.4);
        }
        at
    };
    type Cause = (&'static str, Box<dyn Fn(&[f64], usize) -> f64>);
    let causes: [Cause; 4] = [
        ("nonlinearity", Box::new(|course, row| course[row] + 0.01 * course[row].powi(2))),
        ("bandwidth", Box::new(lagged)),
        ("hysteresis", Box::new(move |course, row| 0.7 * course[row] + 0.3 * play(course, row))),
        ("delay", Box::new(|course, row| course[row.saturating_sub(2)])),
    ];
    for (name, cause) in causes {
        assert_names(&found(&dataset(Unit::Volt, wander, cause, 0.03, 5)), name);
    }
}

/// Root mean square before and after the compensation, on other recordings.
fn compensated(dataset: &Dataset) -> [f64; 2] {
    let found = found(dataset);
    let compensation = found.finding.compensation.clone();
    let Some(compensation) = compensation else { panic!("none: {:?}", found.finding.effects) };
    assert_eq!(found.model.compensation.as_ref(), Some(&compensation));
    assert_eq!((&*compensation.of, compensation.held_out.folds), ("reads", 5));
    assert_eq!(compensation.steps.last().map(|step| &*step.name), Some("corrected"));
    [compensation.held_out.before, compensation.held_out.after]
}

#[test]
fn what_a_sensor_shows_wrongly_is_taken_off_down_to_its_noise() {
    let sigma = 0.03;
    let play = |course: &[f64], row: usize| {
        let mut at = course[0];
        for value in &course[..=row] {
            at = at.clamp(value - 0.4, value + 0.4);
        }
        at
    };
    type Cause = (&'static str, Box<dyn Fn(&[f64], usize) -> f64>);
    let causes: [Cause; 4] = [
        ("offset and scale", Box::new(|course, row| 1.03 * course[row] + 0.2)),
        ("curve", Box::new(|course, row| course[row] + 0.01 * course[row].powi(2))),
        ("reversed curve", Box::new(|course, row| -course[row] + 0.01 * course[row].powi(2))),
        ("hysteresis", Box::new(move |course, row| 0.7 * course[row] + 0.3 * play(course, row))),
    ];
    for (name, cause) in causes {
        let [before, after] = compensated(&dataset(Unit::Volt, wander, cause, sigma, 7));
        assert!(before > 2.0 * sigma, "{name}: {before}");
        assert!(after < 1.15 * sigma, "{name}: {before} -> {after}");
    }
    // Cycles of an angle that wraps after each turn.
    let angle = |t: f64| (1.7 * t).rem_euclid(360.0);
    let error = |course: &[f64], row: usize| {
        (course[row] + 0.8 * (2.0 * course[row].to_radians()).sin()).rem_euclid(360.0)
    };
    let [before, after] = compensated(&dataset(Unit::Degree, angle, error, 0.1, 7));
    assert!(before > 0.5 && after < 0.115, "{before} -> {after}");
}

/// Beyond its knee a reading still rises with what is measured, more steeply.
#[test]
fn a_knee_is_taken_off_unless_it_is_flat() {
    let bent = |course: &[f64], row: usize| {
        let over = f64::max(0.0, course[row].abs() - 2.0);
        course[row] + 0.6 * over * course[row].signum()
    };
    let data = dataset(Unit::Volt, wander, bent, 0.03, 7);
    let [before, after] = compensated(&data);
    assert_eq!(found(&data).finding.effects[0].name, "saturation");
    assert!(before > 0.3 && after < 0.05, "{before} -> {after}");
    let clipped = |course: &[f64], row: usize| 0.9 * course[row].clamp(-2.0, 2.0);
    let found = found(&dataset(Unit::Volt, wander, clipped, 0.03, 7)).finding;
    let left_out = found.compensation.into_iter().flat_map(|one| one.left_out);
    assert!(left_out.into_iter().all(|one| one.term == "saturation"));
}

/// Nothing is offered that a reading does not say, and a notice says why.
#[test]
fn what_firmware_cannot_mend_is_refused_with_the_reason() {
    let refused = |data: &Dataset, why: &str| {
        let found = identify(data, None, &Options::default(), &mut |_, _| ()).unwrap();
        assert!(found.finding.compensation.is_none() && found.model.compensation.is_none());
        let notices = &found.finding.notices;
        assert!(notices.iter().any(|said| said.contains(why)), "{why}: {notices:?}");
    };
    // A wire that is broken reads hum.
    let broken = dataset(Unit::Volt, wander, |_, _| 3.0, 0.5, 7);
    refused(&broken, "could as well be zero");
    // A clock that is an hour off, of readings a minute apart.
    let late = |course: &[f64], row: usize| course[row.saturating_sub(60)];
    let mut late = dataset(Unit::Celsius, wander, late, 0.03, 7);
    late.columns[0].values.iter_mut().for_each(|time| *time *= 60.0);
    refused(&late, "60.0 min late, longer than any sensor takes");
}

/// A model of a sensor holds, whatever another recording has for a reference.
#[test]
fn a_hysteresis_is_predicted_beside_a_noisy_reference_too() {
    let play = |course: &[f64], row: usize| {
        let mut at = course[0];
        for value in &course[..=row] {
            at = at.clamp(value - 0.4, value + 0.4);
        }
        0.7 * course[row] + 0.3 * at
    };
    let found = found(&dataset(Unit::Volt, wander, play, 0.03, 7));
    assert_names(&found, "hysteresis");
    let mut other = dataset(Unit::Volt, wander, play, 0.03, 8);
    let mut random = chacha20::ChaCha8Rng::seed_from_u64(9);
    let normal = |value: &mut f64| {
        let noise: f64 = StandardNormal.sample(&mut random);
        *value += 0.1 * noise;
    };
    other.columns[2].values.iter_mut().for_each(normal);
    let told = predict(&other, &found.model).unwrap();
    assert!(told.rmse.after < 0.12, "{:?}", told.rmse);
}

/// A device that had a hysteresis, and whose readings have none.
#[test]
fn no_compensation_does_more_than_gain_and_offset_where_that_does_as_well() {
    let play = |course: &[f64], row: usize| {
        let mut at = course[0];
        for value in &course[..=row] {
            at = at.clamp(value - 0.4, value + 0.4);
        }
        0.7 * course[row] + 0.3 * at
    };
    let before = found(&dataset(Unit::Volt, wander, play, 0.03, 7));
    assert_names(&before, "hysteresis");
    let exact = |course: &[f64], row: usize| 1.03 * course[row] + 0.2;
    let now = dataset(Unit::Volt, wander, exact, 0.05, 7);
    let found = identify(&now, Some(&before.model), &Options::default(), &mut |_, _| ()).unwrap();
    let compensation = found.finding.compensation.unwrap();
    let text = format!("{:?}", compensation.steps);
    assert!(!text.contains("clamp"), "{text}");
    assert_eq!(compensation.left_out.len(), 1, "{:?}", compensation.left_out);
    assert_eq!(compensation.left_out[0].term, "hysteresis");
    assert!(compensation.left_out[0].why.starts_with("gain and offset alone"));
    assert!(compensation.held_out.after < 0.051, "{:?}", compensation.held_out);
}

#[test]
fn what_comes_late_is_led_as_far_as_its_noise_lets_it() {
    // A delay of 2 s on a signal with periods of minutes; the lead adds the noise of the slope.
    let late = |course: &[f64], row: usize| course[row.saturating_sub(2)];
    let [before, after] = compensated(&dataset(Unit::Volt, wander, late, 0.01, 5));
    assert!(before > 0.15 && after < 0.25 * before, "{before} -> {after}");
}

#[test]
fn a_slow_probe_and_one_that_clips_have_their_terms() {
    let slow = |course: &[f64], row: usize| {
        let keep = (-1.0_f64 / 12.0).exp();
        course[..=row].iter().fold(course[0], |state, value| keep * state + (1.0 - keep) * value)
    };
    let of = |cause: fn(&[f64], usize) -> f64| {
        let found = found(&dataset(Unit::Celsius, wander, cause, 0.02, 11));
        let effect = found.finding.effects.first().cloned();
        effect.unwrap_or_else(|| panic!("nothing: {:?}", found.finding.left))
    };
    let number = |effect: &Effect, name: &str| {
        effect.parameters.iter().find(|one| one.name == name).map(|one| one.value).unwrap()
    };
    let lag = of(slow);
    assert_eq!((&*lag.name, &*lag.term), ("bandwidth", "delay"));
    assert!((number(&lag, "time_constant") - 12.0).abs() < 1.0, "{lag:?}");
    let clipped = of(|course, row| course[row].clamp(-3.5, 3.5));
    assert_eq!((&*clipped.name, &*clipped.term), ("saturation", "saturation"));
    assert!((number(&clipped, "limit") - 3.5).abs() < 0.1, "{clipped:?}");
}

#[test]
fn an_angle_that_comes_late_is_late() {
    let angle =
        |t: f64| (5.0 * t + 60.0 * (t / 41.0).sin() + 30.0 * (t / 17.0).sin()).rem_euclid(360.0);
    let mut late = dataset(Unit::Degree, angle, |course, row| course[row], 0.1, 3);
    // Consecutive runs without a break; the signal was already on its way before they began.
    for row in 0..RUNS * ROWS {
        let time = row as f64;
        let noise = late.columns[1].values[row] - late.columns[2].values[row];
        late.columns[0].values[row] = time;
        late.columns[1].values[row] = angle(time - 1.4) + noise;
        late.columns[2].values[row] = angle(time);
    }
    let found = found(&late);
    let names: Vec<&str> = found.finding.effects.iter().map(|one| &*one.name).collect();
    assert_eq!(names, ["delay"]);
    assert!(found.finding.held_out.after < 0.11, "{:?}", found.finding.held_out);
}

#[test]
fn what_is_on_or_off_is_a_cause_with_one_size() {
    let exact = |course: &[f64], row: usize| course[row];
    let mut data = dataset(Unit::Ampere, wander, exact, 0.05, 12);
    let pump: Vec<f64> = (0..RUNS * ROWS).map(|row| f64::from(row / 90 % 3 == 1)).collect();
    data.columns[1].values.iter_mut().zip(&pump).for_each(|(reads, pump)| *reads += 0.04 * pump);
    data.columns.push(Column::new("pump", Role::Auxiliary, Unit::One, pump));
    let found = found(&data);
    let [effect] = found.finding.effects.as_slice() else { panic!("{:?}", found.finding.effects) };
    assert_eq!(
        (effect.term.as_str(), effect.drivers.as_slice()),
        ("bias", &["pump".to_owned()][..])
    );
    let slope = effect.parameters.first().unwrap();
    assert!((slope.value - 0.04).abs() < 0.01, "{slope:?}");
}

#[test]
fn noise_of_a_sensor_is_noise() {
    for seed in 0..6 {
        let exact = |course: &[f64], row: usize| 1.01 * course[row] + 0.2;
        let found = found(&dataset(Unit::Ampere, wander, exact, 0.05, seed));
        assert!(found.finding.effects.is_empty(), "{seed}: {:?}", found.finding.effects);
        assert_eq!(found.finding.verdict, Verdict::NothingMissing);
    }
}

#[test]
fn units_that_contradict_are_refused_by_name() {
    let mut odd = dataset(Unit::Volt, wander, |course, row| course[row], 0.05, 1);
    odd.columns[2].unit = Unit::Ampere;
    let error = identify(&odd, None, &Options::default(), &mut |_, _| ()).unwrap_err();
    assert!(
        error.to_string().contains("`reads` is in V and its reference `truth` in A"),
        "{error}"
    );
}

#[test]
fn a_backlash_far_narrower_than_the_travel_is_told_beside_an_eccentric_mount() {
    let travel = |t: f64| 900.0 * (t / 90.0).sin() + 200.0 * (t / 17.0).sin();
    let error = |course: &[f64], row: usize| {
        let mut play = course[0];
        for now in &course[..=row] {
            play = play.clamp(now - 0.25, now + 0.25);
        }
        play + 0.45 * (course[row].to_radians() - 0.6).cos()
    };
    let found = found(&dataset(Unit::Degree, travel, error, 0.04, 8));
    let names: Vec<&str> = found.finding.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names.len(), 2, "{:?}", found.finding.effects);
    assert!(names.contains(&"once_a_turn") && names.contains(&"hysteresis"), "{names:?}");
    let play = found.finding.effects.iter().find(|one| one.name == "hysteresis").unwrap();
    let half = play.parameters.iter().find(|one| one.name == "half_width").unwrap();
    assert!((half.value - 0.25).abs() < 0.03, "{half:?}");
}

#[test]
fn a_load_cell_creeps_and_is_warm() {
    let load = |t: f64| 50.0 + 45.0 * ((t / 40.0).floor() * 2.4).sin();
    let error = |course: &[f64], row: usize| {
        let mut slow = course[0];
        for now in &course[1..=row] {
            slow += (now - slow) * (1.0 - (-1.0_f64 / 60.0).exp());
        }
        course[row] + 0.02 * (slow - course[row])
    };
    let mut data = dataset(Unit::One, load, error, 0.03, 4);
    let warm = data.column(Role::Temperature).unwrap().values.clone();
    let reads = data.columns.iter_mut().find(|one| one.role == Role::Measured).unwrap();
    reads.values.iter_mut().zip(warm).for_each(|(value, warm)| *value += 0.05 * (warm - 22.0));
    let found = found(&data);
    let names: Vec<&str> = found.finding.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names.len(), 2, "{:?}", found.finding.effects);
    assert!(names.contains(&"creep") && names.contains(&"bias_over_temperature"), "{names:?}");
    assert!(found.finding.held_out.after < 0.032, "{:?}", found.finding.held_out);
}

#[test]
fn a_reference_at_another_rate_is_not_the_readings() {
    let truth = |t: f64| 5.0 * (t / 40.0).sin() + 2.0 * (t / 13.0).cos();
    let error = |course: &[f64], row: usize| {
        let mut slow = course[0];
        for now in &course[1..=row] {
            slow += (now - slow) * (1.0 - (-1.0_f64 / 5.0).exp());
        }
        slow
    };
    let mut data = dataset(Unit::One, truth, error, 0.02, 6);
    let reference = data.columns.iter_mut().find(|one| one.role == Role::Reference).unwrap();
    let sparse = reference.values.iter_mut().enumerate().filter(|(row, _)| row % 5 != 2);
    sparse.for_each(|(_, value)| *value = f64::NAN);
    let found = found(&data);
    let names: Vec<&str> = found.finding.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["bandwidth"], "{:?}", found.finding.effects);
    let late = &found.finding.effects[0].parameters[0];
    // Of samples: the recursion above lags by half a sample more than the continuous one.
    assert!((late.value - 5.0).abs() < 0.6, "{late:?}");
}

#[test]
fn a_resolver_that_turns_the_other_way_is_told_by_its_sign() {
    let angle = |t: f64| (1.7 * t).rem_euclid(360.0);
    let error = |course: &[f64], row: usize| {
        (20.0 - course[row] + 0.3 * (2.0 * course[row].to_radians()).cos()).rem_euclid(360.0)
    };
    let found = found(&dataset(Unit::Degree, angle, error, 0.05, 3));
    let names: Vec<&str> = found.finding.effects.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["reversed_sign", "twice_a_turn"], "{:?}", found.finding.effects);
    let compensation = found.finding.compensation.unwrap().held_out;
    assert!(compensation.after < 0.06, "{compensation:?}");
}
