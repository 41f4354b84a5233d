//! A rate that approaches its target with limited acceleration: drive speed or steering rate.

use libm::ceil;
use wire::time::{Span, Timestamp};

/// A rate from a given instant on, in SI units; closed forms of its value and of its integral.
///
/// The ramp takes a whole number of nanoseconds, so that it settles exactly at an instant of the clock; its
/// acceleration is slightly below the limit for that.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Ramp {
    rate: f64,
    target: f64,
    /// Signed; zero if there is nothing left to change.
    acceleration: f64,
    settles_after: Span,
}

const NANOS_PER_SECOND: f64 = 1e9;

impl Ramp {
    /// From `rate` to `target`, changing by at most `limit` per second.
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

    /// The integral of the rate over `t` seconds.
    pub(super) fn integral(&self, t: f64) -> f64 {
        let ramped = t.min(self.settles_after.as_secs_f64());
        (self.rate + 0.5 * self.acceleration * ramped) * ramped + self.target * (t - ramped)
    }

    pub(super) const fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// The target rate.
    pub(super) const fn target(&self) -> f64 {
        self.target
    }

    /// True if the rate is zero and stays zero.
    pub(super) fn is_at_rest(&self) -> bool {
        self.target == 0.0 && self.settles_after == Span::ZERO
    }

    /// The ramp and its target raised by `by`.
    pub(super) fn raised(&self, by: f64) -> Self {
        Self { rate: self.rate + by, target: self.target + by, ..*self }
    }

    /// The ramp with all rates multiplied by `times`.
    pub(super) fn scaled(&self, times: f64) -> Self {
        Self {
            rate: self.rate * times,
            target: self.target * times,
            acceleration: self.acceleration * times,
            ..*self
        }
    }

    /// The first time at which the rate, in either direction, passes `level` on its way to the target.
    pub(super) fn passes(&self, level: f64) -> Option<Span> {
        let settles_after = self.settles_after.as_secs_f64();
        [level, -level]
            .map(|rate| (rate - self.rate) / self.acceleration)
            .into_iter()
            .filter(|t| *t > 0.0 && *t < settles_after)
            .min_by(f64::total_cmp)
            .map(later)
    }

    /// The first time at which the integral reaches `sum`, for a rate that starts with the sign of `sum`.
    pub(super) fn adds_up_to(&self, sum: f64) -> Option<Span> {
        let settles_after = self.settles_after.as_secs_f64();
        // The first root of rate t + acceleration t^2 / 2 = sum, written without cancellation; NaN without a real root.
        let root = (self.rate * self.rate + 2.0 * self.acceleration * sum).sqrt().copysign(sum);
        let ramping = 2.0 * sum / (self.rate + root);
        if ramping <= settles_after {
            return Some(later(ramping));
        }
        let settled = (sum - self.integral(settles_after)) / self.target;
        (settled.is_finite() && settled >= 0.0).then(|| later(settles_after + settled))
    }

    /// Time at which the target is reached; [`Timestamp::MAX`] if it was reached from the start.
    pub(super) fn settles_at(&self, start: Timestamp) -> Timestamp {
        if self.settles_after > Span::ZERO { start + self.settles_after } else { Timestamp::MAX }
    }
}

/// `seconds` rounded up to whole nanoseconds, at least one.
fn later(seconds: f64) -> Span {
    Span::from_nanos((ceil(seconds * NANOS_PER_SECOND) as i64).max(1))
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
        fn a_level_is_passed_when_it_is_said_to_be(
            rate in -1f64..1.0, target in -1f64..1.0, limit in 0.01f64..10.0, level in 0f64..1.0,
        ) {
            let ramp = Ramp::new(rate, target, limit);
            let above = |t: f64| ramp.rate(t).abs() >= level;
            let Some(at) = ramp.passes(level).map(|at| at.as_secs_f64()) else {
                // Through zero it may pass below and above the level again, but then it passes twice.
                prop_assert!(above(0.0) == above(1e3) || (ramp.rate(0.0).abs() - level).abs() < 1e-9);
                return Ok(());
            };
            prop_assert!((ramp.rate(at).abs() - level).abs() < 1e-8 * limit.max(1.0));
            prop_assert_eq!(above(0.5 * at), above(0.01 * at));
        }

        #[test]
        fn the_sum_is_reached_when_it_is_said_to_be(
            rate in 0f64..1.0, target in -1f64..1.0, limit in 0.01f64..10.0, sum in 0.001f64..2.0,
            sign in prop_oneof![Just(1.0), Just(-1.0)],
        ) {
            let ramp = Ramp::new(sign * rate, sign * target, limit);
            match ramp.adds_up_to(sign * sum) {
                Some(at) => {
                    let off = ramp.integral(at.as_secs_f64()) - sign * sum;
                    prop_assert!(off.abs() < 3e-9 && off * sign > -1e-12, "{off}");
                }
                None => prop_assert!((1..1_000).all(|n| sign * ramp.integral(0.1 * f64::from(n)) < sum)),
            }
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
