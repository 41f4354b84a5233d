//! The paths of all blocks as one, in the form of the contract.

use crate::finding::{PathError, PathModel};
use crate::select::{BlockFit, Waypoint};

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
