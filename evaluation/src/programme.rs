//! Conditions of the device during a recording: rotation, temperature, supply, motor current.

use crate::random::Stream;

/// Steady rates of the table, deg/s (assumption: the ladder of a +-100 deg/s gyro).
const RATES: [f64; 9] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 90.0];
/// The largest rate of a table's programme, deg/s.
pub const RATE_MAX: f64 = RATES[8];
/// Ramp of the table, deg/s^2 (assumption).
const RAMP: f64 = 10.0;
/// Segments of a run's programme of rotation (assumption).
const SEGMENTS: f64 = 30.0;
/// Largest rate of a slow sweep, deg/s (assumption: a few times the largest dead zone published).
const CREEP: f64 = 0.05;
/// Amplitude of gentle motion, deg/s (assumption: a slowly swaying platform).
const GENTLE: f64 = 0.2;

/// Style of rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rotation {
    /// Rests, steps of the ladder, sines and slow sweeps, in both directions.
    Table,
    /// Slow sines of small amplitude only.
    Gentle,
    /// Rests and steps up to a third of the range, as for a robot.
    Calm,
}

/// A rate (deg/s) for each of `n` rows, `dt` apart, starting from rest.
pub fn rotation(stream: &mut Stream, n: usize, dt: f64, style: Rotation) -> Vec<f64> {
    let segment = n as f64 / SEGMENTS;
    let mut wanted: Vec<f64> = vec![0.0];
    while wanted.len() < n {
        let rows = (segment * stream.between(0.5, 1.5)).max(4.0) as usize;
        let kind = stream.between(0.0, 1.0);
        let sign = stream.sign();
        match style {
            Rotation::Gentle => {
                let period = (rows as f64 * stream.between(0.4, 1.0)).max(8.0);
                let amplitude = sign * GENTLE * stream.between(0.3, 1.0);
                wanted.extend((0..rows).map(|k| amplitude * wave(k as f64 / period)));
            }
            _ if kind < 0.25 => wanted.extend(std::iter::repeat_n(0.0, rows)),
            Rotation::Calm => {
                let rate = sign * stream.pick(&RATES[..7]);
                wanted.extend(std::iter::repeat_n(rate, rows));
            }
            Rotation::Table if kind < 0.65 => {
                let rate = sign * stream.pick(&RATES);
                wanted.extend(std::iter::repeat_n(rate, rows));
            }
            Rotation::Table if kind < 0.85 => {
                let period = (rows as f64 / stream.between(1.0, 4.0)).max(8.0);
                let amplitude = sign * stream.pick(&RATES);
                wanted.extend((0..rows).map(|k| amplitude * wave(k as f64 / period)));
            }
            Rotation::Table => wanted
                .extend((0..rows).map(|k| sign * CREEP * (2.0 * k as f64 / rows as f64 - 1.0))),
        }
    }
    let step = RAMP * dt;
    let mut rate = 0.0;
    wanted.truncate(n);
    for wanted in &mut wanted {
        rate += (*wanted - rate).clamp(-step, step);
        *wanted = rate;
    }
    wanted
}

fn wave(cycles: f64) -> f64 {
    (std::f64::consts::TAU * cycles).sin()
}

/// Room temperature and rise of a unit that has warmed up, degC and K (assumption).
const AMBIENT: f64 = 22.0;
const WARM_RISE: f64 = 12.0;

/// A temperature (degC) for each of `n` rows, `dt` apart. `mode` runs through warm-up from cold, hot restart, chamber
/// ramps, chamber cycles and a sine; a set of one run has a section of each, with at most `cycles_max` cycles a
/// section: rows that are a turn or a lap must resolve every cycle, or no data could identify the cause.
pub fn temperature(
    stream: &mut Stream,
    n: usize,
    dt: f64,
    mode: usize,
    one_run: bool,
    cycles_max: f64,
) -> Vec<f64> {
    let duration = n as f64 * dt;
    let warm = duration / stream.between(4.0, 7.0);
    let rise = stream.between(0.8, 1.2) * WARM_RISE;
    let swing = stream.between(3.0, 6.0) * stream.sign();
    let cycles = stream.between(2.0, 5.0).floor().min(cycles_max);
    let phase = stream.between(0.0, 1.0);
    let mode = if one_run { usize::MAX } else { mode % 5 };
    let chamber = |u: f64| match mode {
        0 => 0.0,
        1 => rise * 0.6,
        2 => rise * 0.5 + swing * triangle(cycles * u + phase),
        3 => rise * 0.5 + swing * wave(cycles * u + phase).signum(),
        4 => rise * 0.5 + swing * wave(cycles * u + phase),
        _ if u < 0.3 => 0.0,
        _ if u < 0.55 => swing * triangle(cycles * (u - 0.3) / 0.25),
        _ if u < 0.8 => swing * wave(cycles * (u - 0.55) / 0.25).signum(),
        _ => swing * wave(cycles * (u - 0.8) / 0.2),
    };
    let heats_up = matches!(mode, 0 | 1 | usize::MAX);
    let own = if mode == 1 { rise * 0.4 } else { rise };
    let air = stream.wander(n, dt, 0.15, duration / 20.0);
    let lag = duration / 60.0;
    let mut case = AMBIENT + chamber(0.0);
    (0..n)
        .map(|k| {
            let t = k as f64 * dt;
            case += (AMBIENT + chamber(t / duration) + air[k] - case) * (dt / lag).min(1.0);
            case + if heats_up { own * (1.0 - (-t / warm).exp()) } else { 0.0 }
        })
        .collect()
}

fn triangle(cycles: f64) -> f64 {
    let u = cycles.rem_euclid(1.0);
    if u < 0.5 { 4.0 * u - 1.0 } else { 3.0 - 4.0 * u }
}

/// A supply voltage (V): a 12 V supply that wanders and is loaded now and then (assumption).
pub fn supply(stream: &mut Stream, n: usize, dt: f64) -> Vec<f64> {
    const LOADS: [f64; 4] = [0.0, -0.15, -0.3, 0.1];
    let wander = stream.wander(n, dt, 0.08, n as f64 * dt / 15.0);
    let load = levels(stream, n, 8, &LOADS);
    wander.iter().zip(load).map(|(w, load)| 12.0 + w + load).collect()
}

/// A motor current (A) of a motor unrelated to the rotation (assumption).
pub fn current(stream: &mut Stream, n: usize, dt: f64) -> Vec<f64> {
    const LOADS: [f64; 4] = [0.0, 0.8, 1.5, 2.5];
    let wander = stream.wander(n, dt, 0.1, n as f64 * dt / 40.0);
    let load = levels(stream, n, 15, &LOADS);
    wander.iter().zip(load).map(|(w, load)| 0.5 + w.abs() + load).collect()
}

fn levels(stream: &mut Stream, n: usize, changes: usize, choices: &[f64]) -> Vec<f64> {
    let mut level = stream.pick(choices);
    let chance = changes as f64 / n.max(1) as f64;
    (0..n)
        .map(|_| {
            if stream.chance(chance) {
                level = stream.pick(choices);
            }
            level
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_programme_turns_both_ways_rests_and_keeps_its_ramp() {
        let rates =
            rotation(&mut Stream::new(1, "rotation", 0, "test"), 7_200, 1.0, Rotation::Table);
        assert_eq!(rates.len(), 7_200);
        assert!(rates.iter().any(|&w| w > 5.0) && rates.iter().any(|&w| w < -5.0));
        assert!(rates.iter().filter(|&&w| w == 0.0).count() > 300);
        assert!(rates.iter().all(|w| w.abs() <= 90.0));
        assert!(rates.windows(2).all(|w| (w[1] - w[0]).abs() <= RAMP + 1e-9));
    }

    #[test]
    fn temperatures_are_those_of_a_room_and_move() {
        for mode in 0..5 {
            for one_run in [false, true] {
                let t =
                    temperature(&mut Stream::new(2, "t", 0, "test"), 720, 10.0, mode, one_run, 5.0);
                let (low, high) =
                    t.iter().fold((f64::MAX, f64::MIN), |(l, h), &t| (l.min(t), h.max(t)));
                assert!(low > 10.0 && high < 50.0 && high - low > 1.0, "{mode}: {low} to {high}");
            }
        }
    }
}
