//! The truth in each row of a `series`, in the file's units: s, deg, deg/s, degC, V, A.

use super::Layout;
use crate::programme::{current, rotation, supply, temperature};
use crate::random::Stream;
use std::ops::Range;

/// The truth of each row.
pub struct Rows {
    /// Rows of each run.
    pub runs: Vec<Range<usize>>,
    /// Time between rows, s.
    pub dt: f64,
    /// Time since the first power-up, s.
    pub time: Vec<f64>,
    /// Time since the power-up of the run, s.
    pub elapsed: Vec<f64>,
    /// Rate about the sensitive axis, deg/s.
    pub rate: Vec<f64>,
    /// Rate about another axis, deg/s.
    pub cross: Vec<f64>,
    /// Unwrapped heading: the integral of a rate that is linear between rows, deg.
    pub heading: Vec<f64>,
    /// Case temperature, degC.
    pub temperature: Vec<f64>,
    /// Supply, V.
    pub supply: Vec<f64>,
    /// Motor current, A.
    pub current: Vec<f64>,
}

/// The longest pause between two runs, s (assumption).
const PAUSE: f64 = 3600.0;

impl Rows {
    /// Draws a programme.
    pub fn draw(stream: &mut Stream, layout: &Layout) -> Self {
        let (n, dt) = (layout.rows_per_run, layout.dt);
        let total = n * layout.runs;
        let empty = || Vec::with_capacity(total);
        let mut rows = Self {
            runs: (0..layout.runs).map(|run| run * n..(run + 1) * n).collect(),
            dt,
            time: empty(),
            elapsed: empty(),
            rate: empty(),
            cross: empty(),
            heading: empty(),
            temperature: empty(),
            supply: empty(),
            current: empty(),
        };
        let (mut start, shift) = (0.0, stream.below(5));
        for run in 0..layout.runs {
            rows.elapsed.extend((0..n).map(|k| k as f64 * dt));
            rows.time.extend((0..n).map(|k| start + k as f64 * dt));
            start += n as f64 * dt + (PAUSE * stream.between(0.3, 1.0)).round();
            let rate = rotation(stream, n, dt, layout.rotation);
            let mut heading = stream.between(0.0, 360.0);
            rows.heading.push(heading);
            for pair in rate.windows(2) {
                heading += (pair[0] + pair[1]) / 2.0 * dt;
                rows.heading.push(heading);
            }
            rows.rate.extend(rate);
            rows.cross.extend(rotation(stream, n, dt, layout.rotation));
            let one = layout.runs == 1;
            rows.temperature.extend(temperature(stream, n, dt, run + shift, one, f64::INFINITY));
            rows.supply.extend(supply(stream, n, dt));
            rows.current.extend(current(stream, n, dt));
        }
        rows
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.time.len()
    }

    /// A first-order lag of `x` with that time constant; it starts settled in each run.
    pub fn lag(&self, x: &[f64], tau: f64) -> Vec<f64> {
        self.filter(x, |y, x| y + (x - y) * (self.dt / tau).min(1.0))
    }

    /// The play operator (backlash) of that half width on `x`; it starts centred in each run.
    pub fn play(&self, x: &[f64], half: f64) -> Vec<f64> {
        self.filter(x, |y, x| y.clamp(x - half, x + half))
    }

    fn filter(&self, x: &[f64], next: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let mut out = Vec::with_capacity(x.len());
        for run in &self.runs {
            let mut y = x[run.start];
            for &x in &x[run.clone()] {
                y = next(y, x);
                out.push(y);
            }
        }
        out
    }

    /// The rate of change of `x`, per second, from central differences within each run.
    pub fn derivative(&self, x: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(x.len());
        for run in &self.runs {
            for k in run.clone() {
                let (a, b) = (k.saturating_sub(1).max(run.start), (k + 1).min(run.end - 1));
                out.push((x[b] - x[a]) / ((b - a).max(1) as f64 * self.dt));
            }
        }
        out
    }

    /// `x` delayed by `late(row)` seconds, linear between rows, held at the ends of a run.
    pub fn delayed(&self, x: &[f64], late: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut out = Vec::with_capacity(x.len());
        for run in &self.runs {
            for k in run.clone() {
                let last = (run.end - 1 - run.start) as f64;
                let at = ((k - run.start) as f64 - late(k) / self.dt).clamp(0.0, last);
                let (whole, part) = (at.floor() as usize, at.fract());
                let next = (whole + 1).min(run.end - 1 - run.start);
                out.push(x[run.start + whole] * (1.0 - part) + x[run.start + next] * part);
            }
        }
        out
    }
}

/// Parameters of effects that stay the same in the training and the test data: time constants and
/// the like. Each range is an assumption within the classes of published devices.
#[derive(Debug, Clone, Copy)]
pub struct Constants {
    /// Gyro bias, deg/s.
    pub bias: f64,
    /// Scale error.
    pub scale: f64,
    /// Lag of the coil's temperature behind the sensor's, s.
    pub coil: f64,
    /// Time constant of the warm-up, s.
    pub warm: f64,
    /// Half width of the thermal play, K.
    pub play: f64,
    /// Period of the periodic disturbance, s.
    pub period: f64,
    /// Phase of the disturbance and the magnetic field, rad.
    pub phase: f64,
    /// Time of the step, s.
    pub step: f64,
    /// Rows lost at each loss.
    pub lost: f64,
}

impl Constants {
    /// Draws the constants for that layout.
    pub fn draw(stream: &mut Stream, layout: &Layout) -> Self {
        let run = layout.rows_per_run as f64 * layout.dt;
        // Runs are up to an hour apart; the step falls into the middle of a run near the middle.
        let whole = run * layout.runs as f64 + 0.65 * PAUSE * (layout.runs - 1) as f64;
        Self {
            bias: stream.between(-0.01, 0.01),
            scale: stream.between(-0.003, 0.003),
            coil: run * stream.between(0.04, 0.10),
            warm: run * stream.between(0.15, 0.3),
            play: stream.between(1.0, 2.0),
            period: layout.dt * stream.between(7.0, 150.0),
            phase: stream.between(0.0, std::f64::consts::TAU),
            step: whole * stream.between(0.35, 0.65),
            lost: 2.0,
        }
    }
}
