//! What a term of a robot with a wheel on each side does besides: one wheel changes the turn and the distance at once.

use super::{Acts, Form};
use crate::problem::Block;

/// Name of the error of both wheels alike.
pub const WHEEL_SIZE: &str = "wheel_size";
/// Name of their difference, which bends the path.
pub const UNEQUAL_WHEELS: &str = "unequal_wheels";
/// Names of the error of one wheel alone.
pub const ONE_WHEEL: [&str; 2] = ["right_wheel", "left_wheel"];

/// What one unit of the term `name`, which acts in this way and form, adds to each row of `block` in other ways, and those
/// ways.
///
/// With a relative error of the right wheel and of the left one, r and l, a distance d and a turn t by the wheels, which
/// stand b apart, are d + d (r + l) / 2 + t b (r - l) / 4 and t + t (r + l) / 2 + d (r - l) / b (Borenstein and Feng
/// 1996 give the second). So unequal wheels, which turn the robot by c = (r - l) / b over a metre, also drive it c (b/2)^2
/// farther over a radian; wheels that are both larger also turn it more; and one wheel alone, a term of the distance, drives
/// half of its own way and turns the robot about the other wheel.
pub fn beside(name: &str, (acts, form): (Acts, Form), block: &Block) -> Vec<(Acts, Vec<f64>)> {
    let Some(half) = block.pose.as_ref().and_then(|pose| pose.half_track) else {
        return Vec::new();
    };
    let of = |acts| block.exposure(acts).map_or(&[][..], |exposure| &exposure.per_row);
    let (turn, way) = (of(Acts::Turn), of(Acts::Drive));
    match (acts, form) {
        // A slope of the ground turns the robot, and no wheel.
        (Acts::Curvature, form) if form != Form::Harmonic => {
            vec![(Acts::Drive, turn.iter().map(|turn| half * half * turn).collect())]
        }
        (Acts::Drive, Form::Constant) if name == WHEEL_SIZE => vec![(Acts::Turn, turn.to_vec())],
        (Acts::Drive, Form::Constant) if ONE_WHEEL.contains(&name) => {
            let side = if name == ONE_WHEEL[0] { half } else { -half };
            let both = || way.iter().zip(turn);
            let less = both().map(|(way, turn)| (side * turn - way) / 2.0).collect();
            let turns = both().map(|(way, turn)| (way / side + turn) / 2.0).collect();
            vec![(Acts::Drive, less), (Acts::Turn, turns)]
        }
        _ => Vec::new(),
    }
}
