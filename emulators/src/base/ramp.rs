//! A rate that goes to its target with a limited acceleration: drive speed or steering rate.

use libm::ceil;
use wire::time::{Span, Timestamp};

/// A rate from a given instant on, in SI units; closed forms of its value and of its integral.
///
/// It takes a whole number of nanoseconds to settle, so that it has settled exactly at an instant of
/// the clock; its acceleration is that much lower than the limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Ramp {
    rate: f64,
    target: f64,
    /// Signed; zero where there is nothing left to change.
    acceleration: f64,
    settles_after: Span,
}

const NANOS_PER_SECOND: f64 = 1e9;

impl Ramp {
    /// From `rate` to `target`, changing by at most `limit` a second.
    pub(super) fn new(rate: f64, target: f64, limit: f64) -> Self {
        let change = target - rate;
        let settles_after = Span::from_nanos(ceil(change.abs() / limit * NANOS_PER_SECOND) as i64);
        if settles_after > Span::ZERO {
            let acceleration = change / settles_after.as_secs_f64();
            Self { rate, target, acceleration, settles_after }
        } else {
            // No change, or no limit to it.
            Self { rate: target, target, acceleration: 0.0, settles_after }
        }
    }

    /// The rate after `t` seconds.
    pub(super) fn rate(&self, t: f64) -> f64 {
        if t >= self.settles_after.as_secs_f64() {
            self.target
        } else {
            self.rate + self.acceleration * t
        }
    }

    /// What the rate adds up to in `t` seconds.
    pub(super) fn integral(&self, t: f64) -> f64 {
        let ramped = t.min(self.settles_after.as_secs_f64());
        (self.rate + 0.5 * self.acceleration * ramped) * ramped + self.target * (t - ramped)
    }

    /// How it changes until it has settled, signed.
    pub(super) const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// What it tends to.
    pub(super) const fn target(&self) -> f64 {
        self.target
    }

    /// Zero, and stays so.
    pub(super) fn is_at_rest(&self) -> bool {
        self.target == 0.0 && self.settles_after == Span::ZERO
    }

    /// When the target is reached; [`Timestamp::MAX`] where it has been from the start.
    pub(super) fn settles_at(&self, start: Timestamp) -> Timestamp {
        if self.settles_after > Span::ZERO { start + self.settles_after } else { Timestamp::MAX }
    }
}

#[cfg(test)]
mod tests {
    use super::Ramp;
    use proptest::prelude::*;
    use wire::time::Timestamp;

    #[test]
    fn without_a_limit_the_target_is_reached_at_once() {
        let ramp = Ramp::new(0.0, 0.4, f64::INFINITY);
        assert_eq!((ramp.rate(0.0), ramp.integral(2.0)), (0.4, 0.8));
        assert_eq!(ramp.settles_at(Timestamp::ZERO), Timestamp::MAX);
    }

    #[test]
    fn a_ramp_through_zero_takes_its_time() {
        let ramp = Ramp::new(0.4, -0.4, 0.25);
        assert_eq!(ramp.settles_at(Timestamp::ZERO), Timestamp::from_secs_f64(3.2));
        assert!(ramp.rate(1.6).abs() < 1e-15 && !ramp.is_at_rest());
        assert!(ramp.integral(3.2).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn the_integral_is_that_of_the_rate(
            rate in -1f64..1.0, target in -1f64..1.0, limit in 0.01f64..10.0, t in 0f64..10.0,
        ) {
            let ramp = Ramp::new(rate, target, limit);
            let h = t / 10_000.0;
            let sum: f64 = (0..10_000).map(|n| ramp.rate((f64::from(n) + 0.5) * h) * h).sum();
            prop_assert!((ramp.integral(t) - sum).abs() < 1e-5);
        }

        #[test]
        fn the_limit_holds_and_the_target_is_never_passed(
            rate in -1f64..1.0, target in -1f64..1.0, limit in 0.01f64..10.0,
            t in 0f64..10.0, step in 0f64..1.0,
        ) {
            let ramp = Ramp::new(rate, target, limit);
            let (a, b) = (ramp.rate(t), ramp.rate(t + step));
            prop_assert!((b - a).abs() <= limit * step + 1e-12);
            prop_assert!(a >= rate.min(target) - 1e-12 && a <= rate.max(target) + 1e-12);
        }
    }
}
