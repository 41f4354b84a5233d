//! Readings on a lattice that is coarser than their noise: removes the effect of rounding before any search.
//!
//! If the noise is smaller than the step, the rounding error is a function of the reading itself and mimics every
//! smooth effect. Its mean given the model's prediction is known (Widrow's statistical theory of quantisation), and so
//! is a reading's remaining sensitivity to a small change.

use crate::fit::{Data, combine, fit_terms, less};
use crate::model::Shape;
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Aggregate, Block, Channels};
use crate::robust::root_mean_square;
use crate::significance::normal_above;
use std::f64::consts::PI;

/// Maximum share of distinct values among the readings of a lattice; each value is a multiple of one step.
const DIFFERENT_SHARE_MAX: f64 = 0.5;
/// Maximum distance of a reading from the lattice, as a share of the step: the file may have rounded it once more.
const OFF_MAX: f64 = 0.02;
/// Smallest step, over the noise, that matters: noise hides a finer one.
const COARSE_FROM: f64 = 0.8;
/// Smallest usable sensitivity: a reading whose mean moves by less than this share of a change says too little, and its
/// error is far from normal.
const SLOPE_MIN: f64 = 0.6;
/// Terms of the series for the mean rounding error.
const TERMS: i32 = 60;

/// The step of the lattice on which `readings` lie, if they lie on one.
pub(crate) fn step(readings: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = readings.iter().copied().filter(|one| one.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    if readings.len() < 50
        || sorted.len() < 3
        || sorted.len() as f64 > DIFFERENT_SHARE_MAX * readings.len() as f64
    {
        return None;
    }
    let gaps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let span = sorted[sorted.len() - 1] - sorted[0];
    let smallest =
        gaps.iter().copied().filter(|gap| *gap > 1e-9 * span).fold(f64::INFINITY, f64::min);
    // The mean over many steps is more precise than the smallest gap.
    let count: f64 = gaps.iter().map(|gap| (gap / smallest).round()).sum();
    let step = span / count.max(1.0);
    let near = gaps.iter().filter(|gap| {
        let steps = *gap / step;
        (steps - steps.round()).abs() < OFF_MAX
    });
    (near.count() * 10 >= gaps.len() * 9).then_some(step)
}

/// Effect of rounding to `step` on a prediction with normal noise of `sigma`.
#[derive(Debug, Clone, Copy)]
struct Rounding {
    /// Mean of the rounded reading minus the prediction.
    pub bias: f64,
    /// Derivative of the mean of the rounded reading by the prediction.
    pub slope: f64,
    /// Standard deviation of the rounded reading.
    pub spread: f64,
}

/// Rounding at the prediction `value`, counted from a point of the lattice.
fn rounding(value: f64, step: f64, sigma: f64) -> Rounding {
    let phase = value / step;
    let ratio = sigma / step;
    let (mut bias, mut slope) = (0.0, 1.0);
    // Second moment of the error, by the same series.
    let mut square = sigma * sigma + step * step / 12.0;
    for j in 1..=TERMS {
        let order = f64::from(j);
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        let damping = (-2.0 * (PI * order * ratio).powi(2)).exp();
        if damping < 1e-9 {
            break;
        }
        let angle = 2.0 * PI * order * phase;
        bias += sign * step / (PI * order) * damping * angle.sin();
        slope += 2.0 * sign * damping * angle.cos();
        square += sign
            * damping
            * angle.cos()
            * (step * step / (PI * PI * order * order) + 4.0 * sigma * sigma);
    }
    let variance = (square - bias * bias).max(1e-6 * step * step);
    Rounding { bias, slope, spread: variance.sqrt() }
}

/// Residuals corrected for rounding.
#[derive(Debug, Clone, PartialEq)]
struct Corrected {
    /// Residual without the rounding, one per observation.
    pub residual: Vec<f64>,
    /// Standard deviation of each over that of an unrounded reading; infinite for a reading without information.
    pub spread: Vec<f64>,
}

/// Removes the rounding from `residual`, for model predictions `predicted` (from a point of the lattice). `None` if the
/// step is too fine to matter.
fn correct(residual: &[f64], predicted: &[f64], step: f64) -> Option<Corrected> {
    let total = root_mean_square(residual);
    let fine = (total * total - step * step / 12.0).max(0.0).sqrt();
    if step < COARSE_FROM * fine {
        return None;
    }
    let sigma = likeliest_sigma(residual, predicted, step);
    let mut corrected = Vec::with_capacity(residual.len());
    let mut spread = Vec::with_capacity(residual.len());
    for (value, at) in residual.iter().zip(predicted) {
        let rounded = rounding(*at, step, sigma);
        let slope = rounded.slope.max(0.0);
        if slope < SLOPE_MIN {
            corrected.push(0.0);
            spread.push(f64::INFINITY);
        } else {
            corrected.push((value - rounded.bias) / slope);
            spread.push(rounded.spread / slope / sigma);
        }
    }
    Some(Corrected { residual: corrected, spread })
}

/// The noise before rounding under which the readings are likeliest.
fn likeliest_sigma(residual: &[f64], predicted: &[f64], step: f64) -> f64 {
    let stride = (residual.len() / 4000).max(1);
    let value = |sigma: f64| -> f64 {
        residual
            .iter()
            .zip(predicted)
            .step_by(stride)
            .map(|(value, at)| {
                // The reading is a multiple of the step; the prediction is `at`.
                let reading = at + value;
                let centre = (reading / step).round() * step;
                let upper = normal_above(-(centre + step / 2.0 - at) / sigma);
                let lower = normal_above(-(centre - step / 2.0 - at) / sigma);
                (upper - lower).max(1e-12).ln()
            })
            .sum()
    };
    (0..28)
        .map(|i| step * 0.02 * 1.25_f64.powi(i))
        .map(|sigma| (value(sigma), sigma))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(step, |(_, sigma)| sigma)
}

/// The block without the rounding of a coarse lattice, as far as `base` predicts the readings; and the step.
pub fn without_rounding(
    block: &Block,
    channels: &Channels,
    base: &[Shape],
) -> Option<(Block, f64)> {
    if block.aggregate != Aggregate::Row {
        return None;
    }
    let step = step(&block.raw)? * block.raw_si.abs();
    let mut working = block.clone();
    for _ in 0..6 {
        let layout = Layout::new(&working, channels);
        let data = Data::new(&working, channels, &layout);
        let noise = NoiseModel::white(layout.runs());
        let fitted = fit_terms(data, base, &noise);
        let left = fitted.iter().fold(block.residual.clone(), |left, found| {
            less(&left, &combine(&data.columns(&found.shape), &found.values()))
        });
        let predicted: Vec<f64> =
            left.iter().enumerate().map(|(i, left)| block.measured(i) - left).collect();
        let found = correct(&left, &predicted, step)?;
        // The corrected residual plus what the model explains.
        working.residual = found
            .residual
            .iter()
            .zip(&left)
            .zip(&block.residual)
            .map(|((corrected, left), residual)| corrected + residual - left)
            .collect();
        let says = |i: usize| block.spread.get(i).is_none_or(|spread| spread.is_finite());
        let spread = found.spread.iter().enumerate();
        working.spread =
            spread.map(|(i, found)| if says(i) { *found } else { f64::INFINITY }).collect();
    }
    Some((working, step))
}

#[cfg(test)]
mod tests {
    use super::{rounding, step};

    #[test]
    fn a_lattice_is_found_and_noise_is_not() {
        let coarse: Vec<f64> = (0..500).map(|i| (f64::from(i * i % 37)).round() * 0.003).collect();
        assert!((step(&coarse).unwrap() - 0.003).abs() < 1e-9);
        let smooth: Vec<f64> = (0..500).map(|i| (f64::from(i) * 0.7).sin()).collect();
        assert_eq!(step(&smooth), None);
    }

    #[test]
    fn the_mean_of_rounded_noise_is_what_the_series_says() {
        let (q, sigma) = (1.0, 0.2);
        for at in [0.0, 0.13, 0.31, 0.5, 0.77] {
            let (mut mean, mut square, mut weight) = (0.0, 0.0, 0.0);
            for i in -4000..=4000 {
                let e = f64::from(i) * 0.001 * 2.0;
                let w = (-0.5 * (e / sigma) * (e / sigma)).exp();
                let rounded = ((at + e) / q).round() * q;
                mean += w * rounded;
                square += w * rounded * rounded;
                weight += w;
            }
            mean /= weight;
            let spread = (square / weight - mean * mean).max(0.0).sqrt();
            let found = rounding(at, q, sigma);
            assert!((found.bias - (mean - at)).abs() < 2e-3, "{at}: {} {}", found.bias, mean - at);
            assert!((found.spread - spread).abs() < 0.02, "{at}: {} {spread}", found.spread);
        }
    }
}
