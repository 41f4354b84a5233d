//! Effects, terms, and the paths of all blocks as one, in the form of the contract.

use crate::finding::{Effect, Parameter, PathError, PathModel, Rival};
use crate::fit::{Data, Found};
use crate::model::{Form, Term, UNEQUAL_WHEELS, exposure};
use crate::problem::DisplayUnit;
use crate::select::{BlockFit, Waypoint};
use serde::Serialize;

/// The contract's word for a form, or for what a term acts on.
pub(super) fn word(of: impl Serialize) -> String {
    let value = toml::Value::try_from(of).ok();
    value.and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// A term of the model.
pub(crate) fn term(data: Data<'_>, found: &Found) -> Term {
    let unit = exposure(data.block, found.shape.acts)
        .map_or_else(DisplayUnit::one, |exposure| exposure.unit.clone());
    let shape = found.shape.clone().within_seen(data.channels);
    let Found { coefficients, numbers, .. } = found;
    let mut term = Term::from_shape(&shape, coefficients, numbers, &unit, data.channels);
    term.axis = data.block.axis;
    term.quantity.clone_from(&data.block.apart);
    term
}

/// By how much the right wheel is larger than the left one: what a user can measure, and how their bend comes about.
fn between_wheels(data: Data<'_>, found: &Found) -> Option<Parameter> {
    let half = data.block.pose.as_ref()?.half_track?;
    let is_bend = found.shape.name == UNEQUAL_WHEELS && found.shape.form == Form::Constant;
    let (bend, error) = *found.coefficients.first().filter(|_| is_bend)?;
    let error = 2.0 * half * error;
    Some(Parameter {
        standard_error: error.is_finite().then_some(error),
        ..Parameter::new("difference", 2.0 * half * bend, "1")
    })
}

/// An effect of the finding.
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
        known: found.shape.known,
        axis: data.block.axis,
        drivers: found.shape.drivers.iter().map(ToString::to_string).collect(),
        knots: term.knots,
        knots_2: term.knots_2,
        parameters: term.parameters.into_iter().chain(between_wheels(data, found)).collect(),
        p_value: (-found.strength).exp().min(1.0),
        held_out_before: before,
        held_out_after: after,
        rivals,
        ..Effect::new(&found.shape.name, &word(found.shape.acts), &word(found.shape.form))
    }
}

/// Moves a straight line over a driver before the constant beside it, which only states the zero of the line.
pub(crate) fn lines_before_their_zero(effects: &mut Vec<Effect>) {
    for at in 0..effects.len() {
        let constant = &effects[at];
        if !constant.drivers.is_empty() {
            continue;
        }
        let is_line = |other: &Effect| {
            other.form == word(Form::Linear)
                && !other.drivers.is_empty()
                && (&other.term, other.axis) == (&constant.term, constant.axis)
        };
        if let Some(later) = effects[at..].iter().position(is_line) {
            let line = effects.remove(at + later);
            effects.insert(at, line);
        }
    }
}

/// Models of all blocks together, from plain to rich: each adds the term that helps most, until every block is at its
/// chosen model; then the further ones.
pub(crate) fn path(fits: &[&BlockFit]) -> Vec<PathModel> {
    let mut at = vec![0; fits.len()];
    let mut models = Vec::new();
    let chosen: Vec<usize> = fits.iter().map(|fit| fit.chosen).collect();
    let ends: Vec<usize> = fits.iter().map(|fit| fit.path.len() - 1).collect();
    for (goal, is_last) in [(&chosen, false), (&ends, true)] {
        loop {
            let is_chosen = at == chosen;
            models.push(model(fits, &at, is_chosen));
            let ahead = (0..fits.len()).filter(|&block| at[block] < goal[block]);
            let fall = |block: &usize| fall(&fits[*block].path[at[*block]..][..2]);
            let Some(next) = ahead.max_by(|a, b| fall(a).total_cmp(&fall(b))) else { break };
            at[next] += 1;
        }
        if !is_last {
            // The second part starts with the chosen model.
            models.pop();
        }
    }
    models
}

/// Logarithm by which the error falls from one model to the next.
fn fall(pair: &[Waypoint]) -> f64 {
    let [before, after] = pair else { return 0.0 };
    let errors = before.metrics.iter().zip(&after.metrics);
    errors
        .map(|(a, b)| (a.errors.rmse() / b.errors.rmse().max(f64::MIN_POSITIVE)).ln())
        .fold(f64::NEG_INFINITY, f64::max)
}

fn model(fits: &[&BlockFit], at: &[usize], chosen: bool) -> PathModel {
    let points = || fits.iter().zip(at).map(|(fit, &at)| &fit.path[at]);
    let errors = points().flat_map(|point| {
        point.metrics.iter().zip(&point.margins).map(|(metric, margin)| {
            let (value, si) = (metric.errors.rmse(), metric.unit.si);
            let error = PathError {
                value: value / si,
                // Converted from a mean square to a root.
                standard_error: ((value * value + margin).sqrt() - value) / si,
                unit: metric.unit.text.clone(),
            };
            (metric.name.clone(), error)
        })
    });
    PathModel {
        effects: points().flat_map(|point| point.effects.iter().cloned()).collect(),
        held_out: errors.collect(),
        chosen,
    }
}

#[cfg(test)]
mod tests {
    use super::lines_before_their_zero;
    use crate::finding::Effect;

    fn effect(term: &str, driver: Option<&str>) -> Effect {
        Effect {
            name: format!("{term}_{}", driver.unwrap_or("constant")),
            known: true,
            term: term.to_owned(),
            axis: None,
            drivers: driver.into_iter().map(str::to_owned).collect(),
            form: if driver.is_some() { "linear" } else { "constant" }.to_owned(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: Vec::new(),
            p_value: 0.0,
            held_out_before: 0.0,
            held_out_after: 0.0,
            rivals: Vec::new(),
        }
    }

    fn order(effects: Vec<Effect>) -> Vec<String> {
        let mut effects = effects;
        lines_before_their_zero(&mut effects);
        effects.into_iter().map(|effect| effect.name).collect()
    }

    #[test]
    fn a_line_goes_before_the_constant_that_is_its_zero() {
        let turn = || effect("turn", None);
        let line = || effect("turn", Some("temperature"));
        let other = || effect("drive", Some("temperature"));
        assert_eq!(order(vec![turn(), line()]), ["turn_temperature", "turn_constant"]);
        assert_eq!(order(vec![line(), turn()]), ["turn_temperature", "turn_constant"]);
        assert_eq!(
            order(vec![turn(), other(), line()]),
            ["turn_temperature", "turn_constant", "drive_temperature"]
        );
        assert_eq!(order(vec![turn(), other()]), ["turn_constant", "drive_temperature"]);
    }
}
