//! A dead zone holds back all of a small rate: what holds back a small part of it is another effect at the same
//! rates. (Of a saturation a part is enough: a gyro's gain falls before it ends.)

use super::scene::Scene;
use crate::linear::dot;
use crate::model::{Acts, Shape};

/// How far from the whole the part that is held back may lie, or `ERRORS` of its standard errors where these are more.
const OFF_MAX: f64 = 0.3;
const ERRORS: f64 = 3.0;

/// Can `shape` be what it says, by the part of the rate that it would have to hold back in `scene`?
pub fn holds_back_all(scene: &Scene<'_>, shape: &Shape) -> bool {
    if shape.acts != Acts::DeadZone {
        return true;
    }
    let columns = scene.data.columns(shape);
    let Some(column) = columns.first() else { return false };
    let mut column = scene.whitener.apply(column);
    scene.project(&mut column);
    let length = dot(&column, &column);
    // Not the scores of the residual: of these what is large is cut off.
    let part = dot(&column, &scene.white) / length;
    let error = scene.scale / length.sqrt();
    (part - 1.0).abs() <= OFF_MAX.max(ERRORS * error)
}
