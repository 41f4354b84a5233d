//! Named errors of readings that no model corrects: rounding, and noise with a long memory.

use super::effects::word;
use crate::finding::{Effect, Parameter};
use crate::fit::{Data, residual};
use crate::judge::Metric;
use crate::model::Acts;
use crate::noise::{self, Residual};
use crate::problem::{self, Aggregate};
use crate::select::BlockFit;
use crate::significance::surprise;

/// Readings in steps coarser than their noise.
pub(crate) fn rounding(data: Data<'_>, fit: &BlockFit, step: f64) -> Effect {
    let unit = &data.block.unit;
    let parameter = Parameter::new("step", step / unit.si, &unit.text);
    effect(data, fit, ("rounding", Acts::Quantisation), vec![parameter], 0.0)
}

/// Minimum number of runs, and of readings in each, to tell their offsets.
const RUNS_MIN: usize = 5;
const READINGS_MIN: usize = 20;
/// Surprise from which means within a run differ by more than noise without a memory makes them differ, in nats: 1 %.
const WANDERS: f64 = 4.6;

/// An offset that differs from run to run and stays within each.
pub(crate) struct OffsetOfRuns {
    pub effect: Effect,
    /// Its standard deviation, SI.
    pub deviation: f64,
}

impl OffsetOfRuns {
    /// Whether it is certain at this `share` of the risk of a false alarm.
    pub fn is_certain(&self, share: f64) -> bool {
        self.effect.p_value < RISK * share
    }
}

/// An offset that differs from run to run and stays within each, if it is certain at the whole risk of a false alarm.
///
/// Means of half a run are compared with their neighbour in the same run and in the next one: noise of any memory makes
/// both pairs differ alike, and only an offset of the run makes the second differ more.
pub(crate) fn offset_of_runs(data: Data<'_>, fit: &BlockFit) -> Option<OffsetOfRuns> {
    if data.block.aggregate != Aggregate::Row {
        return None;
    }
    let all = fit.all();
    let left = residual(data, &all);
    let Offsets { within, across, readings, runs } = Offsets::of(&left, &data.layout.run)?;
    // Half a run has half its readings; two of its means differ by twice the variance of one.
    let white = 4.0 * fit.floor.powi(2) / readings;
    let pairs = runs as f64;
    let wanders = !(surprise(within / white, pairs, 1e6) < WANDERS);
    let p_value = (-surprise(across / within.max(white), pairs - 1.0, pairs)).exp();
    if wanders || !(p_value < RISK) {
        return None;
    }
    let deviation = ((across - within) / 2.0).max(0.0).sqrt();
    let unit = &data.block.unit;
    let parameter = Parameter {
        // Of a standard deviation from that many values.
        standard_error: Some(deviation / (2.0 * (pairs - 1.0)).sqrt() / unit.si),
        ..Parameter::new("deviation", deviation / unit.si, &unit.text)
    };
    let effect = effect(data, fit, ("offset_of_runs", Acts::Noise), vec![parameter], p_value);
    Some(OffsetOfRuns { effect, deviation })
}

/// Mean squares of differences between means of half a run.
struct Offsets {
    /// In the same run.
    within: f64,
    /// Of two runs, one after the other.
    across: f64,
    /// Mean number of readings of a run.
    readings: f64,
    runs: usize,
}

impl Offsets {
    fn of(left: &[f64], run: &[usize]) -> Option<Self> {
        let mut halves: Vec<[f64; 2]> = Vec::new();
        for rows in problem::runs(run) {
            if rows.len() < READINGS_MIN {
                return None;
            }
            let middle = usize::midpoint(rows.start, rows.end);
            let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
            halves.push([mean(&left[rows.start..middle]), mean(&left[middle..rows.end])]);
        }
        let runs = halves.len();
        if runs < RUNS_MIN {
            return None;
        }
        let square = |differences: Vec<f64>| {
            differences.iter().map(|one| one * one).sum::<f64>() / differences.len() as f64
        };
        Some(Self {
            within: square(halves.iter().map(|[first, last]| last - first).collect()),
            across: square(halves.windows(2).map(|pair| pair[1][0] - pair[0][1]).collect()),
            readings: run.len() as f64 / runs as f64,
            runs,
        })
    }
}

/// Noise whose memory is a considerable part of the record, or infinite.
pub(crate) struct SlowNoise {
    /// Its entry among the effects.
    pub effect: Effect,
    /// What else it may be.
    pub notice: Option<String>,
}

/// Risk of naming slow noise where there is no such noise, for a whole data set: as that of an effect.
const RISK: f64 = 0.011;
/// Probability below which a kind of slow noise is excluded.
const EXCLUDED: f64 = 0.05;

/// Slow noise, if it is significant; `share` is this quantity's share of the risk of a false alarm.
pub(crate) fn slow_noise(data: Data<'_>, fit: &BlockFit, share: f64) -> Option<SlowNoise> {
    if data.block.aggregate != Aggregate::Row {
        return None;
    }
    let all = fit.all();
    let columns = data.all_columns(&fit.shapes());
    let left = residual(data, &all);
    let slow = noise::slow(
        Residual { layout: data.layout, values: &left, columns: &columns },
        &fit.noise,
    )?;
    let p_value = (-slow.surprise).exp();
    if !(p_value < RISK * share) {
        return None;
    }
    let unit = &data.block.unit;
    let second = data.channels.time_unit.text();
    let time = if second == "1" { "sample" } else { second };
    let parameter = |name: &str, value: f64, standard_error, unit: &str| Parameter {
        standard_error,
        ..Parameter::new(name, value, unit)
    };
    // From the logarithm of a variance to a standard deviation.
    let relative = 0.5 * slow.log_error;
    let after_1 = slow.variance_per_s.sqrt() / unit.si;
    let error = Some(relative * after_1);
    let steps = parameter(&format!("after_1_{time}"), after_1, error, &unit.text);
    let is_open = slow.other > EXCLUDED;
    let (name, parameters) = match slow.correlation_s {
        _ if is_open => ("slow_noise", vec![steps]),
        None => ("random_walk", vec![steps]),
        Some(memory) => {
            let deviation = (0.5 * slow.variance_per_s * memory).sqrt() / unit.si;
            let error = Some(relative * deviation);
            let size = parameter("deviation", deviation, error, &unit.text);
            let memory = parameter("correlation_time", memory, None, second);
            ("correlated_noise", vec![size, memory])
        }
    };
    let notice = is_open.then(|| {
        let walks = if slow.correlation_s.is_none() { 1.0 - slow.other } else { slow.other };
        format!(
            "whether the slow noise of `{}` ever forgets is open (a random walk: {:.0} %); a record that is some times \
             as long would tell",
            data.block.label,
            100.0 * walks
        )
    });
    Some(SlowNoise { effect: effect(data, fit, (name, Acts::Noise), parameters, p_value), notice })
}

fn effect(
    data: Data<'_>,
    fit: &BlockFit,
    (name, acts): (&str, Acts),
    parameters: Vec<Parameter>,
    p_value: f64,
) -> Effect {
    let error = fit.nested.first().map_or(0.0, Metric::value);
    Effect {
        axis: data.block.axis,
        parameters,
        p_value,
        held_out_before: error,
        held_out_after: error,
        ..Effect::new(name, &word(acts), name)
    }
}
