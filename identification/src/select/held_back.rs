//! A dead zone suppresses small rates completely; an effect that suppresses a small part of them is a different one at
//! the same rates. (For a saturation a part is enough: a gyro's gain falls before its limit.)

use super::scene::Scene;
use crate::linear::dot;
use crate::model::{Acts, Shape};

/// Maximum deviation of the suppressed part from the whole, unless `ERRORS` of its standard errors are more.
const OFF_MAX: f64 = 0.3;
const ERRORS: f64 = 3.0;

/// Whether `shape` can be a dead zone, by the part of the rate that it would suppress in `scene`.
pub fn holds_back_all(scene: &Scene<'_>, shape: &Shape) -> bool {
    if shape.acts != Acts::DeadZone {
        return true;
    }
    let columns = scene.data.columns(shape);
    let Some(column) = columns.first() else { return false };
    let mut column = scene.whitener.apply(column);
    scene.project(&mut column);
    let length = dot(&column, &column);
    // Uses the residual, not its scores, which cut off large values.
    let part = dot(&column, &scene.white) / length;
    let error = scene.scale / length.sqrt();
    (part - 1.0).abs() <= OFF_MAX.max(ERRORS * error)
}
