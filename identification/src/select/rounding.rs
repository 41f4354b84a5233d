//! Readings that are rounded more coarsely than their noise.

use super::data::{Data, combine};
use super::found::fit_terms;
use crate::lattice;
use crate::model::Shape;
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Aggregate, Block, Channels};

/// The block without the rounding of a coarse lattice, as far as `base` predicts the readings; and the step.
pub fn without_rounding(
    block: &Block,
    channels: &Channels,
    base: &[Shape],
) -> Option<(Block, f64)> {
    if block.aggregate != Aggregate::Row {
        return None;
    }
    let step = lattice::step(&block.raw)? * block.raw_si.abs();
    let mut working = block.clone();
    let mut corrected = None;
    for _ in 0..6 {
        let layout = Layout::new(&working, channels);
        let data = Data::new(&working, channels, &layout);
        let noise = NoiseModel::white(layout.runs());
        let fitted: Vec<(Vec<Vec<f64>>, Vec<f64>)> = fit_terms(data, base, &noise, &[])
            .iter()
            .map(|found| {
                let values = found.coefficients.iter().map(|(value, _)| *value).collect();
                (data.columns(&found.shape), values)
            })
            .collect();
        let mut left = block.residual.clone();
        for (columns, values) in &fitted {
            for (value, fitted) in left.iter_mut().zip(combine(columns, values)) {
                *value -= fitted;
            }
        }
        let predicted: Vec<f64> =
            left.iter().enumerate().map(|(i, left)| block.measured(i) - left).collect();
        let found = lattice::correct(&left, &predicted, step)?;
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
        corrected = Some(());
    }
    corrected.map(|()| (working, step))
}
