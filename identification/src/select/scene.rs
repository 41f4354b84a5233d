//! One block of equations with the model so far subtracted, in which candidates are measured.
use super::means::Means;
use super::record::{Record, Seen, View};
use crate::fit::{Data, combine, folds, less};
use crate::linear::{Basis, dot, weighed};
use crate::model::Shape;
use crate::noise::{NoiseModel, Whitener};
use crate::robust;
use crate::significance::surprise;
use std::rc::Rc;

/// How much a candidate would explain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Explained sum of squares, over the variance of the noise.
    pub statistic: f64,
    /// Number of independent columns it adds.
    pub width: usize,
    /// `-ln` of the probability of as much in noise.
    pub surprise: f64,
}

/// A candidate that explains nothing.
pub const NOTHING: Score = Score { statistic: 0.0, width: 0, surprise: 0.0 };

/// A block with the model so far subtracted.
pub struct Scene<'a> {
    pub record: &'a Record<'a>,
    pub data: Data<'a>,
    /// Whitens its noise.
    pub whitener: Rc<Whitener>,
    /// The whitened residual of the model.
    pub white: Rc<[f64]>,
    /// Huber's scores of the whitened residual.
    pub scores: Vec<f64>,
    /// Mean square of the scores.
    pub variance: f64,
    /// Standard deviation of the whitened residual.
    pub scale: f64,
    basis: Basis,
    used: usize,
    thin: Option<Thin>,
    means: Vec<OnMeans>,
}

/// The scene in the means of a long record.
#[derive(Clone)]
struct OnMeans {
    whitener: Rc<Whitener>,
    basis: Basis,
    scores: Vec<f64>,
    /// Weight of each observation in its mean.
    weights: Rc<[f64]>,
}

/// The whitened record in sums of a few rows: slow candidates lose nothing in them.
#[derive(Clone)]
struct Thin {
    block: usize,
    basis: Basis,
    scores: Vec<f64>,
}

/// Number of rows above which candidates are first measured on sums, and number of those sums.
const WHOLE_MAX: usize = 6000;
const THINNED: usize = 3000;
/// Minimum share of its length that a candidate must keep in sums; otherwise it is measured on all rows.
const KEPT_MIN: f64 = 0.96;

/// Sums of `block` values each, scaled to the variance of a value.
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
        thin.extend(basis.columns().iter().map(|column| sums(column, block)).collect());
        let mut scores = sums(scores, block);
        thin.project(&mut scores);
        Some(Self { block, basis: thin, scores })
    }
}

impl<'a> Scene<'a> {
    /// The scene under `noise`, with `columns` (of the model so far, derivatives included) subtracted.
    pub fn new(record: &'a Record<'a>, noise: &NoiseModel, columns: &[Vec<f64>]) -> Self {
        let data = record.data;
        let whitener = Rc::new(Whitener::new(data.layout, noise));
        let mut basis = Basis::default();
        basis.extend(whitener.apply_all(columns));
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
        let thin = if record.means.is_empty() { Thin::new(&basis, &scores) } else { None };
        let means = if record.means.is_empty() {
            Vec::new()
        } else {
            // Outliers count in means as in the scores.
            let residual: Vec<f64> = data
                .block
                .residual
                .iter()
                .zip(white.iter().zip(whitener.weights()))
                .map(|(value, (white, weight))| {
                    let limit = robust::HUBER * scale;
                    let wild = white - robust::held(*white, limit);
                    if *weight > 0.0 { value - wild / weight } else { *value }
                })
                .collect();
            let weights = data.layout.weights(noise);
            let on = |means: &Means| OnMeans::new(means, noise, &weights, columns, &residual);
            record.means.iter().map(on).collect()
        };
        let white = Rc::from(white);
        Self { record, data, whitener, white, scores, variance, scale, basis, used, thin, means }
    }

    /// Remaining degrees of freedom.
    pub fn free(&self) -> f64 {
        (self.used as f64 - self.basis.len() as f64).max(1.0)
    }

    /// Standard deviation of the innovation of a reading: white noise plus what coloured noise added since the previous
    /// reading. Readings cannot separate the white part from a colour as short as their interval, nor that of a level from
    /// what it walks meanwhile. For poses, that of the white noise.
    pub fn floor(&self, noise: &NoiseModel) -> f64 {
        if self.data.block.pose.is_some() {
            return self.scale * noise.white.sqrt();
        }
        if self.data.layout.is_level() {
            // Nothing is known of the first level of a stretch.
            let weights = self.whitener.weights().iter().filter(|weight| **weight > 0.0);
            return self.scale / robust::median(weights.copied().collect());
        }
        let weights = self.whitener.weights().iter().filter(|weight| **weight > 0.0);
        let (sum, count) = weights.fold((0.0, 0.0), |(s, n), w| (s + w.powi(-2), n + 1.0));
        self.scale * (sum / f64::max(count, 1.0)).sqrt()
    }

    /// What `shape` would explain beyond the model.
    pub fn score(&self, shape: &Shape) -> Score {
        self.score_columns(&self.data.columns(shape))
    }

    /// Estimate of what `shape` would explain: on a long record, slow shapes are measured on means of rows.
    pub fn look(&self, shape: &Shape) -> Score {
        self.look_at(shape, self.record.view(shape))
    }

    /// The same if the view of `shape` is known.
    pub fn look_at(&self, shape: &Shape, view: View) -> Score {
        self.look_at_columns(&self.record.columns(shape, view), view)
    }

    /// The same of a candidate.
    pub fn look_at_seen(&self, seen: &Seen) -> Score {
        self.look_at_columns(&self.record.columns_of(seen), seen.view)
    }

    fn look_at_columns(&self, columns: &[Vec<f64>], view: View) -> Score {
        if let Some(on) = self.means.get(view.0) {
            return self.beyond(&on.basis, &on.whitener, &on.scores, columns);
        }
        let Some(thin) = &self.thin else {
            return self.score_columns(columns);
        };
        if columns.is_empty() || !(self.variance > 0.0) {
            return NOTHING;
        }
        let mut white = Vec::with_capacity(columns.len());
        for whole in self.whitener.apply_all(columns) {
            let summed = sums(&whole, thin.block);
            if dot(&summed, &summed) < KEPT_MIN * dot(&whole, &whole) {
                return self.score_columns(columns);
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
        self.beyond(&self.basis, &self.whitener, &self.scores, columns)
    }

    fn beyond(
        &self,
        basis: &Basis,
        whitener: &Whitener,
        scores: &[f64],
        columns: &[Vec<f64>],
    ) -> Score {
        if columns.is_empty() || !(self.variance > 0.0) {
            return NOTHING;
        }
        let new = basis.beyond(whitener.apply_all(columns));
        if new.len() == 0 {
            return NOTHING;
        }
        self.judge(new.explained(scores) / self.variance, new.len())
    }

    fn judge(&self, statistic: f64, width: usize) -> Score {
        let free = self.free();
        let k = width as f64;
        let below = free - k;
        // The variance contains the effect too; the remainder without it is the noise.
        let rest = (free - statistic).max(1e-9 * free);
        let f = if below > 0.0 { (statistic / k) / (rest / below) } else { 0.0 };
        Score { statistic, width, surprise: surprise(f, k, below) }
    }

    /// Subtracts the model so far from a whitened column.
    pub fn project(&self, column: &mut Vec<f64>) {
        self.basis.project(column);
        self.basis.project(column);
    }

    /// The same scene with `columns` subtracted as well.
    pub fn with(&self, columns: &[Vec<f64>]) -> Scene<'a> {
        let mut basis = self.basis.clone();
        basis.extend(self.whitener.apply_all(columns));
        let mut scores = self.scores.clone();
        basis.project(&mut scores);
        let free = (self.used as f64 - basis.len() as f64).max(1.0);
        let variance = dot(&scores, &scores) / free;
        let thin = self.thin.as_ref().and_then(|_| Thin::new(&basis, &scores));
        let on = |(means, on): (&Means, &OnMeans)| on.with(means, columns);
        Scene {
            record: self.record,
            data: self.data,
            whitener: Rc::clone(&self.whitener),
            white: Rc::clone(&self.white),
            variance,
            scale: self.scale,
            thin,
            means: self.record.means.iter().zip(&self.means).map(on).collect(),
            scores,
            basis,
            used: self.used,
        }
    }
}

/// Reduction of the held-out whitened error, in nats, by `new` columns beside `old` ones; outliers count only as large
/// values.
pub(super) fn gain(scene: &Scene<'_>, old: &[Vec<f64>], new: &[Vec<f64>]) -> f64 {
    let (old, new) = (scene.whitener.apply_all(old), scene.whitener.apply_all(new));
    let both: Vec<Vec<f64>> = old.iter().chain(&new).cloned().collect();
    let target = scene.whitener.apply(&scene.data.block.residual);
    let limit = robust::HUBER * scene.scale;
    let loss = |value: f64| {
        let size = value.abs();
        if size <= limit { size * size } else { limit * (2.0 * size - limit) }
    };
    let mut total = 0.0;
    for fold in folds(&scene.data.layout.run) {
        let counts: Vec<f64> = fold.train.iter().map(|train| f64::from(u8::from(*train))).collect();
        let error = |columns: &[Vec<f64>]| -> f64 {
            let found = weighed(columns, &target, &counts);
            let left = less(&target, &combine(columns, &found));
            let held = left.iter().zip(&fold.test).filter(|(_, test)| **test);
            held.map(|(left, _)| loss(*left)).sum()
        };
        total += error(&old) - error(&both);
    }
    total / (2.0 * scene.scale * scene.scale)
}

impl OnMeans {
    fn new(
        means: &Means,
        noise: &NoiseModel,
        weights: &[f64],
        columns: &[Vec<f64>],
        residual: &[f64],
    ) -> Self {
        let whitener = Rc::new(Whitener::new(&means.layout(weights), &noise.of_all()));
        let mut basis = Basis::default();
        let columns: Vec<Vec<f64>> =
            columns.iter().map(|column| means.of(column, weights)).collect();
        basis.extend(whitener.apply_all(&columns));
        let mut scores = whitener.apply(&means.of(residual, weights));
        basis.project(&mut scores);
        basis.project(&mut scores);
        Self { whitener, basis, scores, weights: Rc::from(weights) }
    }

    fn with(&self, means: &Means, columns: &[Vec<f64>]) -> Self {
        let mut found = self.clone();
        let columns: Vec<Vec<f64>> =
            columns.iter().map(|column| means.of(column, &self.weights)).collect();
        found.basis.extend(self.whitener.apply_all(&columns));
        found.basis.project(&mut found.scores);
        found
    }
}
