//! Named errors of readings that no model corrects: rounding, and noise with a long memory.

use super::effects::word;
use super::residual;
use crate::finding::{Effect, Parameter};
use crate::model::Acts;
use crate::noise;
use crate::problem::Aggregate;
use crate::select::{BlockFit, Data, Found};

/// Readings in steps coarser than their noise.
pub(crate) fn rounding(data: Data<'_>, fit: &BlockFit, step: f64) -> Effect {
    let unit = &data.block.unit;
    let parameter = Parameter {
        name: "step".to_owned(),
        value: step / unit.si,
        standard_error: None,
        unit: unit.text.clone(),
        range: None,
    };
    effect(data, fit, ("rounding", Acts::Quantisation), vec![parameter], 0.0)
}

/// Noise whose memory is a considerable part of the record, or infinite.
pub(crate) struct SlowNoise {
    /// Its entry among the effects.
    pub effect: Effect,
    /// What else it may be.
    pub notice: Option<String>,
}

/// Risk of naming slow noise where there is no such noise, for a whole data set.
const RISK: f64 = 0.005;
/// Probability below which a kind of slow noise is excluded.
const EXCLUDED: f64 = 0.05;

/// Slow noise, if it is significant; `share` is this quantity's share of the risk of a false alarm.
pub(crate) fn slow_noise(data: Data<'_>, fit: &BlockFit, share: f64) -> Option<SlowNoise> {
    if data.block.aggregate != Aggregate::Row {
        return None;
    }
    let all: Vec<Found> = fit.base.iter().chain(&fit.effects).cloned().collect();
    let columns = data.all_columns(&fit.shapes());
    let left = residual(data, &all);
    let slow = noise::slow(data.layout, &left, &columns, &fit.noise, &fit.left_out)?;
    let p_value = (-slow.surprise).exp();
    if !(p_value < RISK * share) {
        return None;
    }
    let unit = &data.block.unit;
    let second = data.channels.time_unit.text();
    let time = if second == "1" { "sample" } else { second };
    let parameter = |name: String, value: f64, standard_error, unit: &str| Parameter {
        name,
        value,
        standard_error,
        unit: unit.to_owned(),
        range: None,
    };
    // From the logarithm of a variance to a standard deviation.
    let relative = 0.5 * slow.log_error;
    let after_1 = slow.variance_per_s.sqrt() / unit.si;
    let error = Some(relative * after_1);
    let steps = parameter(format!("after_1_{time}"), after_1, error, &unit.text);
    let is_open = slow.other > EXCLUDED;
    let (name, parameters) = match slow.correlation_s {
        _ if is_open => ("slow_noise", vec![steps]),
        None => ("random_walk", vec![steps]),
        Some(memory) => {
            let deviation = (0.5 * slow.variance_per_s * memory).sqrt() / unit.si;
            let error = Some(relative * deviation);
            let size = parameter("deviation".to_owned(), deviation, error, &unit.text);
            let memory = parameter("correlation_time".to_owned(), memory, None, second);
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
    let error = fit.nested.first().map_or(0.0, |metric| metric.errors.rmse() / metric.unit.si);
    Effect {
        name: name.to_owned(),
        known: true,
        term: word(acts),
        axis: data.block.axis,
        drivers: Vec::new(),
        form: name.to_owned(),
        knots: Vec::new(),
        knots_2: Vec::new(),
        parameters,
        p_value,
        held_out_before: error,
        held_out_after: error,
        rivals: Vec::new(),
    }
}
