//! Linear algebra with a known truth: whitening with the true noise, projection off what the plain model absorbs, the
//! size of an effect, and the oracle's generalised least squares.

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// The noise of the observations, as the generator knows it.
#[derive(Debug, Clone)]
pub enum Whitener {
    /// Independent, with that standard deviation in each row.
    Independent(Vec<f64>),
    /// A first-order autoregression plus independent noise in each block.
    Autoregressive(Vec<Autoregression>),
    /// A covariance between neighbouring rows in each block.
    Neighbours(Vec<Neighbours>),
}

/// `x[k+1] = phi x[k] + N(0, process^2)`, `x[0] ~ N(0, start^2)`, observed with `N(0, white^2)`.
#[derive(Debug, Clone, Copy)]
pub struct Autoregression {
    /// Decay per step; 1 is a random walk.
    pub phi: f64,
    /// Standard deviation of the innovation.
    pub process: f64,
    /// Standard deviation of the first state.
    pub start: f64,
    /// Standard deviation of the independent part.
    pub white: f64,
}

/// A tridiagonal covariance.
#[derive(Debug, Clone)]
pub struct Neighbours {
    /// Variance of each row.
    pub variance: Vec<f64>,
    /// Covariance of each row with the next; one element shorter.
    pub covariance: Vec<f64>,
}

/// Smallest valid pivot: below it, the covariance is not positive definite.
const SMALLEST_PIVOT: f64 = 1e-300;

/// What the observations contain besides the effect, and their noise.
#[derive(Debug, Clone)]
pub struct Design {
    /// Rows that share a start state: one block per run.
    pub blocks: Vec<Range<usize>>,
    /// Columns that the plain model fits.
    pub base: Vec<Vec<f64>>,
    /// Columns whose coefficient is free in each block (the start pose of a run).
    pub local: Vec<Vec<f64>>,
    /// The noise; the fit depends only on its ratios, z on its size.
    pub whitener: Whitener,
}

impl Design {
    /// `column` with the noise made white and of variance 1.
    pub fn whiten(&self, column: &[f64]) -> Vec<f64> {
        match &self.whitener {
            Whitener::Independent(sd) => column.iter().zip(sd).map(|(x, sd)| x / sd).collect(),
            Whitener::Autoregressive(of_block) => {
                self.by_block(of_block, column, |noise, x, out| noise.whiten(x, out))
            }
            Whitener::Neighbours(of_block) => {
                self.by_block(of_block, column, |noise, x, out| noise.whiten(x, out))
            }
        }
    }

    fn by_block<T>(
        &self,
        of_block: &[T],
        column: &[f64],
        whiten: impl Fn(&T, &[f64], &mut Vec<f64>),
    ) -> Vec<f64> {
        let mut out = Vec::with_capacity(column.len());
        for (block, noise) in self.blocks.iter().zip(of_block) {
            whiten(noise, &column[block.clone()], &mut out);
        }
        out
    }

    /// The projector of whitened columns off everything that the plain model absorbs.
    pub fn projector(&self) -> Projector {
        let mut projector =
            Projector { blocks: self.blocks.clone(), local: Vec::new(), base: Vec::new() };
        for column in &self.local {
            let mut column = self.whiten(column);
            projector.off_local(&mut column);
            for block in &self.blocks {
                normalise(&mut column[block.clone()]);
            }
            projector.local.push(column);
        }
        for column in &self.base {
            let mut column = self.whiten(column);
            projector.project(&mut column);
            normalise(&mut column);
            projector.base.push(column);
        }
        projector
    }

    /// Whitened norm of the part of `column` that the plain model cannot absorb.
    pub fn z(&self, projector: &Projector, column: &[f64]) -> f64 {
        let mut column = self.whiten(column);
        projector.project(&mut column);
        norm(&column)
    }

    /// Generalised least squares of `observed` on the base and `effects`: the coefficients of the base first, then of
    /// the effects. `None` if the columns are not independent. Local columns do not take part: see
    /// [`Self::effect_coefficients`].
    pub fn fit(&self, observed: &[f64], effects: &[Vec<f64>]) -> Option<Vec<f64>> {
        solve(
            self.base.iter().chain(effects).map(|column| self.whiten(column)).collect(),
            self.whiten(observed),
        )
    }

    /// Like [`Self::fit`], but only the coefficients of the effects, with local columns included.
    pub fn effect_coefficients(
        &self,
        projector: &Projector,
        observed: &[f64],
        effects: &[Vec<f64>],
    ) -> Option<Vec<f64>> {
        let project = |column: &Vec<f64>| {
            let mut column = self.whiten(column);
            projector.project(&mut column);
            column
        };
        solve(effects.iter().map(project).collect(), project(&observed.to_vec()))
    }
}

fn solve(columns: Vec<Vec<f64>>, observed: Vec<f64>) -> Option<Vec<f64>> {
    if columns.is_empty() {
        return Some(Vec::new());
    }
    let norms: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
    if norms.iter().any(|&norm| norm <= 0.0 || !norm.is_finite()) {
        return None;
    }
    let matrix =
        DMatrix::from_fn(observed.len(), columns.len(), |row, k| columns[k][row] / norms[k]);
    let qr = matrix.qr();
    let right = qr.q().tr_mul(&DVector::from_vec(observed));
    let solution = qr.r().solve_upper_triangular(&right)?;
    Some(solution.iter().zip(&norms).map(|(x, norm)| x / norm).collect())
}

impl Autoregression {
    /// The innovations of the Kalman filter of the model, over their standard deviations: a linear map of `x`, so it
    /// applies to columns and noise alike.
    fn whiten(&self, x: &[f64], out: &mut Vec<f64>) {
        let (mut state, mut variance) = (0.0, self.start * self.start);
        for &x in x {
            let total = variance + self.white * self.white;
            let innovation = x - state;
            out.push(innovation / total.sqrt());
            let gain = variance / total;
            state = self.phi * (state + gain * innovation);
            variance = self.phi * self.phi * variance * (1.0 - gain) + self.process * self.process;
        }
    }
}

impl Neighbours {
    /// Forward substitution with the Cholesky factor, which is bidiagonal.
    fn whiten(&self, x: &[f64], out: &mut Vec<f64>) {
        let (mut last, mut last_pivot) = (0.0, 1.0);
        for (k, (&x, &variance)) in x.iter().zip(&self.variance).enumerate() {
            let below = if k == 0 { 0.0 } else { self.covariance[k - 1] / last_pivot };
            let pivot = (variance - below * below).max(SMALLEST_PIVOT).sqrt();
            last = (x - below * last) / pivot;
            last_pivot = pivot;
            out.push(last);
        }
    }
}

/// Orthonormal whitened columns: those of the blocks, and those of the whole.
pub struct Projector {
    blocks: Vec<Range<usize>>,
    local: Vec<Vec<f64>>,
    base: Vec<Vec<f64>>,
}

impl Projector {
    /// Removes everything that the plain model absorbs from a whitened column.
    pub fn project(&self, column: &mut [f64]) {
        // Two passes make Gram-Schmidt orthogonal to rounding.
        for _ in 0..2 {
            self.off_local(column);
            for q in &self.base {
                subtract(column, q);
            }
        }
    }

    fn off_local(&self, column: &mut [f64]) {
        for _ in 0..2 {
            for q in &self.local {
                for block in &self.blocks {
                    subtract(&mut column[block.clone()], &q[block.clone()]);
                }
            }
        }
    }
}

fn subtract(column: &mut [f64], q: &[f64]) {
    let along: f64 = column.iter().zip(q).map(|(x, q)| x * q).sum();
    for (x, q) in column.iter_mut().zip(q) {
        *x -= along * q;
    }
}

fn normalise(column: &mut [f64]) {
    let norm = norm(column);
    if norm > 0.0 {
        column.iter_mut().for_each(|x| *x /= norm);
    }
}

/// Euclidean norm.
pub fn norm(column: &[f64]) -> f64 {
    column.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Root mean square of `observed` minus the columns times their coefficients.
pub fn rmse<'a>(
    observed: &[f64],
    columns: impl Iterator<Item = &'a Vec<f64>>,
    coefficients: &[f64],
) -> f64 {
    let mut residual = observed.to_vec();
    for (column, coefficient) in columns.zip(coefficients) {
        for (r, x) in residual.iter_mut().zip(column) {
            *r -= coefficient * x;
        }
    }
    norm(&residual) / (residual.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn plain(n: usize, whitener: Whitener) -> Design {
        let ramp = (0..n).map(|k| k as f64).collect();
        Design {
            blocks: vec![0..n / 2, n / 2..n],
            base: vec![vec![1.0; n], ramp],
            local: vec![],
            whitener,
        }
    }

    #[test]
    fn whitening_takes_a_random_walk_plus_noise_to_unit_variance() {
        let mut stream = Stream::new(1, "whiten", 0, "test");
        let of = Autoregression { phi: 0.98, process: 0.3, start: 1.5, white: 0.7 };
        let n = 40_000;
        let mut noise = Vec::new();
        for _ in 0..2 {
            let mut x = of.start * stream.normal();
            for _ in 0..n / 2 {
                noise.push(x + of.white * stream.normal());
                x = of.phi * x + of.process * stream.normal();
            }
        }
        let white = plain(n, Whitener::Autoregressive(vec![of, of])).whiten(&noise);
        let variance = white.iter().map(|x| x * x).sum::<f64>() / n as f64;
        let lag: f64 = white.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n as f64;
        assert!((variance - 1.0).abs() < 0.03, "{variance}");
        assert!(lag.abs() < 0.02, "{lag}");
    }

    #[test]
    fn whitening_takes_differences_of_noise_to_unit_variance() {
        let mut stream = Stream::new(1, "differences", 0, "test");
        let n = 40_000;
        let noise: Vec<f64> = (0..=n).map(|_| stream.normal()).collect();
        let differences: Vec<f64> = noise.windows(2).map(|w| w[1] - w[0]).collect();
        let half = Neighbours { variance: vec![2.0; n / 2], covariance: vec![-1.0; n / 2 - 1] };
        let white = plain(n, Whitener::Neighbours(vec![half.clone(), half])).whiten(&differences);
        let variance = white.iter().map(|x| x * x).sum::<f64>() / n as f64;
        assert!((variance - 1.0).abs() < 0.03, "{variance}");
    }

    #[test]
    fn what_the_base_absorbs_has_no_size_and_the_rest_has() {
        let design = plain(100, Whitener::Independent(vec![0.5; 100]));
        let projector = design.projector();
        let line: Vec<f64> = (0..100).map(|k| 3.0 - 2.0 * k as f64).collect();
        assert!(design.z(&projector, &line) < 1e-9);
        let mut spike = vec![0.0; 100];
        spike[50] = 0.5;
        assert!((design.z(&projector, &spike) - 1.0).abs() < 0.02);
    }

    #[test]
    fn local_columns_are_free_in_each_block() {
        let mut design = plain(100, Whitener::Independent(vec![1.0; 100]));
        design.local = vec![vec![1.0; 100]];
        let step: Vec<f64> = (0..100).map(|k| if k < 50 { 1.0 } else { -4.0 }).collect();
        assert!(design.z(&design.projector(), &step) < 1e-9);
    }

    #[test]
    fn the_fit_returns_what_was_put_in() {
        let design = plain(60, Whitener::Independent((0..60).map(|k| 1.0 + k as f64).collect()));
        let effect: Vec<f64> = (0..60).map(|k| (k as f64 * 0.7).sin()).collect();
        let observed: Vec<f64> = (0..60).map(|k| 2.0 - 0.1 * k as f64 + 0.3 * effect[k]).collect();
        let fit = design.fit(&observed, std::slice::from_ref(&effect)).expect("independent");
        for (found, truth) in fit.iter().zip([2.0, -0.1, 0.3]) {
            assert!((found - truth).abs() < 1e-9);
        }
        let alone = design.effect_coefficients(&design.projector(), &observed, &[effect]);
        assert!((alone.expect("independent")[0] - 0.3).abs() < 1e-9);
    }
}
