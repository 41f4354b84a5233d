//! The report on a residual that is not noise, with rivals that predict held-out data as well.

use super::Material;
use crate::judge::{Metric, margin};
use crate::robust;
use crate::select::choose::simplicity;
use crate::select::data::Data;
use crate::select::found::BlockFit;
use crate::select::rivals::RivalFound;
use crate::select::roughly::{Estimates, estimates};
use crate::select::state::State;

impl Material<'_> {
    /// Values, errors and rivals of the terms of `state`, which `metrics` judged.
    pub fn finish(&self, state: &State<'_>, metrics: &[Metric]) -> BlockFit {
        let Estimates { mut terms, left } = estimates(state);
        for index in state.base..terms.len() {
            terms[index].rivals = self.rivals(state, index, metrics);
        }
        let effects = terms.split_off(state.base);
        let floor = floor(state.data, &left);
        BlockFit {
            base: terms,
            effects,
            applied: Vec::new(),
            noise: state.noise.clone(),
            floor,
            scale: floor,
            left: Vec::new(),
            left_out: state.left_out.clone(),
            path: Vec::new(),
            chosen: 0,
            nested: Vec::new(),
            goes: None,
        }
    }

    /// Causes that predict as well in the place of a term.
    fn rivals(&self, state: &State<'_>, index: usize, metrics: &[Metric]) -> Vec<RivalFound> {
        let mut without = state.clone();
        let effect = without.terms.remove(index);
        without.families.remove(index - state.base);
        let without = self.fitted(without);
        let mut found: Vec<RivalFound> = self
            .contenders(&without)
            .into_iter()
            .filter_map(|(next, judged)| {
                let shape = next.terms.last()?.clone();
                let same = shape.acts == effect.acts
                    && shape.drivers == effect.drivers
                    && shape.form == effect.form;
                let as_good = judged
                    .iter()
                    .zip(metrics)
                    .all(|(its, mine)| its.errors.beyond(&mine.errors).0 <= margin(its, mine));
                let behind = judged
                    .iter()
                    .zip(metrics)
                    .map(|(its, mine)| {
                        let (more, error) = its.errors.beyond(&mine.errors);
                        if more > 0.0 { 0.5 * (more / error).powi(2) } else { 0.0 }
                    })
                    .fold(0.0, f64::max);
                let behind = (behind + simplicity(&effect) - simplicity(&shape)).max(0.0);
                let fair = shape.known || !effect.known;
                (!same && as_good && fair).then_some(RivalFound { shape, behind })
            })
            .collect();
        found.sort_by(|a, b| a.behind.total_cmp(&b.behind));
        found
    }
}

/// Standard deviation of the white part of the residual: for rows, from consecutive differences, in which slow noise
/// cancels.
fn floor(data: Data<'_>, left: &[f64]) -> f64 {
    let run = &data.layout.run;
    let steps: Vec<f64> = (1..left.len())
        .filter(|&i| run[i] == run[i - 1] && left[i] != 0.0 && left[i - 1] != 0.0)
        .map(|i| (left[i] - left[i - 1]) * std::f64::consts::FRAC_1_SQRT_2)
        .collect();
    if data.layout.is_level() { robust::spread(left) } else { robust::spread(&steps) }
}
