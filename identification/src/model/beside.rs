//! What a term of a robot with a wheel on each side does besides: one wheel changes the turn and the distance at once.

use super::{Acts, Form};
use crate::problem::Block;

/// Name of the error of both wheels alike.
pub const WHEEL_SIZE: &str = "wheel_size";

/// What one unit of the term `name`, which acts in this way and form, adds to each row of `block` in another way, and that way.
///
/// With a relative error of the right wheel and of the left one, r and l, a distance d and a turn t by the wheels, which
/// stand b apart, are d + d (r + l) / 2 + t b (r - l) / 4 and t + t (r + l) / 2 + d (r - l) / b (Borenstein and Feng
/// 1996 give the second). So unequal wheels, which turn the robot by c = (r - l) / b over a metre, also drive it c (b/2)^2
/// farther over a radian; wheels that are both larger also turn it more.
pub fn beside(name: &str, (acts, form): (Acts, Form), block: &Block) -> Option<(Acts, Vec<f64>)> {
    let half = block.pose.as_ref()?.half_track?;
    let turn = &block.exposure(Acts::Turn)?.per_row;
    match (acts, form) {
        // A slope of the ground turns the robot, and no wheel.
        (Acts::Curvature, form) if form != Form::Harmonic => {
            Some((Acts::Drive, turn.iter().map(|turn| half * half * turn).collect()))
        }
        (Acts::Drive, Form::Constant) if name == WHEEL_SIZE => Some((Acts::Turn, turn.clone())),
        _ => None,
    }
}
