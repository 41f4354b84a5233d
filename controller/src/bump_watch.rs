//! Does the gyro turn while the base says that it stands?
//!
//! At rest the heading is held, whatever the gyro reads: bias, as long as nobody pushes. A turn of more than a reading of
//! the absolute measurement could tell is a push, or a bias that has leapt, and either way the heading is not to be
//! trusted any more.

use wire::time::Span;
use wire::units::Angle;

/// Turned within [`WINDOW`]. The uncertainty of a reading of the absolute measurement (the paper's +-0.2 deg); the
/// data sheet's drift turns by 0.005 deg in that time, and the noise of this class by 0.02 deg at most.
const TURN_MAX: Angle = Angle::from_deg(0.2);
/// How long a push may take.
const WINDOW: Span = Span::from_secs(1);

/// Sums what the held heading leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BumpWatch {
    turned: Angle,
    passed: Span,
}

impl BumpWatch {
    /// A reading turned by this much while the heading was held. True if it, and those before it, were a push.
    pub(crate) fn turns(&mut self, by: Angle, period: Span) -> bool {
        self.turned += by;
        self.passed += period;
        let pushed = self.turned.abs() > TURN_MAX;
        if pushed || self.passed >= WINDOW {
            *self = Self::default();
        }
        pushed
    }

    /// The heading is not held any more.
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
        // 0.4 deg/s of white noise at 100 Hz turn by 0.04 deg a second: here as its worst regular pattern.
        assert!(!pushed(|n| if n % 2 == 0 { 0.4 } else { -0.4 }));
    }
}
