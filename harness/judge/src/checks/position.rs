//! Checks on positions on the floor.

use super::each::exceptions;
use super::figure::{Figure, Refusal, is_clear};
use super::select::Position;
use plan::Band;
use wire::units::Length;

/// The number of positions outside a square parallel to the axes.
pub(super) fn outside_square(
    positions: &[Position],
    most: u32,
    side: Length,
    [centre_x, centre_y]: [f64; 2],
) -> Result<Figure, Refusal> {
    let half = Band::at_most(side.m() / 2.0);
    let inside = |position: &Position, coverage: f64| {
        let (x, y) = (position.x, position.y);
        is_clear((x.value - centre_x).abs(), x.uncertainty, half, coverage)
            && is_clear((y.value - centre_y).abs(), y.uncertainty, half, coverage)
    };
    exceptions(positions, most, inside, &format!("outside a square of {} m", side.m()))
}
