//! Checks that the base goes as far as commanded.
//!
//! The base follows its velocity commands, so their integral and the odometer differ by little: an odometer that
//! stands still or jumps shows in that difference.

use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Length, Speed};

/// Allowed difference at rest. Assumption: a third of the paper's 10 cm square.
const APART_MAX: Length = Length::from_m(0.03);
/// Additional allowance as a share of the path. Assumption.
const APART_SHARE_MAX: f64 = 0.01;
/// Largest lag of the base behind its commands. Assumption: two periods of the loops, an exchange on the serial line
/// and a period for its ramps.
const LAG_MAX: Span = Span::from_millis(150);
/// Number of remembered commands: one per period of about 27 ms, for [`LAG_MAX`] and a period more.
const ORDERS: usize = 8;

/// Watches one drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct PathWatch {
    /// The odometer at the start.
    from: Length,
    told: Length,
    last: Option<(Timestamp, Speed)>,
    /// The integral of the commands at the time of each; the oldest first.
    orders: [Option<(Timestamp, Length)>; ORDERS],
}

impl PathWatch {
    /// Starts a drive at the odometer reading `from`.
    pub(crate) fn new(from: Length) -> Self {
        Self { from, ..Self::default() }
    }

    /// The base is commanded to drive at `speed` from `now` on.
    pub(crate) fn tell(&mut self, now: Timestamp, speed: Speed) {
        if let Some((since, before)) = self.last.replace((now, speed)) {
            self.told += before * (now - since);
        }
        self.orders.rotate_left(1);
        self.orders[ORDERS - 1] = Some((now, self.told));
    }

    /// True if a moving base can report `displacement` at `now`.
    pub(crate) fn could_be_on_the_way(&self, now: Timestamp, displacement: Length) -> bool {
        let went = displacement - self.from;
        let (told, told_before) = (self.told, self.told_before(now - LAG_MAX));
        let slack = self.apart_max();
        // Forward or backward: between the commanded path a lag ago and now.
        went >= told.min(told_before) - slack && went <= told.max(told_before) + slack
    }

    /// The drive is broken off at `now`, and the base brakes at `ramp`. Afterwards [`Self::fell_short`] counts what it
    /// goes meanwhile.
    pub(crate) fn break_off(&mut self, now: Timestamp, ramp: Acceleration) {
        let speed = self.last.map_or(0.0, |(_, speed)| speed.m_per_s());
        self.tell(now, Speed::ZERO);
        self.told += Length::from_m(speed * speed.abs() / (2.0 * ramp.m_per_s2()));
    }

    /// True if a base at rest went less than commanded. It may have gone further: the command to stop can be late.
    pub(crate) fn fell_short(&self, displacement: Length) -> bool {
        let short = (self.from + self.told - displacement).m() * f64::copysign(1.0, self.told.m());
        short > self.apart_max().m()
    }

    /// True if a base at rest can report `displacement`.
    pub(crate) fn could_be_there(&self, displacement: Length) -> bool {
        (displacement - self.from - self.told).abs() <= self.apart_max()
    }

    /// The integral of the commands at `then`, or at the oldest remembered command.
    fn told_before(&self, then: Timestamp) -> Length {
        let known = self.orders.iter().flatten();
        let before = known.clone().rfind(|(at, _)| *at <= then);
        before.or(known.clone().next()).map_or(Length::ZERO, |(_, told)| *told)
    }

    fn apart_max(&self) -> Length {
        APART_MAX + self.told.abs() * APART_SHARE_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::{Acceleration, Length, PathWatch, Span, Speed, Timestamp};

    /// A watch commanded to drive at 0.4 m/s for `seconds`; the caller chooses the odometer reading.
    fn driven(seconds: i64) -> PathWatch {
        let mut watch = PathWatch::new(Length::from_m(7.0));
        for millis in (0..seconds * 1_000).step_by(25) {
            let now = Timestamp::ZERO + Span::from_millis(millis);
            watch.tell(now, Speed::from_m_per_s(0.4));
        }
        watch.tell(Timestamp::ZERO + Span::from_secs(seconds), Speed::ZERO);
        watch
    }

    #[test]
    fn an_odometer_that_stood_still_or_jumped_shows() {
        let watch = driven(10);
        let at = |m: f64| Length::from_m(7.0 + m);
        let on_the_way = |m| watch.could_be_on_the_way(Timestamp::from_secs_f64(10.0), at(m));
        assert!(watch.could_be_there(at(4.0)) && watch.could_be_there(at(3.94)));
        assert!(!watch.could_be_there(at(3.9)) && !watch.could_be_there(at(4.5)));
        // 0.15 s late and 7 cm off passes; a standstill of a quarter of a second does not.
        assert!(on_the_way(3.9) && !on_the_way(3.86) && !on_the_way(4.1));
    }

    /// Found by a campaign: an odometer stuck in the last half second before the base fell silent.
    #[test]
    fn a_base_that_is_stopped_on_its_way_still_has_to_brake() {
        for sign in [1.0, -1.0] {
            let mut watch = PathWatch::new(Length::from_m(7.0));
            watch.tell(Timestamp::ZERO, Speed::from_m_per_s(0.4 * sign));
            watch.break_off(Timestamp::from_secs_f64(2.0), Acceleration::from_m_per_s2(0.8));
            let fell_short = |m: f64| watch.fell_short(Length::from_m(7.0 + m * sign));
            assert!(!fell_short(0.9) && fell_short(0.85), "0.8 m and 0.1 m to brake, but for 4 cm");
            assert!(!fell_short(1.5), "it may have heard of it late");
        }
    }
}
