//! Effects and terms as the contract writes them.

use crate::finding::{Effect, Rival};
use crate::model::{Fitted, Term, exposure};
use crate::problem::DisplayUnit;
use crate::select::{Data, Found};

fn word(acts: crate::model::Acts) -> String {
    toml::Value::try_from(acts)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}

fn form(form: crate::model::Form) -> String {
    toml::Value::try_from(form)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}

/// The term of the model.
pub(crate) fn term(data: Data<'_>, found: &Found) -> Term {
    let unit = exposure(data.block, found.shape.acts)
        .map_or_else(|| DisplayUnit::new("1", 1.0), |exposure| exposure.unit.clone());
    let coefficients: Vec<Fitted> = found
        .coefficients
        .iter()
        .map(|(value, error)| Fitted { value: *value, error: *error })
        .collect();
    let mut term =
        Term::from_shape(&found.shape, &coefficients, &found.numbers, &unit, data.channels);
    term.axis = data.block.axis;
    term.quantity.clone_from(&data.block.apart);
    term
}

/// The effect of the finding.
pub(crate) fn effect(data: Data<'_>, found: &Found, before: f64, after: f64) -> Effect {
    let term = term(data, found);
    let weight = |behind: f64| (-behind).exp();
    let total: f64 = 1.0 + found.rivals.iter().map(|rival| weight(rival.behind)).sum::<f64>();
    let rivals = found
        .rivals
        .iter()
        .map(|rival| Rival {
            name: rival.shape.name.clone(),
            term: word(rival.shape.acts),
            drivers: rival.shape.drivers.iter().map(ToString::to_string).collect(),
            probability: weight(rival.behind) / total,
            separated_by: None,
        })
        .collect();
    Effect {
        name: found.shape.name.clone(),
        known: found.shape.known,
        term: word(found.shape.acts),
        axis: data.block.axis,
        drivers: found.shape.drivers.iter().map(ToString::to_string).collect(),
        form: form(found.shape.form),
        knots: term.knots,
        knots_2: term.knots_2,
        parameters: term.parameters,
        p_value: (-found.strength).exp().min(1.0),
        held_out_before: before,
        held_out_after: after,
        rivals,
    }
}
