//! What was found in a block.

use super::choose::Contender;
use super::data::Data;
use super::rivals::RivalFound;
use super::scene::robust_fit;
use crate::judge::{Goes, Metric};
use crate::model::Shape;
use crate::noise::{NoiseModel, Whitener};

/// An effect that was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// The shape, with its numbers at their best.
    pub shape: Shape,
    /// Its coefficients and their standard errors.
    pub coefficients: Vec<(f64, f64)>,
    /// Its other fitted numbers, with their standard errors.
    pub numbers: Vec<(String, f64)>,
    /// Surprise under noise alone, in nats, after the penalty for multiple testing.
    pub strength: f64,
    /// Causes that could stand in its place.
    pub rivals: Vec<RivalFound>,
}

/// Result for a block.
#[derive(Debug, Clone)]
pub struct BlockFit {
    /// Terms of the given model, with their values.
    pub base: Vec<Found>,
    /// Terms that were added.
    pub effects: Vec<Found>,
    /// All terms with the values to apply to other data.
    pub applied: Vec<Found>,
    /// The noise that remains.
    pub noise: NoiseModel,
    /// Standard deviation of the innovation of a reading.
    pub floor: f64,
    /// Standard deviation of a variance of 1 in `noise`.
    pub scale: f64,
    /// Strongest candidates below the threshold.
    pub left: Vec<Contender>,
    /// Outliers under the final model.
    pub left_out: Vec<bool>,
    /// The models from plain to rich.
    pub path: Vec<Waypoint>,
    /// Index of the chosen model.
    pub chosen: usize,
    /// Held-out errors of the choice: for each run, those of the model that would be chosen without it.
    pub nested: Vec<Metric>,
    /// The input that the residual depends on, if any: the residual is then not noise.
    pub goes: Option<Goes>,
}

/// A model on the path.
#[derive(Debug, Clone)]
pub struct Waypoint {
    /// Names of its effects.
    pub effects: Vec<String>,
    /// Number of causes among them.
    pub causes: usize,
    /// Its held-out errors.
    pub metrics: Vec<Metric>,
    /// For each metric, the margin in mean square within which the model counts as equal to the best.
    pub margins: Vec<f64>,
}

impl BlockFit {
    /// Shapes of the given model and of the added terms.
    pub fn shapes(&self) -> Vec<Shape> {
        self.base.iter().chain(&self.effects).map(|found| found.shape.clone()).collect()
    }
}

/// Fits `terms` as they are.
pub fn fit_terms(
    data: Data<'_>,
    terms: &[Shape],
    noise: &NoiseModel,
    left_out: &[bool],
) -> Vec<Found> {
    let whitener = Whitener::new(data.layout, noise, left_out);
    let white = whitener.apply_all(&data.all_columns(terms));
    let fit = robust_fit(&white, &whitener.apply(&data.block.residual));
    let mut at = 0;
    terms
        .iter()
        .map(|shape| {
            let width = data.width(shape);
            let coefficients =
                (at..at + width).map(|i| (fit.coefficients[i], fit.errors[i])).collect();
            at += width;
            Found {
                shape: shape.clone(),
                coefficients,
                numbers: Vec::new(),
                strength: 0.0,
                rivals: Vec::new(),
            }
        })
        .collect()
}
