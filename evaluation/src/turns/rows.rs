//! Turns of a table, or laps of a robot with a gyro on board: the truth in each, in the file's units.

use crate::programme::{current, supply, temperature};
use crate::random::Stream;
use std::ops::Range;

/// Path of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// Turns of a rotary table, clockwise then counter-clockwise in each run.
    Table,
    /// Laps of a closed path, one a run.
    Laps,
}

/// The truth of each turn or lap.
pub struct Rows {
    /// Rows of each run.
    pub runs: Vec<Range<usize>>,
    /// Middle of the turn since power-up, s.
    pub time: Vec<f64>,
    /// +1 counter-clockwise, -1 clockwise.
    pub direction: Vec<f64>,
    /// Rate of the turning, signed, deg/s.
    pub rate: Vec<f64>,
    /// Integral of the squared rate over the turn, with its ramps, (deg/s)^2 s.
    pub rate_squared: Vec<f64>,
    /// Integration time of the gyro, s.
    pub duration: Vec<f64>,
    /// Angle turned, signed, deg.
    pub angle: Vec<f64>,
    /// Case temperature, degC, and its rate of change, K/s.
    pub temperature: Vec<f64>,
    /// See `temperature`.
    pub warming: Vec<f64>,
    /// A lagged temperature, degC.
    pub coil: Vec<f64>,
    /// Temperature through a play operator, degC.
    pub played: Vec<f64>,
    /// Supply, V.
    pub supply: Vec<f64>,
    /// Motor current, A.
    pub current: Vec<f64>,
}

/// Parameters that stay the same in training and test data.
#[derive(Debug, Clone, Copy)]
pub struct Constants {
    /// Gyro bias left after the static test, deg/s.
    pub bias: f64,
    /// Scale error.
    pub scale: f64,
    /// Lag of the coil, s.
    pub coil: f64,
    /// Half width of the play, K.
    pub play: f64,
    /// Time constant of warming up, s.
    pub warm: f64,
    /// Time of the step, s.
    pub step: f64,
}

/// Rates of the turns, deg/s: a ladder within the range of the paper's gyro.
const LADDER: [f64; 6] = [5.0, 10.0, 20.0, 30.0, 45.0, 60.0];
/// Ramp at each end of a turn, s (assumption). Both together add its length to the duration.
const RAMP: f64 = 4.0;
/// Travel of a lap at the paper's speed, s, and its share of slower laps' extra.
const LAP: f64 = 64.0;
/// Static test and pause between runs, s.
const TABLE_PERIOD: f64 = 150.0;
const LAP_PERIOD: f64 = 600.0;
/// Step of the dense grid on which temperatures evolve, s.
const GRID: f64 = 10.0;
/// Actual closure error of a lap, deg (assumption, after the paper's laps).
const CLOSURE: f64 = 2.0;

impl Constants {
    /// Draws the constants for that many seconds.
    pub fn draw(stream: &mut Stream, duration: f64) -> Self {
        Self {
            bias: stream.between(-0.002, 0.002),
            scale: stream.between(-0.003, 0.003),
            coil: duration * stream.between(0.02, 0.06),
            play: stream.between(1.0, 2.0),
            warm: duration * stream.between(0.1, 0.2),
            step: duration * stream.between(0.35, 0.65),
        }
    }
}

impl Rows {
    /// Duration of `runs` runs, s.
    pub fn length(path: Path, runs: usize) -> f64 {
        let period = if path == Path::Table { TABLE_PERIOD } else { LAP_PERIOD };
        period * runs as f64
    }

    /// Draws a programme of `runs` runs.
    pub fn draw(stream: &mut Stream, path: Path, runs: usize, constants: &Constants) -> Self {
        let length = Self::length(path, runs);
        let period = length / runs as f64;
        let n = (length / GRID) as usize + 1;
        let warmth =
            temperature(stream, n, GRID, 0, true, if path == Path::Table { 2.0 } else { 1.0 });
        let volts = supply(stream, n, GRID);
        let amps = current(stream, n, GRID);
        let (mut coil, mut played) = (vec![warmth[0]; n], vec![warmth[0]; n]);
        for k in 1..n {
            coil[k] = coil[k - 1] + (warmth[k] - coil[k - 1]) * (GRID / constants.coil).min(1.0);
            played[k] = played[k - 1].clamp(warmth[k] - constants.play, warmth[k] + constants.play);
        }
        let mut rows = Self {
            runs: Vec::new(),
            time: Vec::new(),
            direction: Vec::new(),
            rate: Vec::new(),
            rate_squared: Vec::new(),
            duration: Vec::new(),
            angle: Vec::new(),
            temperature: Vec::new(),
            warming: Vec::new(),
            coil: Vec::new(),
            played: Vec::new(),
            supply: Vec::new(),
            current: Vec::new(),
        };
        for run in 0..runs {
            let first = rows.time.len();
            let rate =
                if path == Path::Table { stream.pick(&LADDER) } else { stream.between(15.0, 30.0) };
            let lap = [-stream.sign()];
            let directions: &[f64] = if path == Path::Table { &[-1.0, 1.0] } else { &lap };
            let mut at = run as f64 * period + stream.between(20.0, 30.0);
            for &direction in directions {
                let (angle, duration) = match path {
                    Path::Table => (360.0 * direction, 360.0 / rate + RAMP),
                    Path::Laps => (
                        360.0 * direction + CLOSURE * stream.normal(),
                        LAP * stream.between(1.0, 1.8),
                    ),
                };
                let middle = at + duration / 2.0;
                at += duration;
                let k = ((middle / GRID) as usize).clamp(1, n - 2);
                rows.time.push(middle);
                rows.direction.push(direction);
                rows.rate.push(direction * rate);
                // A ramp of linear rate holds half the angle of a plateau, and a third of the square.
                rows.rate_squared.push(rate * (angle.abs() - rate * RAMP / 3.0));
                rows.duration.push(duration);
                rows.angle.push(angle);
                rows.temperature.push(warmth[k]);
                rows.warming.push((warmth[k + 1] - warmth[k - 1]) / (2.0 * GRID));
                rows.coil.push(coil[k]);
                rows.played.push(played[k]);
                rows.supply.push(volts[k]);
                rows.current.push(amps[k]);
            }
            rows.runs.push(first..rows.time.len());
        }
        rows
    }
}
