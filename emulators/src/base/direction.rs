//! A direction on the floor as cosine and sine, and small rotations of it.

/// Cosine and sine of an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Direction {
    pub(super) cos: f64,
    pub(super) sin: f64,
}

/// Up to this angle the series below are exact to the last bit: their next terms are less than 1e-16.
const CLOSE_RAD: f64 = 0.06;

impl Direction {
    /// The direction of an angle in rad.
    pub(super) fn of(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self { cos, sin }
    }

    /// Turns by `angle` rad; cheap for small angles.
    pub(super) fn turned(self, angle: f64) -> Self {
        let by = if angle.abs() < CLOSE_RAD { Self::close(angle) } else { Self::of(angle) };
        Self {
            cos: self.cos * by.cos - self.sin * by.sin,
            sin: self.sin * by.cos + self.cos * by.sin,
        }
    }

    /// The Taylor series about zero.
    fn close(angle: f64) -> Self {
        let square = angle * angle;
        let cos = 1.0
            - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
        let sin = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)));
        Self { cos, sin }
    }
}

#[cfg(test)]
mod tests {
    use super::{CLOSE_RAD, Direction};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn turned_is_the_direction_of_the_sum(
            angle in -10f64..10.0, by in prop_oneof![-CLOSE_RAD..CLOSE_RAD, -3f64..3.0],
        ) {
            let (turned, sum) = (Direction::of(angle).turned(by), Direction::of(angle + by));
            // Two roundings, plus that of the sum itself.
            prop_assert!((turned.cos - sum.cos).abs() < 2e-15);
            prop_assert!((turned.sin - sum.sin).abs() < 2e-15);
        }
    }
}
