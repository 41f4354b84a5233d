//! What readings do that no model mends and that has a name: rounding, and noise that walks.

use super::effects::word;
use super::residual;
use crate::finding::{Effect, Parameter};
use crate::model::Acts;
use crate::noise;
use crate::problem::Aggregate;
use crate::select::{BlockFit, Data, Found, RISK};

/// Readings in steps that are coarser than their noise.
pub(crate) fn rounding(data: Data<'_>, fit: &BlockFit, step: f64) -> Effect {
    let unit = &data.block.unit;
    let parameter = Parameter {
        name: "step".to_owned(),
        value: step / unit.si,
        standard_error: None,
        unit: unit.text.clone(),
        range: None,
    };
    effect(data, fit, ("rounding", Acts::Quantisation), parameter, 0.0)
}

/// Noise that walks, where that is no chance: `share` is the share of the risk that this quantity has.
pub(crate) fn random_walk(data: Data<'_>, fit: &BlockFit, share: f64) -> Option<Effect> {
    if data.block.aggregate != Aggregate::Row {
        return None;
    }
    let all: Vec<Found> = fit.base.iter().chain(&fit.effects).cloned().collect();
    let columns = data.all_columns(&fit.shapes());
    let left = residual(data, &all);
    let walk = noise::walk(data.layout, &left, &columns, &fit.noise, &fit.left_out)?;
    let unit = &data.block.unit;
    let after_1 = walk.variance_per_s.sqrt() / unit.si;
    let time = match data.channels.time_unit.text() {
        "1" => "sample",
        text => text,
    };
    let parameter = Parameter {
        name: format!("after_1_{time}"),
        value: after_1,
        // Of a logarithm of a square.
        standard_error: Some(0.5 * walk.log_error * after_1),
        unit: unit.text.clone(),
        range: None,
    };
    let p_value = (-walk.strength).exp();
    (p_value < RISK * share)
        .then(|| effect(data, fit, ("random_walk", Acts::Noise), parameter, p_value))
}

fn effect(
    data: Data<'_>,
    fit: &BlockFit,
    (name, acts): (&str, Acts),
    parameter: Parameter,
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
        parameters: vec![parameter],
        p_value,
        held_out_before: error,
        held_out_after: error,
        rivals: Vec::new(),
    }
}
