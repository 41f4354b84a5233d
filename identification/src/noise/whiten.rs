//! Whitening by the innovations of a Kalman filter: exact for irregular times, gaps and runs.
//!
//! State: the level (if observations are levels), then one for each coloured part. The gains depend on times alone, so
//! they are computed once and applied to every column.

use super::innovations::{Filter, Gains, Inputs, Last, STATES_MAX, Several, has_settled};
use super::pose_filter::PoseFilter;
use super::poses::UnknownStart;
use super::{Layout, NoiseModel};
use crate::linear::dot;
use std::rc::Rc;

/// Maximum number of coloured parts.
pub const COLOURED_MAX: usize = STATES_MAX - 1;

/// Whitens columns: turns correlated observations into independent ones.
#[derive(Debug, Clone)]
pub struct Whitener {
    filter: Filter,
    /// In place of `filter`, which then has the weights alone.
    poses: Option<Rc<PoseFilter>>,
    /// Sum of the logarithms of the innovations' variances.
    pub log_determinant: f64,
    /// Of poses.
    unknown_starts: Rc<[UnknownStart]>,
}

/// Variance of an unknown state, over that of the white noise.
const DIFFUSE: f64 = 1e8;

impl Whitener {
    /// A whitener for observations as in `layout` under `noise`.
    pub fn new(layout: &Layout, noise: &NoiseModel) -> Self {
        if let (Some(poses), Some(_)) = (&layout.poses, noise.slide) {
            let new = || PoseFilter::new(poses, (&layout.run, &layout.spread), noise);
            return Self::of_poses(layout.latest.filter(noise, new));
        }
        let states = noise.coloured.len().min(COLOURED_MAX) + usize::from(layout.is_level());
        let mut whitener = match states {
            0 => return Self::weighed(layout, noise),
            1 => Self::filtering::<1>(layout, noise),
            2 => Self::filtering::<2>(layout, noise),
            3 => Self::filtering::<3>(layout, noise),
            4 => Self::filtering::<4>(layout, noise),
            _ => Self::filtering::<STATES_MAX>(layout, noise),
        };
        if let Some(poses) = &layout.poses {
            whitener.unknown_starts =
                poses.unknown_starts(&whitener.innovations(&poses.start_errors));
        }
        whitener
    }

    /// A whitener with that many states.
    fn filtering<const S: usize>(layout: &Layout, noise: &NoiseModel) -> Self {
        let n = layout.len();
        let levels = layout.is_level();
        let offset = usize::from(levels);
        let (starts, seen) = (layout.starts.clone(), layout.gain.clone());
        let step = layout.step.clone();
        let mut filter = Filter { states: S, levels, starts, seen, step, ..Filter::default() };
        filter.weight.reserve_exact(n);
        filter.which.reserve_exact(n);
        let mut log_determinant = Logarithms::default();
        // Logarithms per run: there are fewer runs than observations.
        let log_scales: Vec<f64> = noise.run_scale.iter().map(|scale| 2.0 * scale.ln()).collect();
        let mut last = Last::default();
        let mut p = [[0.0; S]; S];
        // Most observations come as long after the one before as that after its own.
        let (mut kept_over, mut kept) = (f64::NAN, [0.0; S]);
        for i in 0..n {
            let scale = noise.run_scale.get(layout.run[i]).copied().unwrap_or(1.0);
            let log_scale = log_scales.get(layout.run[i]).copied().unwrap_or(0.0);
            let own = layout.spread.get(i).copied().unwrap_or(1.0);
            let skip = noise.leaves_out(i) || !own.is_finite();
            let inputs = Inputs {
                step: layout.step[i],
                activity: layout.activity[i],
                seen: layout.gain[i],
                own,
                new_run: layout.new_run[i],
            };
            let varies = skip || layout.starts[i];
            if !varies && last.repeats(&inputs) {
                filter.weight.push(last.weight / scale);
                filter.which.push(last.which);
                log_determinant.sum += last.log_variance + log_scale;
                continue;
            }
            let before = p;
            let mut keep = [0.0; S];
            if layout.starts[i] {
                p = [[0.0; S]; S];
                if levels && layout.poses.is_none() {
                    p[0][0] = DIFFUSE * noise.white.max(noise.walk);
                }
                for (k, part) in (offset..S).zip(&noise.coloured) {
                    p[k][k] = part.variance;
                }
            } else {
                let step = layout.step[i];
                if step != kept_over {
                    for (k, part) in (offset..S).zip(&noise.coloured) {
                        kept[k] = (-step / part.correlation_s).exp();
                    }
                    kept_over = step;
                }
                keep = kept;
                if levels {
                    keep[0] = 1.0;
                }
                for (k, part) in (offset..S).zip(&noise.coloured) {
                    if !part.correlation_s.is_finite() {
                        keep[k] = f64::from(u8::from(!layout.new_run[i]));
                    }
                }
                predict(&mut p, &keep, step, levels);
                if levels {
                    p[0][0] += noise.walk * layout.activity[i] * own * own;
                }
                for (k, part) in (offset..S).zip(&noise.coloured) {
                    p[k][k] += part.variance * (1.0 - keep[k] * keep[k]);
                }
            }
            // What an observation measures: the level, or the sum of the coloured parts.
            let mut h = [layout.gain[i]; S];
            if levels {
                h = [0.0; S];
                h[0] = 1.0;
            }
            let mut ph = [0.0; S];
            let mut s = if skip { 1.0 } else { noise.white * own * own };
            for a in 0..S {
                for b in 0..S {
                    ph[a] += p[a][b] * h[b];
                }
                s += h[a] * ph[a];
            }
            let mut gain = [0.0; S];
            if skip || !(s > 0.0) {
                filter.weight.push(0.0);
            } else {
                for a in 0..S {
                    gain[a] = ph[a] / s;
                }
                for a in 0..S {
                    for b in 0..S {
                        p[a][b] -= gain[a] * ph[b];
                    }
                }
                filter.weight.push(1.0 / (s.sqrt() * scale));
                log_determinant.add(s);
                log_determinant.sum += log_scale;
            }
            let which = filter.push(Gains::of(keep, gain));
            let is_settled =
                !varies && s > 0.0 && last.is_like(&inputs) && has_settled(&before, &p);
            let log_variance = if is_settled { s.ln() } else { f64::NAN };
            let (inputs, weight) = (Some(inputs), 1.0 / s.sqrt());
            last = Last { inputs, which, weight, log_variance, is_settled };
        }
        let log_determinant = log_determinant.total();
        Self { filter, poses: None, log_determinant, unknown_starts: Rc::default() }
    }

    /// A whitener for white noise, which does not depend on the past.
    fn weighed(layout: &Layout, noise: &NoiseModel) -> Self {
        let (mut filter, mut log_determinant) = (Filter::default(), 0.0);
        // Most observations are as spread as the one before.
        let (mut spread, mut log_spread) = (1.0, 0.0);
        for i in 0..layout.len() {
            let scale = noise.run_scale.get(layout.run[i]).copied().unwrap_or(1.0);
            let own = layout.spread.get(i).copied().unwrap_or(1.0);
            if noise.leaves_out(i) || !own.is_finite() {
                filter.weight.push(0.0);
                continue;
            }
            filter.weight.push(1.0 / (scale * own));
            if scale * own != spread {
                spread = scale * own;
                log_spread = 2.0 * spread.ln();
            }
            log_determinant += log_spread;
        }
        Self { filter, poses: None, log_determinant, unknown_starts: Rc::default() }
    }

    fn of_poses(filter: Rc<PoseFilter>) -> Self {
        Self {
            log_determinant: filter.log_determinant,
            filter: Filter { weight: filter.weight.clone(), ..Filter::default() },
            unknown_starts: Rc::clone(&filter.unknown_starts),
            poses: Some(filter),
        }
    }

    fn innovations<C: AsRef<[f64]>>(&self, columns: &[C]) -> Vec<Vec<f64>> {
        match &self.poses {
            Some(poses) => poses.each(columns),
            None => self.filter.innovations(columns),
        }
    }

    /// Whether each whitened value is a weighted copy of the original value.
    pub fn is_by_row(&self) -> bool {
        self.filter.states == 0 && self.unknown_starts.is_empty()
    }

    /// Whitens a column and removes the part that errors of a run's start could cause.
    pub fn apply(&self, column: &[f64]) -> Vec<f64> {
        let mut whitened = self.innovations(&[column]);
        self.forget_starts(&mut whitened);
        whitened.swap_remove(0)
    }

    /// The same for many columns at once, owned or borrowed.
    pub fn apply_all<C: AsRef<[f64]>>(&self, columns: &[C]) -> Vec<Vec<f64>> {
        let mut whitened = self.innovations(columns);
        self.forget_starts(&mut whitened);
        whitened
    }

    fn forget_starts(&self, columns: &mut [Vec<f64>]) {
        for column in columns {
            for (range, directions) in &*self.unknown_starts {
                let mine = &mut column[range.clone()];
                for direction in directions {
                    let share = dot(direction, mine);
                    for (value, other) in mine.iter_mut().zip(direction) {
                        *value -= share * other;
                    }
                }
            }
        }
    }

    /// One over the standard deviation of each innovation; 0 for an unused observation.
    pub fn weights(&self) -> &[f64] {
        &self.filter.weight
    }

    /// Logarithm of the likelihood of observations of which this sum of squares is left, with the scale of the noise at its
    /// best value.
    pub fn log_likelihood(&self, square: f64) -> f64 {
        let n = self.used() as f64;
        -0.5 * (n * (square.max(f64::MIN_POSITIVE) / n).ln() + self.log_determinant)
    }

    /// Number of observations with a weight.
    pub fn used(&self) -> usize {
        let unknown: usize =
            self.unknown_starts.iter().map(|(_, directions)| directions.len()).sum();
        self.filter.weight.iter().filter(|weight| **weight > 0.0).count().saturating_sub(unknown)
    }
}

/// A sum of logarithms, that of a product of several at a time.
struct Logarithms {
    sum: f64,
    product: f64,
}

impl Default for Logarithms {
    fn default() -> Self {
        Self { sum: 0.0, product: 1.0 }
    }
}

impl Logarithms {
    fn add(&mut self, value: f64) {
        /// Within it the product with a value in it is no less exact.
        const RANGE: std::ops::Range<f64> = 1e-140..1e140;
        if !RANGE.contains(&value) {
            self.sum += value.ln();
            return;
        }
        self.product *= value;
        if !RANGE.contains(&self.product) {
            self.sum += self.product.ln();
            self.product = 1.0;
        }
    }

    fn total(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

/// Propagates `p` to `F p F'`: each coloured part decays; the level adds their sum times the step.
fn predict<const S: usize>(p: &mut [[f64; S]; S], keep: &[f64; S], step: f64, levels: bool) {
    if levels {
        // `F p`, then `(F p) F'`: the level first, from the values of the others before.
        for b in 0..S {
            let others: f64 = (1..S).map(|c| step * p[c][b]).sum();
            p[0][b] += others;
        }
        for a in 0..S {
            let others: f64 = (1..S).map(|c| step * p[a][c]).sum();
            p[a][0] += others;
        }
    }
    for a in 0..S {
        for b in 0..S {
            p[a][b] *= keep[a] * keep[b];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Layout, Whitener};
    use crate::noise::{Coloured, NoiseModel};

    fn layout(n: usize, levels: bool) -> Layout {
        Layout { levels, activity: vec![1.0; n], ..Layout::of_rows(1, n, 1.0) }
    }

    /// Whitening an impulse at each place gives a matrix W with W'W the inverse of the covariance.
    #[test]
    fn whitened_impulses_are_the_inverse_of_the_covariance() {
        let n = 12;
        let noise = NoiseModel {
            white: 1.0,
            walk: 0.0,
            slide: None,
            coloured: vec![
                Coloured { correlation_s: 3.0, variance: 2.0 },
                Coloured { correlation_s: f64::INFINITY, variance: 0.5 },
            ],
            run_scale: vec![1.5],
            left_out: Vec::new(),
        };
        let whitener = Whitener::new(&layout(n, false), &noise);
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

    /// Shared gains after settling equal those computed for each observation.
    #[test]
    fn settled_gains_are_the_gains() {
        let n = 4000;
        let noise = NoiseModel {
            white: 1.0,
            walk: 0.0,
            slide: None,
            coloured: vec![Coloured { correlation_s: 30.0, variance: 0.3 }],
            run_scale: vec![1.0],
            left_out: (0..n).map(|i| i == 2500).collect(),
        };
        let even = layout(n, false);
        // Steps that differ by more than rounding share nothing.
        let mut uneven = even.clone();
        uneven.step = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { 1.0 + 1e-8 }).collect();
        let column: Vec<f64> = (0..n).map(|i| (i as f64 * 0.37).sin()).collect();
        let shared = Whitener::new(&even, &noise);
        let own = Whitener::new(&uneven, &noise);
        assert!(shared.filter.gains.len() < 1000 && own.filter.gains.len() == n);
        for (a, b) in shared.apply(&column).iter().zip(own.apply(&column)) {
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
        assert!((shared.log_determinant - own.log_determinant).abs() < 1e-4);
    }

    #[test]
    fn a_constant_on_a_level_costs_one_observation() {
        let noise = NoiseModel { walk: 0.1, ..NoiseModel::white(1) };
        let whitener = Whitener::new(&layout(50, true), &noise);
        let whitened = whitener.apply(&[5.0; 50]);
        assert!(whitened.iter().map(|value| value * value).sum::<f64>() < 1e-3);
    }
}
