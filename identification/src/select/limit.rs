//! A limit of the range of a sensor: where it lies, and how much of what is beyond it is missing. Where few rates lie beyond, the
//! readings tell only one of the two, and nothing passes then: the limit is hard.

use super::scene::Scene;
use crate::linear::dot;
use crate::model::Shape;

/// Standard error of the missing share from which the readings do not tell it from the place of the limit.
const UNTOLD: f64 = 0.3;

/// Whether columns do not tell the missing share: `by_share` per unit of the readings' gain, `by_place` per unit of the limit.
pub(super) fn is_hard(by_share: &[f64], by_place: &[f64], noise: f64) -> bool {
    let square = dot(by_share, by_share);
    let both = dot(by_share, by_place);
    let alone = square - both * both / dot(by_place, by_place);
    // Two columns that differ by rounding alone are the same.
    !(alone > 1e-9 * square) || noise > UNTOLD * alone.sqrt()
}

/// Halvings of the range in which a limit lies.
const HALVINGS: usize = 30;
/// What F of one degree of freedom exceeds once in twenty times.
const ONE_IN_TWENTY: f64 = 3.84;

/// Moves a limit that explains `most` to where all beyond it is missing, within `range`, if the readings do not tell that
/// some passes.
pub(super) fn harden(scene: &Scene<'_>, shape: &mut Shape, range: (f64, f64), most: f64) {
    let gain = scene.data.channels.gain;
    let (mut low, mut high) = range;
    let mut hard = shape.clone();
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        hard.set("limit", middle);
        let Some(column) = scene.data.columns(&hard).into_iter().next() else { return };
        let mut column = scene.whitener.apply(&column);
        scene.project(&mut column);
        // The farther the limit, the larger the share of what is beyond it that is missing. By the residual, and not by its
        // scores, which cut off large values.
        let share = dot(&column, &scene.white) / dot(&column, &column) / gain;
        if share < 1.0 { low = middle } else { high = middle }
    }
    let free = scene.free();
    let rest = ((free - most) / free).max(1e-9);
    if most - scene.score(&hard).statistic < ONE_IN_TWENTY * rest {
        *shape = hard;
    }
}
