//! What readings do that no model mends and that has a name: rounding.

use super::effects::word;
use crate::finding::{Effect, Parameter};
use crate::model::Acts;
use crate::select::{BlockFit, Data};

/// Readings in steps that are coarser than their noise.
pub(crate) fn rounding(data: Data<'_>, fit: &BlockFit, step: f64) -> Effect {
    let unit = &data.block.unit;
    let error = fit.nested.first().map_or(0.0, |metric| metric.errors.rmse() / metric.unit.si);
    Effect {
        name: "rounding".to_owned(),
        known: true,
        term: word(Acts::Quantisation),
        axis: data.block.axis,
        drivers: Vec::new(),
        form: "rounding".to_owned(),
        knots: Vec::new(),
        knots_2: Vec::new(),
        parameters: vec![Parameter {
            name: "step".to_owned(),
            value: step / unit.si,
            standard_error: None,
            unit: unit.text.clone(),
            range: None,
        }],
        p_value: 0.0,
        held_out_before: error,
        held_out_after: error,
        rivals: Vec::new(),
    }
}
