//! One block of equations with the model so far taken out: where candidates are measured.

use crate::linear::{Basis, dot, solve};
use crate::model::Shape;
use crate::noise::{Layout, NoiseModel, Whitener};
use crate::problem::{Block, Channels};
use crate::robust;
use crate::significance::surprise;

/// The data of one block, which never change.
#[derive(Clone, Copy)]
pub struct Data<'a> {
    /// The equations.
    pub block: &'a Block,
    /// What effects see.
    pub channels: &'a Channels,
    /// When observations were made.
    pub layout: &'a Layout,
}

impl Data<'_> {
    /// Columns of `shape` over the observations; none where it cannot be had.
    pub fn columns(&self, shape: &Shape) -> Vec<Vec<f64>> {
        let columns = shape.observed(self.block, self.channels).unwrap_or_default();
        if columns.iter().flatten().all(|value| value.is_finite()) { columns } else { Vec::new() }
    }

    /// Columns of all `terms`, one after the other.
    pub fn all_columns(&self, terms: &[Shape]) -> Vec<Vec<f64>> {
        terms.iter().flat_map(|term| self.columns(term)).collect()
    }

    /// How the observations change with each number of each term that they are not linear in, at `coefficients`
    /// (one a column of `all_columns`).
    pub fn derivatives(&self, terms: &[Shape], coefficients: &[f64]) -> Vec<Derivative> {
        let mut found = Vec::new();
        let mut at = 0;
        for (index, term) in terms.iter().enumerate() {
            let width = self.columns(term).len();
            let mine =
                &coefficients[at.min(coefficients.len())..(at + width).min(coefficients.len())];
            at += width;
            for name in term.nonlinear() {
                let Some(value) = term.number(name) else { continue };
                let step = derivative_step(term, name, value);
                let side = |sign: f64| {
                    let mut moved = term.clone();
                    moved.set(name, value + sign * step);
                    combine(&self.columns(&moved), mine)
                };
                let (high, low) = (side(1.0), side(-1.0));
                if high.len() == low.len() && !high.is_empty() {
                    let column =
                        high.iter().zip(&low).map(|(h, l)| (h - l) / (2.0 * step)).collect();
                    found.push(Derivative { term: index, name, column });
                }
            }
        }
        found
    }
}

/// How the observations change with a number.
pub struct Derivative {
    /// Index of the term.
    pub term: usize,
    /// Which number.
    pub name: &'static str,
    /// Change of each observation per unit of it.
    pub column: Vec<f64>,
}

fn derivative_step(term: &Shape, name: &str, value: f64) -> f64 {
    let width = term.number("width");
    match (name, width) {
        ("centre", Some(width)) => 0.02 * width,
        ("period", _) => 1e-4 * value,
        _ => (0.01 * value.abs()).max(1e-12),
    }
}

/// Sum of columns, each times its coefficient.
pub fn combine(columns: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; columns.first().map_or(0, Vec::len)];
    for (column, coefficient) in columns.iter().zip(coefficients) {
        for (total, value) in sum.iter_mut().zip(column) {
            *total += coefficient * value;
        }
    }
    sum
}

/// How much a candidate would explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Sum of squares that it explains, over the variance of the noise.
    pub statistic: f64,
    /// How many independent columns it brings.
    pub width: usize,
    /// `-ln` of the probability of as much in noise.
    pub surprise: f64,
}

const NOTHING: Score = Score { statistic: 0.0, width: 0, surprise: 0.0 };

/// A block with the model so far taken out.
pub struct Scene<'a> {
    /// The data.
    pub data: Data<'a>,
    /// What makes its noise white.
    pub whitener: Whitener,
    /// Huber's scores of the whitened residual, and their mean square.
    pub scores: Vec<f64>,
    /// Mean square of the scores.
    pub variance: f64,
    /// Standard deviation of the whitened residual.
    pub scale: f64,
    basis: Basis,
    used: usize,
    thin: Option<Thin>,
}

/// The whitened record with every few rows summed: slow candidates lose nothing by it.
#[derive(Clone)]
struct Thin {
    block: usize,
    basis: Basis,
    scores: Vec<f64>,
}

/// Rows above which candidates are first measured on sums, and rows of those.
const WHOLE_MAX: usize = 6000;
const THINNED: usize = 3000;
/// A candidate that keeps less than this share of its length in sums is measured whole.
const KEPT_MIN: f64 = 0.96;

/// Sums of `block` values each, of the same variance as a value.
fn sums(values: &[f64], block: usize) -> Vec<f64> {
    let factor = 1.0 / (block as f64).sqrt();
    values.chunks(block).map(|chunk| chunk.iter().sum::<f64>() * factor).collect()
}

impl Thin {
    fn new(basis: &Basis, scores: &[f64]) -> Option<Self> {
        if scores.len() <= WHOLE_MAX {
            return None;
        }
        let block = scores.len().div_ceil(THINNED);
        let mut thin = Basis::default();
        for column in basis.columns() {
            thin.push(sums(column, block));
        }
        let mut scores = sums(scores, block);
        thin.project(&mut scores);
        Some(Self { block, basis: thin, scores })
    }
}

impl<'a> Scene<'a> {
    /// With `columns` (of the model so far, derivatives included) taken out under `noise`.
    pub fn new(
        data: Data<'a>,
        noise: &NoiseModel,
        left_out: &[bool],
        columns: &[Vec<f64>],
    ) -> Self {
        let whitener = Whitener::new(data.layout, noise, left_out);
        let mut basis = Basis::default();
        for column in columns {
            basis.push(whitener.apply(column));
        }
        let mut white = whitener.apply(&data.block.residual);
        basis.project(&mut white);
        basis.project(&mut white);
        let used = whitener.used();
        let weighed: Vec<f64> = white.iter().copied().filter(|value| *value != 0.0).collect();
        let scale = robust::spread(&weighed);
        let mut scores = robust::scores(&white, scale);
        basis.project(&mut scores);
        let free = (used as f64 - basis.len() as f64).max(1.0);
        let variance = dot(&scores, &scores) / free;
        let thin = Thin::new(&basis, &scores);
        Self { data, whitener, scores, variance, scale, basis, used, thin }
    }

    /// Degrees of freedom that are left.
    pub fn free(&self) -> f64 {
        (self.used as f64 - self.basis.len() as f64).max(1.0)
    }

    /// What `shape` would explain beyond the model.
    pub fn score(&self, shape: &Shape) -> Score {
        self.score_columns(&self.data.columns(shape))
    }

    /// About what `shape` would explain: of a long record, slow shapes are measured on sums of rows.
    pub fn look(&self, shape: &Shape) -> Score {
        let Some(thin) = &self.thin else {
            return self.score(shape);
        };
        let columns = self.data.columns(shape);
        if columns.is_empty() || !(self.variance > 0.0) {
            return NOTHING;
        }
        let mut white = Vec::with_capacity(columns.len());
        for column in &columns {
            let whole = self.whitener.apply(column);
            let summed = sums(&whole, thin.block);
            if dot(&summed, &summed) < KEPT_MIN * dot(&whole, &whole) {
                return self.score_columns(&columns);
            }
            white.push(summed);
        }
        let new = thin.basis.beyond(white);
        if new.len() == 0 {
            return NOTHING;
        }
        self.judge(new.explained(&thin.scores) / self.variance, new.len())
    }

    /// What columns of observations would explain beyond the model.
    pub fn score_columns(&self, columns: &[Vec<f64>]) -> Score {
        if columns.is_empty() || !(self.variance > 0.0) {
            return NOTHING;
        }
        let white: Vec<Vec<f64>> =
            columns.iter().map(|column| self.whitener.apply(column)).collect();
        let new = self.basis.beyond(white);
        if new.len() == 0 {
            return NOTHING;
        }
        self.judge(new.explained(&self.scores) / self.variance, new.len())
    }

    fn judge(&self, statistic: f64, width: usize) -> Score {
        let free = self.free();
        let k = width as f64;
        let below = free - k;
        // The variance holds the effect too; what is left without it is the noise.
        let rest = (free - statistic).max(1e-9 * free);
        let f = if below > 0.0 { (statistic / k) / (rest / below) } else { 0.0 };
        Score { statistic, width, surprise: surprise(f, k, below) }
    }

    /// Takes the model so far out of a whitened column.
    pub fn project(&self, column: &mut [f64]) {
        self.basis.project(column);
        self.basis.project(column);
    }

    /// The same scene with `columns` taken out as well.
    pub fn with(&self, columns: &[Vec<f64>]) -> Scene<'a> {
        let mut basis = self.basis.clone();
        for column in columns {
            basis.push(self.whitener.apply(column));
        }
        let mut scores = self.scores.clone();
        basis.project(&mut scores);
        let free = (self.used as f64 - basis.len() as f64).max(1.0);
        let variance = dot(&scores, &scores) / free;
        Scene {
            data: self.data,
            whitener: self.whitener.clone(),
            variance,
            scale: self.scale,
            thin: Thin::new(&basis, &scores),
            scores,
            basis,
            used: self.used,
        }
    }
}

/// A robust least-squares fit on whitened columns.
pub struct RobustFit {
    /// One a column.
    pub coefficients: Vec<f64>,
    /// Their standard errors.
    pub errors: Vec<f64>,
}

/// Sweeps of re-weighting.
const SWEEPS: usize = 6;

/// Fits `columns` to `target`, both whitened; wild values count less (Huber's weights).
pub fn robust_fit(columns: &[Vec<f64>], target: &[f64]) -> RobustFit {
    let mut weights: Vec<f64> = target.iter().map(|_| 1.0).collect();
    let mut found = solve(columns, target);
    let residual_of = |coefficients: &[f64]| -> Vec<f64> {
        let fitted = combine(columns, coefficients);
        if fitted.is_empty() {
            return target.to_vec();
        }
        target.iter().zip(&fitted).map(|(t, f)| t - f).collect()
    };
    let mut residual = residual_of(&found.coefficients);
    let mut scale = robust::spread(&residual);
    for _ in 0..SWEEPS {
        let limit = robust::HUBER * scale;
        if residual.iter().all(|value| value.abs() <= limit) {
            break;
        }
        for (weight, value) in weights.iter_mut().zip(&residual) {
            *weight = if value.abs() > limit { (limit / value.abs()).sqrt() } else { 1.0 };
        }
        let weigh =
            |column: &[f64]| column.iter().zip(&weights).map(|(c, w)| c * w).collect::<Vec<f64>>();
        let weighed: Vec<Vec<f64>> = columns.iter().map(|column| weigh(column)).collect();
        found.coefficients = solve(&weighed, &weigh(target)).coefficients;
        residual = residual_of(&found.coefficients);
        scale = robust::spread(&residual);
    }
    // Huber's proposal: (X'X)^-1 times E psi^2 / (E psi')^2, with the parameters taken off.
    let limit = robust::HUBER * scale;
    let used = target.iter().zip(&residual).filter(|(t, r)| **t != 0.0 || **r != 0.0).count().max(1)
        as f64;
    let inside = residual.iter().filter(|value| value.abs() <= limit).count() as f64
        - (residual.len() as f64 - used);
    let square: f64 = residual.iter().map(|value| value.clamp(-limit, limit).powi(2)).sum();
    let free = (used - columns.len() as f64).max(1.0);
    let slope = (inside / used).clamp(0.1, 1.0);
    let variance = square / free / (slope * slope);
    let errors = (0..columns.len()).map(|i| (found.inverse[i][i] * variance).sqrt()).collect();
    RobustFit { coefficients: found.coefficients, errors }
}
