//! Least squares over legs: what a few columns leave, and how likely that is.

use crate::linear::coefficients;
use crate::robust;

/// Residuals beyond this many root mean squares count as that many: slips and doubled rows must not decide.
const CLIPPED: f64 = 4.0;

/// What `columns` leave of `target`.
pub(super) fn left(columns: &[&[f64]], target: &[f64]) -> Vec<f64> {
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| column.to_vec()).collect();
    let found = coefficients(&columns, target);
    let fitted = |i: usize| -> f64 {
        columns.iter().zip(&found).map(|(column, value)| column[i] * value).sum()
    };
    (0..target.len()).map(|i| target[i] - fitted(i)).collect()
}

/// Residuals of several quantities over the same legs.
pub(super) struct Fit(pub Vec<Vec<f64>>);

impl Fit {
    /// Squares of each quantity, clipped.
    fn squares(&self) -> Vec<Vec<f64>> {
        let of = |left: &Vec<f64>| {
            let limit = CLIPPED * robust::root_mean_square(left);
            let limit = if limit > 0.0 { limit } else { f64::INFINITY };
            left.iter().map(|value| value.abs().min(limit).powi(2)).collect()
        };
        self.0.iter().map(of).collect()
    }

    /// Minus twice the logarithm of the likelihood, with the noise of each quantity at its best.
    pub fn cost(&self) -> f64 {
        let of = |squares: &Vec<f64>| {
            let n = squares.len() as f64;
            n * (squares.iter().sum::<f64>() / n).max(f64::MIN_POSITIVE).ln()
        };
        self.squares().iter().map(of).sum()
    }

    /// Whether it leaves less than `other` beyond chance, and in most of the clusters.
    pub fn is_better(&self, other: &Self, cluster: &[usize]) -> bool {
        let (mine, its) = (self.squares(), other.squares());
        let mean = |squares: &Vec<f64>| squares.iter().sum::<f64>() / squares.len() as f64;
        let count = cluster.iter().max().map_or(0, |last| last + 1);
        let mut falls = vec![0.0; count];
        for (mine, its) in mine.iter().zip(&its) {
            let unit = mean(mine).max(f64::MIN_POSITIVE);
            for ((mine, its), &cluster) in mine.iter().zip(its).zip(cluster) {
                falls[cluster] += (its - mine) / unit;
            }
        }
        let n = cluster.len() as f64 * mine.len() as f64;
        let better = falls.iter().filter(|fall| **fall > 0.0).count() as f64;
        falls.iter().sum::<f64>() > FALL_MIN * n && better >= SHARE_MIN * count as f64
    }
}

/// Share of the remaining squares by which a correction must lower them.
const FALL_MIN: f64 = 0.02;
/// Share of the clusters in which it must.
const SHARE_MIN: f64 = 0.7;

/// The minimum of `cost` near `from`, each number with its first step, and the standard errors from the curvature there.
pub(super) fn minimum<const N: usize>(
    from: [f64; N],
    steps: [f64; N],
    cost: impl Fn([f64; N]) -> f64,
) -> ([f64; N], [f64; N]) {
    const HALVINGS: usize = 12;
    let (mut at, mut step) = (from, steps);
    let mut least = cost(at);
    for _ in 0..HALVINGS {
        let mut moved = true;
        while moved {
            moved = false;
            for i in 0..N {
                for sign in [-1.0, 1.0] {
                    let mut tried = at;
                    tried[i] += sign * step[i];
                    let its = cost(tried);
                    if its < least {
                        (at, least, moved) = (tried, its, true);
                    }
                }
            }
        }
        step.iter_mut().for_each(|step| *step /= 2.0);
    }
    (at, errors(at, steps, cost))
}

/// Standard errors from the curvature of minus twice a logarithm of a likelihood.
fn errors<const N: usize>(
    at: [f64; N],
    steps: [f64; N],
    cost: impl Fn([f64; N]) -> f64,
) -> [f64; N] {
    let step = steps.map(|step| step / 4.0);
    let shifted = |moves: &[(usize, f64)]| {
        let mut tried = at;
        moves.iter().for_each(|(i, sign)| tried[*i] += sign * step[*i]);
        cost(tried)
    };
    let mut curvature = nalgebra::DMatrix::<f64>::zeros(N, N);
    for i in 0..N {
        for j in 0..N {
            let of = |a: f64, b: f64| shifted(&[(i, a), (j, b)]);
            let sum = of(0.5, 0.5) - of(0.5, -0.5) - of(-0.5, 0.5) + of(-0.5, -0.5);
            curvature[(i, j)] = sum / (step[i] * step[j]);
        }
    }
    let inverse = curvature.try_inverse();
    std::array::from_fn(|i| {
        let variance = inverse.as_ref().map_or(f64::NAN, |inverse| 2.0 * inverse[(i, i)]);
        if variance > 0.0 { variance.sqrt() } else { f64::INFINITY }
    })
}

#[cfg(test)]
mod tests {
    use super::{Fit, minimum};

    #[test]
    fn the_minimum_of_a_likelihood_has_its_errors() {
        // Two correlated numbers: -2 ln L = (a, b) C^-1 (a, b) around (3, -1).
        let cost = |[a, b]: [f64; 2]| {
            let (x, y) = (a - 3.0, b + 1.0);
            (x * x - 1.2 * x * y + y * y) / 0.64
        };
        let (at, errors) = minimum([0.0, 0.0], [1.0, 1.0], cost);
        assert!((at[0] - 3.0).abs() < 1e-2 && (at[1] + 1.0).abs() < 1e-2, "{at:?}");
        assert!(errors.iter().all(|error| (error - 1.0).abs() < 1e-6), "{errors:?}");
    }

    #[test]
    fn what_helps_in_one_run_alone_is_not_better() {
        let cluster: Vec<usize> = (0..100).map(|i| i / 10).collect();
        let noise = |i: usize| (i as f64 * 37.7).sin();
        let plain: Vec<f64> = (0..100).map(noise).collect();
        let half = Fit(vec![plain.iter().map(|value| value / 2.0).collect()]);
        let once = |i: usize| if i < 10 { 0.0 } else { 1.0 };
        let one = Fit(vec![(0..100).map(|i| once(i) * plain[i]).collect()]);
        let plain = Fit(vec![plain]);
        assert!(half.is_better(&plain, &cluster));
        assert!(!one.is_better(&plain, &cluster));
        assert!(!plain.is_better(&plain, &cluster));
    }
}
