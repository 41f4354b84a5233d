//! Whitening by the innovations of a Kalman filter: exact for irregular times, gaps and runs.
//!
//! State: the level (where observations are levels), then one for each coloured part. The gains depend on times
//! alone, so they are computed once and applied to every column.

use super::NoiseModel;
use crate::linear::{Basis, dot};
use crate::problem::{Aggregate, Block, Channels};

/// Most coloured parts.
pub const COLOURED_MAX: usize = 4;
const STATES_MAX: usize = COLOURED_MAX + 1;

/// Errors of where each run of poses began, over the observations, and the observations of each run.
type UnknownStarts = (Vec<Vec<f64>>, Vec<std::ops::Range<usize>>);

/// When observations were made: all that whitening needs to know of them.
#[derive(Debug, Clone)]
pub struct Layout {
    /// Time since the observation before, s.
    step: Vec<f64>,
    /// Activity since the observation before.
    activity: Vec<f64>,
    /// Does a new stretch begin here?
    starts: Vec<bool>,
    /// Does a new run begin here?
    new_run: Vec<bool>,
    /// Run of each observation.
    pub run: Vec<usize>,
    /// How much of a rate each observation sees: 1, or the time that a turn took.
    gain: Vec<f64>,
    /// Noise of each observation over that of the others; empty where all are alike.
    spread: Vec<f64>,
    levels: bool,
    /// Errors of the pose at the start of each run, over the observations; and the observations of each run.
    starts_of_poses: Option<UnknownStarts>,
}

impl Layout {
    /// Of the observations of `block`.
    pub fn new(block: &Block, channels: &Channels) -> Self {
        let levels = block.aggregate != Aggregate::Row;
        let mut segment_of = vec![0; channels.time.len()];
        for (index, range) in channels.segments.iter().enumerate() {
            segment_of[range.clone()].fill(index);
        }
        let n = block.rows.len();
        let mut layout = Self {
            step: vec![0.0; n],
            activity: vec![0.0; n],
            starts: vec![true; n],
            new_run: vec![true; n],
            run: block.rows.iter().map(|&row| channels.run[row]).collect(),
            gain: vec![1.0; n],
            spread: block.spread.clone(),
            levels,
            starts_of_poses: block
                .pose
                .as_ref()
                .map(|pose| (pose.start_errors().to_vec(), pose.of_run.clone())),
        };
        for i in 1..n {
            let (before, now) = (block.rows[i - 1], block.rows[i]);
            layout.new_run[i] = layout.run[i] != layout.run[i - 1];
            let other =
                block.pose.as_ref().is_some_and(|pose| pose.component[i] != pose.component[i - 1]);
            layout.starts[i] = segment_of[before] != segment_of[now]
                || now < before
                || (levels && layout.new_run[i])
                || other;
            if layout.starts[i] {
                continue;
            }
            layout.step[i] = channels.time[now] - channels.time[before];
            if let Some(activity) = &block.activity {
                layout.activity[i] = activity[before + 1..=now].iter().sum();
            }
        }
        layout
    }

    /// The same observations where each took `durations`: a coloured rate adds up over the time, and where `white`
    /// too, white noise of the rate does (an angle random walk).
    pub fn over(&self, durations: &[f64], white: bool) -> Self {
        let mean = durations.iter().sum::<f64>() / durations.len().max(1) as f64;
        let mut layout = self.clone();
        layout.gain = durations.iter().map(|duration| duration / mean).collect();
        if white {
            let own = |i: usize| self.spread.get(i).copied().unwrap_or(1.0);
            layout.spread = (0..self.len()).map(|i| own(i) * layout.gain[i].abs().sqrt()).collect();
        }
        layout
    }

    /// How many observations there are.
    pub fn len(&self) -> usize {
        self.step.len()
    }

    /// Whether observations are levels.
    pub fn is_level(&self) -> bool {
        self.levels
    }

    /// Typical time from one observation to the next.
    pub fn interval(&self) -> f64 {
        let mut steps: Vec<f64> = self
            .step
            .iter()
            .zip(&self.starts)
            .filter(|(_, s)| !**s)
            .map(|(step, _)| *step)
            .collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0).unwrap_or(1.0)
    }

    /// Longest stretch of time.
    pub fn span(&self) -> f64 {
        let (mut longest, mut now): (f64, f64) = (0.0, 0.0);
        for (step, starts) in self.step.iter().zip(&self.starts) {
            now = if *starts { 0.0 } else { now + step };
            longest = longest.max(now);
        }
        longest
    }

    /// Typical activity from one observation to the next.
    pub fn mean_activity(&self) -> f64 {
        self.activity.iter().sum::<f64>() / self.activity.len().max(1) as f64
    }

    /// Every `block` observations as one, their mean. Only for observations that are of rows.
    pub fn thinned(&self, block: usize) -> (Self, Vec<std::ops::Range<usize>>) {
        let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
        for i in 0..self.len() {
            match groups.last_mut() {
                Some(last) if last.len() < block && !self.starts[i] && !self.new_run[i] => {
                    last.end = i + 1
                }
                _ => groups.push(i..i + 1),
            }
        }
        let middle = |range: &std::ops::Range<usize>| (range.start + range.end - 1) / 2;
        let mut thin = Self {
            step: Vec::new(),
            activity: Vec::new(),
            starts: Vec::new(),
            new_run: Vec::new(),
            run: Vec::new(),
            gain: Vec::new(),
            spread: Vec::new(),
            levels: self.levels,
            starts_of_poses: None,
        };
        let mut before = 0;
        for range in &groups {
            let now = middle(range);
            thin.step.push(self.step[before + 1..=now.max(before)].iter().sum());
            thin.activity.push(0.0);
            thin.starts.push(self.starts[range.start]);
            thin.new_run.push(self.new_run[range.start]);
            thin.run.push(self.run[range.start]);
            thin.gain.push(self.gain[range.clone()].iter().sum::<f64>() / range.len() as f64);
            before = now;
        }
        (thin, groups)
    }

    /// The observations of `range` alone.
    pub fn part(&self, range: std::ops::Range<usize>) -> Self {
        let mut part = Self {
            step: self.step[range.clone()].to_vec(),
            activity: self.activity[range.clone()].to_vec(),
            starts: self.starts[range.clone()].to_vec(),
            new_run: self.new_run[range.clone()].to_vec(),
            run: self.run[range.clone()].to_vec(),
            gain: self.gain[range.clone()].to_vec(),
            spread: self.spread.get(range).map_or_else(Vec::new, <[f64]>::to_vec),
            levels: self.levels,
            starts_of_poses: None,
        };
        if let Some(first) = part.starts.first_mut() {
            *first = true;
        }
        part
    }

    /// How many runs there are.
    pub fn runs(&self) -> usize {
        self.run.iter().max().map_or(0, |last| last + 1)
    }
}

/// Turns columns of observations into columns of independent ones.
#[derive(Debug, Clone)]
pub struct Whitener {
    states: usize,
    levels: bool,
    /// For each observation: does the state start anew, what each state keeps, the gains, one over the standard
    /// deviation of the innovation (0 where it is not used).
    starts: Vec<bool>,
    keeps: Vec<[f64; STATES_MAX]>,
    gains: Vec<[f64; STATES_MAX]>,
    step: Vec<f64>,
    seen: Vec<f64>,
    weight: Vec<f64>,
    /// Sum of the logarithms of the innovations' variances.
    pub log_determinant: f64,
    plain: bool,
    /// For each run of poses: its observations, and what errors of its start look like, whitened and orthonormal.
    unknown_starts: Vec<(std::ops::Range<usize>, Vec<Vec<f64>>)>,
}

/// Variance of what is not known at all, over that of the white noise.
const DIFFUSE: f64 = 1e8;

impl Whitener {
    /// For observations as in `layout` under `noise`. Those that are `left_out` get no weight.
    pub fn new(layout: &Layout, noise: &NoiseModel, left_out: &[bool]) -> Self {
        let n = layout.len();
        let levels = layout.is_level();
        let offset = usize::from(levels);
        let m = noise.coloured.len().min(COLOURED_MAX);
        let states = m + offset;
        let plain = states == 0;
        let mut whitener = Self {
            states,
            levels,
            starts: layout.starts.clone(),
            keeps: Vec::with_capacity(if plain { 0 } else { n }),
            gains: Vec::with_capacity(if plain { 0 } else { n }),
            step: layout.step.clone(),
            seen: layout.gain.clone(),
            weight: Vec::with_capacity(n),
            log_determinant: 0.0,
            plain,
            unknown_starts: Vec::new(),
        };
        let mut p = [[0.0; STATES_MAX]; STATES_MAX];
        for i in 0..n {
            let scale = noise.run_scale.get(layout.run[i]).copied().unwrap_or(1.0);
            let own = layout.spread.get(i).copied().unwrap_or(1.0);
            let skip = left_out.get(i).copied().unwrap_or(false) || !own.is_finite();
            if plain {
                whitener.weight.push(if skip { 0.0 } else { 1.0 / (scale * own) });
                whitener.log_determinant += if skip { 0.0 } else { 2.0 * (scale * own).ln() };
                continue;
            }
            let mut keep = [0.0; STATES_MAX];
            if layout.starts[i] {
                p = [[0.0; STATES_MAX]; STATES_MAX];
                if levels && layout.starts_of_poses.is_none() {
                    p[0][0] = DIFFUSE * noise.white.max(noise.walk);
                }
                for (k, part) in noise.coloured.iter().take(m).enumerate() {
                    p[k + offset][k + offset] = part.variance;
                }
            } else {
                let step = layout.step[i];
                if levels {
                    keep[0] = 1.0;
                }
                for (k, part) in noise.coloured.iter().take(m).enumerate() {
                    keep[k + offset] = if part.correlation_s.is_finite() {
                        (-step / part.correlation_s).exp()
                    } else {
                        f64::from(u8::from(!layout.new_run[i]))
                    };
                }
                predict(&mut p, &keep, step, states, levels);
                if levels {
                    p[0][0] += noise.walk * layout.activity[i] * own * own;
                }
                for (k, part) in noise.coloured.iter().take(m).enumerate() {
                    p[k + offset][k + offset] +=
                        part.variance * (1.0 - keep[k + offset] * keep[k + offset]);
                }
            }
            // What an observation sees: the level, or the sum of the coloured parts.
            let mut h = [0.0; STATES_MAX];
            if levels {
                h[0] = 1.0;
            } else {
                h[..states].fill(layout.gain[i]);
            }
            let mut ph = [0.0; STATES_MAX];
            let mut s = if skip { 1.0 } else { noise.white * own * own };
            for a in 0..states {
                for b in 0..states {
                    ph[a] += p[a][b] * h[b];
                }
                s += h[a] * ph[a];
            }
            let mut gain = [0.0; STATES_MAX];
            if skip || !(s > 0.0) {
                whitener.weight.push(0.0);
            } else {
                for a in 0..states {
                    gain[a] = ph[a] / s;
                }
                for a in 0..states {
                    for b in 0..states {
                        p[a][b] -= gain[a] * ph[b];
                    }
                }
                whitener.weight.push(1.0 / (s.sqrt() * scale));
                whitener.log_determinant += s.ln() + 2.0 * scale.ln();
            }
            whitener.keeps.push(keep);
            whitener.gains.push(gain);
        }
        if let Some((columns, runs)) = &layout.starts_of_poses {
            let white: Vec<Vec<f64>> =
                columns.iter().map(|column| whitener.innovations(column)).collect();
            whitener.unknown_starts = runs
                .iter()
                .map(|range| {
                    let mine = white.iter().map(|column| column[range.clone()].to_vec()).collect();
                    (range.clone(), Basis::default().beyond(mine).into_columns())
                })
                .collect();
        }
        whitener
    }

    /// The whitened column, without what an error of where a run began could be.
    pub fn apply(&self, column: &[f64]) -> Vec<f64> {
        let mut whitened = self.innovations(column);
        for (range, directions) in &self.unknown_starts {
            let mine = &mut whitened[range.clone()];
            for direction in directions {
                let share = dot(direction, mine);
                for (value, other) in mine.iter_mut().zip(direction) {
                    *value -= share * other;
                }
            }
        }
        whitened
    }

    fn innovations(&self, column: &[f64]) -> Vec<f64> {
        let mut whitened = Vec::with_capacity(column.len());
        if self.plain {
            whitened.extend(column.iter().zip(&self.weight).map(|(value, weight)| value * weight));
            return whitened;
        }
        let mut state = [0.0; STATES_MAX];
        let states = self.states;
        for (i, value) in column.iter().enumerate() {
            if self.starts[i] {
                state = [0.0; STATES_MAX];
            } else {
                if self.levels {
                    let rate: f64 = state[1..states].iter().sum();
                    state[0] += self.step[i] * rate;
                }
                let first = usize::from(self.levels);
                for a in first..states {
                    state[a] *= self.keeps[i][a];
                }
            }
            let expected = if self.levels {
                state[0]
            } else {
                self.seen[i] * state[..states].iter().sum::<f64>()
            };
            let innovation = value - expected;
            for a in 0..states {
                state[a] += self.gains[i][a] * innovation;
            }
            whitened.push(innovation * self.weight[i]);
        }
        whitened
    }

    /// How many observations have a weight.
    pub fn used(&self) -> usize {
        let unknown: usize =
            self.unknown_starts.iter().map(|(_, directions)| directions.len()).sum();
        self.weight.iter().filter(|weight| **weight > 0.0).count().saturating_sub(unknown)
    }
}

/// `p` to `F p F'`: each coloured part decays; the level takes up their sum times the step.
fn predict(
    p: &mut [[f64; STATES_MAX]; STATES_MAX],
    keep: &[f64; STATES_MAX],
    step: f64,
    states: usize,
    levels: bool,
) {
    let mut f = [[0.0; STATES_MAX]; STATES_MAX];
    for a in 0..states {
        f[a][a] = keep[a];
        if levels && a > 0 {
            f[0][a] = step;
        }
    }
    let mut fp = [[0.0; STATES_MAX]; STATES_MAX];
    for a in 0..states {
        for b in 0..states {
            fp[a][b] = f[a][a] * p[a][b];
            if levels && a == 0 {
                for c in 1..states {
                    fp[0][b] += f[0][c] * p[c][b];
                }
            }
        }
    }
    for a in 0..states {
        for b in 0..states {
            p[a][b] = fp[a][b] * f[b][b];
            if levels && b == 0 {
                for c in 1..states {
                    p[a][0] += fp[a][c] * f[0][c];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Layout, Whitener};
    use crate::noise::{Coloured, NoiseModel};

    fn layout(n: usize, levels: bool) -> Layout {
        Layout {
            step: vec![1.0; n],
            activity: vec![1.0; n],
            starts: (0..n).map(|i| i == 0).collect(),
            new_run: (0..n).map(|i| i == 0).collect(),
            run: vec![0; n],
            gain: vec![1.0; n],
            spread: Vec::new(),
            levels,
            starts_of_poses: None,
        }
    }

    /// Whitening an impulse at each place gives a matrix W with W'W the inverse of the covariance.
    #[test]
    fn whitened_impulses_are_the_inverse_of_the_covariance() {
        let n = 12;
        let noise = NoiseModel {
            white: 1.0,
            walk: 0.0,
            coloured: vec![
                Coloured { correlation_s: 3.0, variance: 2.0 },
                Coloured { correlation_s: f64::INFINITY, variance: 0.5 },
            ],
            run_scale: vec![1.5],
        };
        let whitener = Whitener::new(&layout(n, false), &noise, &[]);
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                whitener.apply(&(0..n).map(|k| f64::from(u8::from(i == k))).collect::<Vec<_>>())
            })
            .collect();
        let covariance = |a: usize, b: usize| {
            let lag = a.abs_diff(b) as f64;
            1.5 * 1.5 * (f64::from(u8::from(a == b)) + 2.0 * (-lag / 3.0).exp() + 0.5)
        };
        for a in 0..n {
            for b in 0..n {
                let product: f64 = (0..n)
                    .map(|k| {
                        let inverse: f64 = (0..n).map(|i| columns[a][i] * columns[k][i]).sum();
                        inverse * covariance(k, b)
                    })
                    .sum();
                assert!((product - f64::from(u8::from(a == b))).abs() < 1e-9, "{a} {b} {product}");
            }
        }
    }

    #[test]
    fn a_constant_on_a_level_costs_one_observation() {
        let noise =
            NoiseModel { white: 1.0, walk: 0.1, coloured: Vec::new(), run_scale: vec![1.0] };
        let whitener = Whitener::new(&layout(50, true), &noise, &[]);
        let whitened = whitener.apply(&[5.0; 50]);
        assert!(whitened.iter().map(|value| value * value).sum::<f64>() < 1e-3);
    }
}
