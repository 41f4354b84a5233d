//! Rivals: other possible causes.

use super::choose::Contender;
use super::scene::Scene;
use crate::model::{Driver, Form, Shape};
use crate::significance::surprise_chi2;

/// Maximum distance of a rival behind the effect, in nats.
const BEHIND_MAX: f64 = 12.0;
/// Maximum surprise that the effect adds to a rival: what chi-squared exceeds once in 200 times.
const ADDS_MAX: f64 = 5.3;
/// Maximum number of rivals named.
const RIVALS_MAX: usize = 6;
/// Number of contenders examined.
const LOOKED_AT: usize = 60;

/// Another cause that the data cannot exclude.
#[derive(Debug, Clone)]
pub struct RivalFound {
    /// Its shape.
    pub shape: Shape,
    /// Its distance behind the effect in rank, in nats.
    pub behind: f64,
}

/// Contenders in `scene` (the model without the effect) to which the effect adds nothing.
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
