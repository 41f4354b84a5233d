//! Terms fitted to a block, with values, errors and rivals.

use super::data::{Data, White, combine, less};
use crate::linear::{solve, weighed};
use crate::model::Shape;
use crate::noise::NoiseModel;
use crate::robust;
use std::ops::Range;

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

impl Found {
    /// A shape with its coefficients and their errors.
    pub fn new(shape: &Shape, coefficients: Vec<(f64, f64)>) -> Self {
        let (numbers, rivals) = (Vec::new(), Vec::new());
        Self { shape: shape.clone(), coefficients, numbers, strength: 0.0, rivals }
    }

    /// Its coefficients.
    pub fn values(&self) -> Vec<f64> {
        self.coefficients.iter().map(|(value, _)| *value).collect()
    }
}

/// Coefficients of all of them, one after the other.
pub fn values_of(all: &[Found]) -> Vec<f64> {
    all.iter().flat_map(Found::values).collect()
}

/// Another cause that the data cannot exclude.
#[derive(Debug, Clone)]
pub struct RivalFound {
    pub shape: Shape,
    /// Its distance behind the effect in rank, in nats.
    pub behind: f64,
}

/// Fits `terms` as they are.
pub fn fit_terms(data: Data<'_>, terms: &[Shape], noise: &NoiseModel) -> Vec<Found> {
    let White { columns, target, .. } = data.whitened(terms, noise);
    let fit = robust_fit(&columns, &target);
    let of = |places: Range<usize>| places.map(|i| (fit.coefficients[i], fit.errors[i])).collect();
    let places = data.places(terms).into_iter();
    terms.iter().zip(places).map(|(shape, places)| Found::new(shape, of(places))).collect()
}

/// Residual of a block after `found`, in SI.
pub fn residual(data: Data<'_>, found: &[Found]) -> Vec<f64> {
    let without = |left: Vec<f64>, found: &Found| {
        less(&left, &combine(&data.columns(&found.shape), &found.values()))
    };
    found.iter().fold(data.block.residual.clone(), without)
}

/// A robust least-squares fit on whitened columns.
pub struct RobustFit {
    /// One per column.
    pub coefficients: Vec<f64>,
    /// Their standard errors.
    pub errors: Vec<f64>,
}

/// Sweeps of re-weighting.
const SWEEPS: usize = 6;

/// Fits `columns` to `target`, both whitened; outliers count less (Huber's weights).
pub fn robust_fit(columns: &[Vec<f64>], target: &[f64]) -> RobustFit {
    let mut weights: Vec<f64> = target.iter().map(|_| 1.0).collect();
    let mut found = solve(columns, target);
    let residual_of = |coefficients: &[f64]| less(target, &combine(columns, coefficients));
    let mut residual = residual_of(&found.coefficients);
    let mut scale = robust::spread(&residual);
    for _ in 0..SWEEPS {
        let limit = robust::HUBER * scale;
        if residual.iter().all(|value| value.abs() <= limit) {
            break;
        }
        for (weight, value) in weights.iter_mut().zip(&residual) {
            *weight = if value.abs() > limit { limit / value.abs() } else { 1.0 };
        }
        found.coefficients = weighed(columns, target, &weights);
        residual = residual_of(&found.coefficients);
        scale = robust::spread(&residual);
    }
    // Huber's proposal: (X'X)^-1 times E psi^2 / (E psi')^2, corrected for the number of parameters.
    let limit = robust::HUBER * scale;
    let used = target.iter().zip(&residual).filter(|(t, r)| **t != 0.0 || **r != 0.0).count().max(1)
        as f64;
    let inside = residual.iter().filter(|value| value.abs() <= limit).count() as f64
        - (residual.len() as f64 - used);
    let square: f64 = residual.iter().map(|value| robust::held(*value, limit).powi(2)).sum();
    let free = (used - columns.len() as f64).max(1.0);
    let slope = (inside / used).clamp(0.1, 1.0);
    let variance = square / free / (slope * slope);
    let errors = (0..columns.len()).map(|i| (found.inverse[i][i] * variance).sqrt()).collect();
    RobustFit { coefficients: found.coefficients, errors }
}
