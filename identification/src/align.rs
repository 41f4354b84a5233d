//! Corrections made before any search: a sensor with the wrong sign, or a file that states the wrong unit.

use crate::model::{Acts, Shape};
use crate::problem::{Aggregate, Block};

/// Correction of a block: a scale term whose value is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Aligned {
    /// The term.
    pub shape: Shape,
    /// Its value.
    pub value: f64,
}

/// Minimum squared correlation of readings and reference for a correction.
const FOLLOWS: f64 = 0.8;
/// Maximum relative deviation from one of the factors; a scale error may come on top.
const WITHIN: f64 = 0.2;

/// Factors by which readings can be off, with the name of the effect.
const FACTORS: [(f64, &str); 5] = [
    (-1.0, "reversed_sign"),
    (DEGREES, "degrees_for_radians"),
    (1.0 / DEGREES, "radians_for_degrees"),
    (-DEGREES, "reversed_degrees_for_radians"),
    (-1.0 / DEGREES, "reversed_radians_for_degrees"),
];

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Corrects `block` if necessary.
pub fn align(block: &mut Block) -> Option<Aligned> {
    if block.aggregate != Aggregate::Row {
        return None;
    }
    let truth = block.exposure(Acts::Scale)?.per_row.clone();
    let pairs: Vec<(f64, f64)> = block
        .rows
        .iter()
        .zip(&block.residual)
        .map(|(&row, residual)| (truth[row], truth[row] + residual))
        .collect();
    let slope = slope(&pairs)?;
    let (factor, name) =
        FACTORS.into_iter().find(|(factor, _)| (slope / factor - 1.0).abs() < WITHIN)?;
    let value = factor - 1.0;
    for (residual, &row) in block.residual.iter_mut().zip(&block.rows) {
        *residual -= value * truth[row];
    }
    Some(Aligned { shape: Shape::constant(name, Acts::Scale), value })
}

/// Slope of a line through pairs of truth and reading; `None` if they do not follow a line.
fn slope(pairs: &[(f64, f64)]) -> Option<f64> {
    let n = pairs.len() as f64;
    let (mx, my) = pairs.iter().fold((0.0, 0.0), |(x, y), pair| (x + pair.0 / n, y + pair.1 / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        xx += (x - mx).powi(2);
        xy += (x - mx) * (y - my);
        yy += (y - my).powi(2);
    }
    (xy * xy > FOLLOWS * xx * yy && xx > 0.0).then(|| xy / xx)
}

#[cfg(test)]
mod tests {
    use super::{DEGREES, slope};

    #[test]
    fn only_what_follows_its_reference_has_a_slope() {
        let line: Vec<(f64, f64)> =
            (0..50).map(|i| (f64::from(i), -0.97 * DEGREES * f64::from(i) + 3.0)).collect();
        assert!((slope(&line).unwrap() + 0.97 * DEGREES).abs() < 1e-9);
        let noise: Vec<(f64, f64)> =
            (0..50).map(|i| (f64::from(i), (f64::from(i) * 37.0).sin())).collect();
        assert_eq!(slope(&noise), None);
    }
}
