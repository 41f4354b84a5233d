//! Bias instability: flicker noise of the rate, 1/f (IEEE Std 952-1997, annex C).
//!
//! Flicker noise has no finite set of states. Within a band of frequencies it is the sum of first-order Gauss-Markov
//! processes of equal variance whose correlation times are evenly spaced on a logarithmic scale (M. S. Keshner, "1/f
//! noise", Proc. IEEE 70 (1982) 212-218). With the variance s^2 spread over correlation times from `shortest` to
//! `longest`, L = ln(longest / shortest), the two-sided density well within the band is s^2 / (2 L f). The standard
//! writes it B^2 / (2 pi f), so that
//!
//! B = s sqrt(pi / L), and the Allan deviation is flat at B sqrt(2 ln 2 / pi) = 0.664 B.
//!
//! Two errors, for four decades. With three processes per decade the Allan deviation is within 0.4 % of that of evenly
//! spread correlation times (0.2 % from 3 times `shortest` to 0.3 times `longest`). The band has ends: the Allan
//! deviation is within 5 % of the flat value from 14 times `shortest` to a fifth of `longest`, and lower beyond.

use super::parameters::{GyroParameters, remainder};
use crate::random::RandomStream;
use libm::{exp, log, round, sqrt};
use std::f64::consts::LN_10;
use wire::units::Angle;

/// Number of processes per decade of correlation times.
///
/// Neighbours at a ratio r ripple the density by 2 sech(pi^2 / ln r): 5.5 % with one per decade, 1e-5 with three. The
/// remaining error comes from the ends, half a part of the band each.
const PROCESSES_PER_DECADE: f64 = 3.0;

/// Maximum number of processes: bands of more than twelve decades have a wider spacing.
const PROCESSES_MAX: usize = 36;

/// One first-order Gauss-Markov process of unit variance.
#[derive(Debug, Clone, Copy, Default)]
struct Process {
    state: f64,
    /// e^(-step / correlation time).
    decay: f64,
    /// Keeps the variance at one.
    drive: f64,
}

/// The sum of the processes, advanced from second to second.
///
/// At the seconds its variance and correlations are exactly those of the continuous processes. It starts in its steady
/// distribution. Between two seconds it is linear, which removes (1 - e^(-1 s / correlation time)) / 3 of a process's
/// mean square: with correlation times from 1 s to 10,000 s this is 2.8 % of the sum's, all of it noise faster than a
/// few seconds.
#[derive(Debug, Clone)]
pub(super) struct BiasInstability {
    stream: RandomStream,
    processes: [Process; PROCESSES_MAX],
    count: usize,
    /// rad/s
    rms: f64,
    /// The processes' sum, scaled to unit variance, at the start and at the end of the second.
    levels: (f64, f64),
}

impl BiasInstability {
    /// The bias instability of `device` in a run with `seed`, stepped by `step_s`.
    pub(super) fn new(parameters: &GyroParameters, step_s: f64, seed: u64, device: &str) -> Self {
        let mut stream = RandomStream::new(seed, device, "gyro bias instability");
        let mut processes = [Process::default(); PROCESSES_MAX];
        for process in &mut processes {
            process.state = stream.standard_normal();
        }
        let mut bank = Self { stream, processes, count: 0, rms: 0.0, levels: (0.0, 0.0) };
        bank.configure(parameters, step_s);
        bank.levels = (bank.level(), bank.level());
        bank
    }

    /// Applies changed parameters or another step; the current state stays.
    pub(super) fn configure(&mut self, parameters: &GyroParameters, step_s: f64) {
        let times = CorrelationTimes::of(parameters);
        self.count = times.count;
        self.rms = Angle::from_deg(parameters.bias_instability_rms_deg_per_s).rad();
        for (process, time_s) in self.processes.iter_mut().zip(times.seconds()) {
            process.decay = remainder(step_s, time_s);
            process.drive = sqrt(1.0 - process.decay * process.decay);
        }
    }

    pub(super) fn advance(&mut self) {
        if self.rms == 0.0 {
            return;
        }
        for process in &mut self.processes[..self.count] {
            process.state =
                process.decay * process.state + process.drive * self.stream.standard_normal();
        }
        self.levels = (self.levels.1, self.level());
    }

    /// The bias in rad/s after `share` of the second.
    pub(super) fn at(&self, share: f64) -> f64 {
        let (start, end) = self.levels;
        self.rms * (start + (end - start) * share)
    }

    fn level(&self) -> f64 {
        let sum: f64 = self.processes[..self.count].iter().map(|process| process.state).sum();
        sum / sqrt(self.count as f64)
    }
}

/// The correlation times: the middles of equal parts of the band, on a logarithmic scale. The order of its ends does
/// not matter.
#[derive(Debug, Clone, Copy)]
struct CorrelationTimes {
    log_shortest: f64,
    log_ratio: f64,
    count: usize,
}

impl CorrelationTimes {
    fn of(parameters: &GyroParameters) -> Self {
        let log_shortest = log(parameters.bias_instability_shortest_s);
        let log_ratio = log(parameters.bias_instability_longest_s) - log_shortest;
        // The conversion saturates.
        let wanted = round(PROCESSES_PER_DECADE * log_ratio.abs() / LN_10) as usize;
        Self { log_shortest, log_ratio, count: wanted.clamp(1, PROCESSES_MAX) }
    }

    fn seconds(self) -> impl Iterator<Item = f64> {
        (0..self.count).map(move |index| {
            let middle = (index as f64 + 0.5) / self.count as f64;
            exp(self.log_shortest + self.log_ratio * middle)
        })
    }
}

#[cfg(test)]
mod tests;
