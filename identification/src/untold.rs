//! A scale that a reference does not tell: it hardly moves beside its own noise, or what it moves by is not what is measured.

use crate::dataset::{Constant, Dataset};
use crate::fit::Found;
use crate::late::delay_of;
use crate::model::{Shape, range_of};
use crate::problem::{Acts, Aggregate, Block, Channels, clusters, runs};
use crate::robust::Moments;
use crate::signal::interpolate;
use crate::units::short;

/// Standard errors of a slope within which it could be any other.
const ERRORS: f64 = 3.0;

/// Takes the scale out of `block` if its reference does not tell it; returns the notice. The readings then show all of what
/// the reference does or, if that is nearer, nothing of it.
pub(crate) fn without_scale(
    block: &mut Block,
    channels: &Channels,
    dataset: &Dataset,
) -> Option<String> {
    let is_constant = block.constants.iter().any(|known| known.acts == Acts::Scale);
    if block.aggregate != Aggregate::Row || !channels.sampled || !is_constant {
        return None;
    }
    let Slope { all: slope, error, within } = Slope::of(block, channels)?;
    let range = range_of(&scale(), channels).filter(|_| !channels.of_sensor);
    let is_physical = range.is_none_or(|[low, high]| (low..=high).contains(&(slope - 1.0)));
    // Of what shows nothing of its reference and of what shows all of it one must be excluded.
    let is_told = ERRORS * error < slope.abs().max((slope - 1.0).abs())
        && !is_noise(block, channels, dataset);
    if is_physical && is_told {
        return None;
    }
    block.is_blind = within < 0.5;
    if block.is_blind {
        let truth = &block.exposure(Acts::Scale)?.per_row;
        let moved: Vec<f64> = block.rows.iter().map(|&row| truth[row]).collect();
        block.residual.iter_mut().zip(moved).for_each(|(residual, truth)| *residual += truth);
    }
    block.constants.retain(|known| known.acts != Acts::Scale);
    block.exposures.retain(|exposure| exposure.acts != Acts::Scale);
    let (name, label) = (&channels.rotation_name, &block.label);
    let (slope, error) = (short(slope), short(error));
    let why = if is_told { "no gyro does that" } else { "that tells none" };
    let taken = if block.is_blind { "nothing" } else { "all" };
    Some(format!(
        "`{name}` does not tell the scale of `{label}`: readings rise by {slope} +- {error} of it, and {why}; they are taken to \
         show {taken} of it"
    ))
}

fn scale() -> Shape {
    Shape::constant("scale_factor", Acts::Scale)
}

/// The scale factor of readings that show nothing of what their reference does.
pub(crate) fn of_blind(block: &Block) -> Option<Found> {
    block.is_blind.then(|| Found::new(&scale(), vec![(-1.0, f64::NAN)]))
}

/// Whether the reference of a sensor moves by no more than its own noise, which makes any slope too small.
fn is_noise(block: &Block, channels: &Channels, dataset: &Dataset) -> bool {
    let is_evened = dataset.constants.contains_key(&Constant::evened(&channels.rotation_name));
    let truth = block.rows.iter().map(|&row| (channels.rotation[row], 0.0));
    let variance = Moments::of(truth).xx / block.rows.len().max(1) as f64;
    channels.of_sensor && !is_evened && variance <= 2.0 * channels.rotation_noise.powi(2)
}

/// Slope of the readings over their reference, as late as they are at first sight.
struct Slope {
    all: f64,
    /// Its standard error with errors that are alike within a run, or within a stretch if runs are few.
    error: f64,
    /// That within these, which nothing slow is in.
    within: f64,
}

impl Slope {
    fn of(block: &Block, channels: &Channels) -> Option<Self> {
        let per_row = &block.exposure(Acts::Scale)?.per_row;
        let late = delay_of(block, channels).unwrap_or(0.0);
        let segment_of_rows = channels.segment_of_rows();
        let truth = |row: usize| {
            let range = channels.segments[segment_of_rows[row]].clone();
            let times = &channels.time[range.clone()];
            interpolate(times, &per_row[range], channels.time[row] - late)
        };
        let readings = block.rows.iter().zip(&block.residual);
        let pairs: Vec<(f64, f64)> =
            readings.map(|(&row, residual)| (truth(row), per_row[row] + residual)).collect();
        let Moments { x, y, xx, xy, .. } = Moments::of(pairs.iter().copied());
        let all = xy / xx;
        let score = |(truth, reading): &(f64, f64)| (truth - x) * (reading - y - all * (truth - x));
        let run: Vec<usize> = block.rows.iter().map(|&row| channels.run[row]).collect();
        let (mut square, mut count, mut within) = (0.0, 0.0, (0.0, 0.0));
        for rows in runs(&clusters(&run)) {
            let own = Moments::of(pairs[rows.clone()].iter().copied());
            within = (within.0 + own.xy, within.1 + own.xx);
            square += pairs[rows].iter().map(score).sum::<f64>().powi(2);
            count += 1.0;
        }
        let error = (square * count / f64::max(count - 1.0, 1.0)).sqrt() / xx;
        let moves = xx > 0.0 && within.1 > 0.0;
        moves.then(|| Self { all, error, within: within.0 / within.1 })
    }
}
