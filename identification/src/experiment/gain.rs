//! What a plan gains for pairs of causes.

use super::case::{Case, Doubt};
use super::contest::{lambda, probability};
use super::step::Programme;
use super::surroundings::Thermal;
use super::{planned, timeline};
use crate::dataset::Dataset;
use crate::fit::Data;
use crate::model::Acts;
use crate::noise::{Layout, NoiseModel, Whitener};
use crate::problem::{Aggregate, Block, Channel, Channels, Problem};
use crate::signal::Smooth;

/// What a plan gains for a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gain {
    /// Distance on the given rows.
    pub now: f64,
    /// Distance on the given and the planned rows.
    pub then: f64,
    /// Probability that the wrong cause is then refused, whichever it is.
    pub probability: f64,
}

/// What `programme` gains for each case; `None` if data of this kind do not show the programme.
pub(super) fn gains(
    dataset: &Dataset,
    problem: &Problem,
    doubts: &[Doubt<'_>],
    programme: &Programme,
    cases: &[Case],
) -> Option<Vec<Gain>> {
    let thermal = Thermal::of(dataset);
    let phases = timeline::phases(programme, thermal);
    let celsius = |phase: &timeline::Phase, time: f64| {
        thermal.after(phase.celsius, phase.ambient, time - phase.start)
    };
    let interval = problem.channels.interval();
    let mut gains = vec![None; cases.len()];
    for (index, doubt) in doubts.iter().enumerate() {
        if cases.iter().all(|case| case.doubt != index) {
            continue;
        }
        let given = doubt.data.block;
        let rows = planned::planned(dataset, interval, given.axis, &phases, celsius)?;
        let mut ahead = Problem::new(&rows.dataset, problem.known()).ok()?;
        complete(&mut ahead.channels, &rows.dataset, doubt.data.channels);
        let block = ahead.blocks.iter().find(|block| block.label == given.label)?;
        let layout = Layout::new(block, ahead.channels_of(block));
        let noise = noise_of_means(&doubt.fit.noise, given, block, rows.samples, layout.runs());
        let whitener = Whitener::new(&layout, &noise);
        let data = Data::new(block, ahead.channels_of(block), &layout);
        for (case, gain) in cases.iter().zip(&mut gains).filter(|(case, _)| case.doubt == index) {
            let both = [0, 1].map(|way: usize| {
                let seen = case.contests[way].seen(data, &whitener, case.sigma, true);
                let then = lambda(&[&case.given[way], &seen]);
                (then, probability(then, case.widths[way]))
            });
            *gain = Some(Gain {
                now: case.now,
                then: both[0].0.min(both[1].0),
                probability: both[0].1.min(both[1].1),
            });
        }
    }
    gains.into_iter().collect()
}

/// Noise of planned rows that are each the mean of `samples`. Coloured noise is stated for the mean duration of the
/// rows of a block, which may differ in the planned block.
fn noise_of_means(
    noise: &NoiseModel,
    given: &Block,
    planned: &Block,
    samples: f64,
    runs: usize,
) -> NoiseModel {
    let mut noise = noise.of_all();
    noise.run_scale = vec![1.0; runs];
    if planned.aggregate == Aggregate::Level {
        return noise;
    }
    if noise.coloured.is_empty() {
        noise.run_scale = vec![samples.sqrt().recip(); runs];
        return noise;
    }
    noise.white /= samples;
    let duration = |block: &Block| {
        let bias = block.exposure(Acts::Bias)?;
        let sum: f64 = block.rows.iter().map(|&row| bias.per_row[row]).sum();
        Some(sum / block.rows.len().max(1) as f64)
    };
    if let (Some(before), Some(after)) = (duration(given), duration(planned))
        && before > 0.0
    {
        noise.coloured.iter_mut().for_each(|part| part.variance *= (after / before).powi(2));
    }
    noise
}

/// Adds causes that a plan holds constant: they are not channels there.
fn complete(channels: &mut Channels, rows: &Dataset, given: &Channels) {
    for channel in &given.channels {
        if channels.named(&channel.name).is_some() {
            continue;
        }
        let count = channels.time.len();
        let values: Vec<f64> = rows
            .named(&channel.name)
            .map_or_else(|| vec![0.0; count], |column| column.si().collect());
        let range = (values[0], values[0]);
        let smooth = Smooth { level: values.clone(), slope: vec![0.0; count] };
        channels.channels.push(Channel { values, smooth, range, ..channel.clone() });
    }
}
