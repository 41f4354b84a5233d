//! From the chosen terms to their values, errors and rivals.

use super::choose::{Contender, contenders, simplicity};
use super::found::BlockFit;
use super::jointly::Joint;
use super::material::Material;
use super::roughly::{Estimates, estimates_of};
use super::scene::Scene;
use super::state::State;
use crate::fit::{Data, Found, RivalFound, combine, robust_fit};
use crate::judge::{Metric, margin};
use crate::model::{Driver, Form};
use crate::robust;
use crate::significance::surprise_chi2;

/// Values and errors of `joint`, and rivals of the terms of `state`, whose residual is noise: the same terms as they were
/// chosen.
pub(super) fn of_noise(state: &State<'_>, joint: &Joint<'_>, left: Vec<Contender>) -> BlockFit {
    let mut found = values(joint);
    for index in state.base..state.terms.len() {
        let (scene, mine) = state.beside_others(index);
        found[index].strength = mine.strength;
        found[index].rivals = rivals(&scene, &mine, &contenders(&scene));
    }
    let scene = state.scene(&state.terms);
    BlockFit::new(state, found, (scene.floor(&state.noise), scene.scale), left)
}

/// Values of the terms, with errors.
fn values(joint: &Joint<'_>) -> Vec<Found> {
    let data = joint.state.data;
    let mut white = joint.white.clone();
    if let Some(closing) = &data.block.closing {
        // The lever comes from the same ends of laps: its fit carries little information on the size of their error.
        let fitted = combine(&data.all_columns(&joint.state.terms), &joint.coefficients);
        let by_lever = |(fitted, component): (&f64, &usize)| match component {
            0 => 0.0,
            _ => *fitted,
        };
        let by_lever: Vec<f64> = fitted.iter().zip(&closing.component).map(by_lever).collect();
        // Without a term, the lever has nothing to act on.
        if !by_lever.is_empty() {
            white.push(joint.whitener.apply(&by_lever));
        }
    }
    joint.found(&robust_fit(&white, &joint.left).errors)
}

/// Maximum distance of a rival behind the effect, in nats.
const BEHIND_MAX: f64 = 12.0;
/// Maximum surprise that the effect adds to a rival: what chi-squared exceeds once in 200 times.
const ADDS_MAX: f64 = 5.3;
/// Maximum number of rivals named.
const RIVALS_MAX: usize = 6;
/// Number of contenders examined.
const LOOKED_AT: usize = 60;

/// Contenders in `scene` (the model without the effect) to which the effect adds nothing.
fn rivals(scene: &Scene<'_>, mine: &Contender, contenders: &[Contender]) -> Vec<RivalFound> {
    let effect = &mine.candidate.shape;
    let best = mine.rank;
    let columns = scene.data.columns(effect);
    let statistic = scene.score_columns(&columns).statistic;
    let mut found: Vec<RivalFound> = Vec::new();
    for contender in contenders.iter().take(LOOKED_AT) {
        let shape = &contender.candidate.shape;
        let is_wide = matches!(shape.form, Form::Spline | Form::Surface);
        let same = shape.acts == effect.acts && same_drivers(&shape.drivers, &effect.drivers);
        let named_already = found.iter().any(|rival| {
            rival.shape.acts == shape.acts && same_drivers(&rival.shape.drivers, &shape.drivers)
        });
        // A wide or unnamed shape can imitate anything: it is a rival only to its like.
        let unfair = (is_wide || !shape.known) && effect.known;
        if same
            || named_already
            || unfair
            || contender.score.statistic < statistic - 2.0 * BEHIND_MAX
        {
            continue;
        }
        let beside = scene.with(&scene.data.columns(shape));
        let adds = beside.score_columns(&columns);
        if surprise_chi2(adds.statistic, adds.width.max(1) as f64) < ADDS_MAX {
            found.push(RivalFound {
                shape: shape.clone(),
                behind: (best - contender.rank).max(0.0),
            });
        }
        if found.len() == RIVALS_MAX {
            break;
        }
    }
    found
}

fn same_drivers(a: &[Driver], b: &[Driver]) -> bool {
    a.len() == b.len() && a.iter().all(|driver| b.contains(driver))
}

/// Values and errors of `joint`, and rivals of the terms of `state`, whose residual is not noise; `metrics` judged it.
pub(super) fn of_structure(
    material: &Material<'_>,
    (state, joint): (&State<'_>, &Joint<'_>),
    metrics: &[Metric],
) -> BlockFit {
    let Estimates { mut terms, left } = estimates_of(joint);
    for index in state.base..terms.len() {
        terms[index].rivals = as_good(material, state, index, metrics);
    }
    let floor = white_part(state.data, &left);
    BlockFit::new(state, terms, (floor, floor), Vec::new())
}

/// Causes that predict as well in the place of a term.
fn as_good(
    material: &Material<'_>,
    state: &State<'_>,
    index: usize,
    metrics: &[Metric],
) -> Vec<RivalFound> {
    let mut without = state.clone();
    let effect = without.remove(index);
    let mut found: Vec<RivalFound> = material
        .contenders(&material.fitted(without))
        .into_iter()
        .filter_map(|(next, judged)| {
            let shape = next.terms.last()?.clone();
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
            (!shape.says(&effect) && as_good && fair).then_some(RivalFound { shape, behind })
        })
        .collect();
    found.sort_by(|a, b| a.behind.total_cmp(&b.behind));
    found
}

/// Standard deviation of the white part of the residual: for rows, from consecutive differences, in which slow noise
/// cancels. A reading that is held over several rows is new in the first of them.
fn white_part(data: Data<'_>, left: &[f64]) -> f64 {
    if data.layout.is_level() {
        return robust::spread(left);
    }
    let (run, raw) = (&data.layout.run, &data.block.raw);
    let follows = |i: &usize| run[*i] == run[*i - 1] && left[*i] != 0.0 && left[*i - 1] != 0.0;
    let mut rows: Vec<usize> = (1..left.len()).filter(follows).collect();
    let moves = |i: &usize| raw.get(*i).zip(raw.get(*i - 1)).map_or(1.0, |(now, last)| now - last);
    if are_held(&rows.iter().map(moves).collect::<Vec<f64>>()) {
        rows.retain(|i| moves(i) != 0.0);
    }
    let step = |i: usize| (left[i] - left[i - 1]) * std::f64::consts::FRAC_1_SQRT_2;
    robust::spread(&rows.into_iter().map(step).collect::<Vec<f64>>())
}

/// Whether readings that differ so from the one before are held over several rows: most repeat it, and not because they are
/// rounded to steps as coarse as that.
fn are_held(moves: &[f64]) -> bool {
    let new: Vec<f64> = moves.iter().filter(|by| **by != 0.0).map(|by| by.abs()).collect();
    let least = new.iter().copied().fold(f64::INFINITY, f64::min);
    !new.is_empty() && 2 * new.len() < moves.len() && robust::median(new) > 2.0 * least
}

#[cfg(test)]
mod tests {
    use super::are_held;

    #[test]
    fn rounded_readings_are_not_held() {
        let moves = |of: fn(f64) -> f64| -> Vec<f64> {
            (1..400).map(|row| of(f64::from(row)) - of(f64::from(row - 1))).collect()
        };
        let smooth = |row: f64| 20.0 * (row / 9.0).sin();
        assert!(are_held(&moves(|row| 20.0 * ((row / 4.0).floor() / 2.0).sin())));
        assert!(!are_held(&moves(|row| (20.0 * (row / 90.0).sin()).round())));
        assert!(!are_held(&moves(smooth)));
        assert!(!are_held(&[0.0; 10]));
    }
}
