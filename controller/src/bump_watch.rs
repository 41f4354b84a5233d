//! Detects a gyro that turns while the base reports that it stands.
//!
//! At rest the heading is held and the gyro's reading is taken for bias, which is right unless someone pushes the
//! robot. A turn larger than the resolution of the absolute measurement is a push or a jump of the bias. In both cases
//! the heading can no longer be trusted.

use wire::time::Span;
use wire::units::Angle;

/// Limit of the turn within [`WINDOW`]: the uncertainty of one reading of the absolute measurement (the paper's +-0.2
/// deg). The data sheet's drift turns by 0.005 deg in that time, and the noise of this class by at most 0.02 deg.
const TURN_MAX: Angle = Angle::from_deg(0.2);
/// Longest duration of a push.
const WINDOW: Span = Span::from_secs(1);

/// Sums the rotation that the held heading leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BumpWatch {
    turned: Angle,
    passed: Span,
}

impl BumpWatch {
    /// Takes a reading that turned by `by` while the heading was held. Returns true if it completes a push.
    pub(crate) fn turns(&mut self, by: Angle, period: Span) -> bool {
        self.turned += by;
        self.passed += period;
        let pushed = self.turned.abs() > TURN_MAX;
        if pushed || self.passed >= WINDOW {
            *self = Self::default();
        }
        pushed
    }

    /// Resets the sum when the heading is no longer held.
    pub(crate) fn restart(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::{Angle, BumpWatch, Span};

    fn pushed(deg_per_s: impl Fn(u32) -> f64) -> bool {
        let mut watch = BumpWatch::default();
        let period = Span::from_millis(10);
        (0..6_000).any(|n| watch.turns(Angle::from_deg(deg_per_s(n) * 0.01), period))
    }

    #[test]
    fn a_push_is_noticed_and_a_drift_is_not() {
        assert!(pushed(|n| if (500..520).contains(&n) { 2.5 } else { 0.0 }), "0.5 deg in 0.2 s");
        assert!(!pushed(|_| 0.02), "four times the data sheet's drift");
        // 0.4 deg/s of white noise at 100 Hz turns by 0.04 deg in a second; here as its worst regular pattern.
        assert!(!pushed(|n| if n % 2 == 0 { 0.4 } else { -0.4 }));
    }
}
