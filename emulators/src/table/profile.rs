//! A move by an indexer: a trapezoid of step rate over time.

use libm::{ceil, round, sqrt};
use wire::time::{Span, Timestamp};

const NANOS_PER_SECOND: f64 = 1e9;

/// A move in steps, as a closed form of time: one ramp up, constant rate, another ramp down.
///
/// It ends on a whole nanosecond, on its last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    start: Timestamp,
    from: f64,
    to: f64,
    /// Signed like the move.
    top_rate: f64,
    up_s: f64,
    level_s: f64,
    down_s: f64,
}

impl Profile {
    pub(super) const fn at_rest(position: f64) -> Self {
        Self {
            start: Timestamp::ZERO,
            from: position,
            to: position,
            top_rate: 0.0,
            up_s: 0.0,
            level_s: 0.0,
            down_s: 0.0,
        }
    }

    /// A move from rest at `from`, by `distance` steps, with at most `rate` and `ramp` (both positive). A move too
    /// short for the top rate is a triangle.
    pub(super) fn new(start: Timestamp, from: f64, distance: f64, rate: f64, ramp: f64) -> Self {
        let length = distance.abs();
        let top_rate = rate.min(sqrt(length * ramp));
        let up_s = top_rate / ramp;
        let level_s = if top_rate > 0.0 { (length / top_rate - up_s).max(0.0) } else { 0.0 };
        Self {
            start,
            from,
            to: from + distance,
            top_rate: top_rate.copysign(distance),
            up_s,
            level_s,
            down_s: up_s,
        }
    }

    /// Stops from `now` on, with about `ramp`, on a whole step. If that takes less than a step the motor stops at
    /// once, on the nearest one.
    pub(super) fn stopped(&self, now: Timestamp, ramp: f64) -> Self {
        let (from, rate) = (self.position(now), self.rate(now));
        let way = rate * rate / (2.0 * ramp);
        if way < 1.0 {
            return Self::at_rest(round(from));
        }
        let to = round(from + way.copysign(rate));
        let down_s = 2.0 * (to - from) / rate;
        Self { start: now, from, to, top_rate: rate, up_s: 0.0, level_s: 0.0, down_s }
    }

    pub(super) fn end(&self) -> Timestamp {
        let seconds = self.up_s + self.level_s + self.down_s;
        self.start + Span::from_nanos(ceil(seconds * NANOS_PER_SECOND) as i64)
    }

    /// Commanded steps until `now`, as a smooth count.
    pub(super) fn position(&self, now: Timestamp) -> f64 {
        if now >= self.end() {
            return self.to;
        }
        let t = (now - self.start).as_secs_f64();
        if t <= 0.0 {
            return self.from;
        }
        if t < self.up_s {
            return self.from + 0.5 * self.top_rate / self.up_s * t * t;
        }
        let level_from = self.from + 0.5 * self.top_rate * self.up_s;
        if t < self.up_s + self.level_s {
            return level_from + self.top_rate * (t - self.up_s);
        }
        let left = (self.up_s + self.level_s + self.down_s - t).max(0.0);
        self.to - 0.5 * self.top_rate / self.down_s * left * left
    }

    pub(super) fn rate(&self, now: Timestamp) -> f64 {
        if now >= self.end() {
            return 0.0;
        }
        let t = (now - self.start).as_secs_f64();
        if t < self.up_s {
            self.top_rate / self.up_s * t
        } else if t < self.up_s + self.level_s {
            self.top_rate
        } else {
            let left = (self.up_s + self.level_s + self.down_s - t).max(0.0);
            self.top_rate / self.down_s * left
        }
    }

    /// The rate at the end of the first ramp, unsigned.
    pub(super) fn top_rate(&self) -> f64 {
        self.top_rate.abs()
    }

    /// +1 counter-clockwise, -1 clockwise.
    pub(super) fn direction(&self) -> f64 {
        1f64.copysign(self.to - self.from)
    }

    /// Steps of the whole move, unsigned.
    pub(super) fn length(&self) -> f64 {
        (self.to - self.from).abs()
    }

    /// Commanded steps of the move until `now`, unsigned.
    pub(super) fn commanded(&self, now: Timestamp) -> f64 {
        (self.position(now) - self.from).abs()
    }

    /// Seconds since the move began.
    pub(super) fn elapsed_s(&self, now: Timestamp) -> f64 {
        (now - self.start).as_secs_f64()
    }

    /// Seconds from the start of the move until it brakes.
    pub(super) fn brakes_after_s(&self) -> f64 {
        self.up_s + self.level_s
    }
}

#[cfg(test)]
mod tests {
    use super::Profile;
    use proptest::prelude::*;
    use wire::time::{Span, Timestamp};

    #[test]
    fn a_turn_of_the_papers_table_takes_fourteen_seconds() {
        // 28800 steps of 0.0125 deg at 30 deg/s with ramps of 15 deg/s^2.
        let profile = Profile::new(Timestamp::ZERO, 0.0, -28_800.0, 2_400.0, 1_200.0);
        assert_eq!(profile.end(), Timestamp::from_secs_f64(14.0));
        assert_eq!(profile.rate(Timestamp::from_secs_f64(7.0)), -2_400.0);
        assert_eq!(profile.position(Timestamp::from_secs_f64(7.0)), -14_400.0);
        assert_eq!(profile.position(profile.end()), -28_800.0);
    }

    #[test]
    fn a_stop_ends_on_a_whole_step() {
        let profile = Profile::new(Timestamp::ZERO, 0.0, 28_800.0, 2_400.0, 1_200.0);
        for millis in [1, 777, 5_003, 13_400] {
            let now = Timestamp::ZERO + Span::from_millis(millis);
            let stopped = profile.stopped(now, 1_200.0);
            assert!((stopped.position(now) - profile.position(now)).abs() <= 0.5);
            let change = stopped.rate(now) - profile.rate(now);
            assert!(change.abs() < 1e-6 || profile.rate(now) < 49.0, "{change}");
            let last = stopped.position(stopped.end());
            assert_eq!(last, last.round());
        }
    }

    proptest! {
        #[test]
        fn rate_and_ramp_hold_and_the_way_is_exact(
            distance in -100_000i32..100_000, rate in 1f64..5_000.0, ramp in 1f64..20_000.0,
            share in 0f64..1.0,
        ) {
            let profile = Profile::new(Timestamp::ZERO, 17.0, distance.into(), rate, ramp);
            prop_assert_eq!(profile.position(profile.end()), 17.0 + f64::from(distance));
            let now = Timestamp::from_secs_f64(profile.end().as_secs_f64() * share);
            let step = Span::from_micros(100);
            prop_assert!(profile.rate(now).abs() <= rate * (1.0 + 1e-12));
            let change = profile.rate(now + step) - profile.rate(now);
            prop_assert!(change.abs() <= ramp * 1e-4 * (1.0 + 1e-6) + 1e-6);
            let moved = profile.position(now + step) - profile.position(now);
            prop_assert!((moved - profile.rate(now + step / 2) * 1e-4).abs() <= ramp * 1e-8 + 1e-6);
        }
    }
}
