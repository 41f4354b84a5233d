//! What else could have been the cause.

use super::choose::Contender;
use super::scene::Scene;
use crate::model::{Driver, Form, Shape};
use crate::significance::surprise_chi2;

/// A rival explains at most this much less than the effect, in nats.
const BEHIND_MAX: f64 = 12.0;
/// The effect adds less than this to a rival, as a surprise: what chi-squared exceeds once in 200 times.
const ADDS_MAX: f64 = 5.3;
/// Rivals that are named, at most.
const RIVALS_MAX: usize = 6;
/// Contenders that are looked at.
const LOOKED_AT: usize = 60;

/// Another cause that the data cannot exclude.
#[derive(Debug, Clone)]
pub struct RivalFound {
    /// What it is.
    pub shape: Shape,
    /// By how much it ranks behind the effect, in nats.
    pub behind: f64,
}

/// Contenders in `scene` (the model without the effect) that the effect adds nothing to.
pub fn rivals(scene: &Scene<'_>, mine: &Contender, contenders: &[Contender]) -> Vec<RivalFound> {
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
        // A wide or nameless shape can stand for anything: it is a rival only of its like.
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
