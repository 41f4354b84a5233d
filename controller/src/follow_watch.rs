//! Checks that the base goes and turns as far as commanded.
//!
//! The base follows its velocity commands, so their integral and its odometry differ by little: an odometer that
//! stands still or jumps shows in that difference. A gyro that is stuck at the same time hides it from every other check.

use wire::base::HEADING_STEP;
use wire::time::{Span, Timestamp};
use wire::units::{Acceleration, Angle, AngularRate, Length, Speed};

/// Allowed difference of the path at rest. Assumption: a third of the paper's 10 cm square.
const PATH_APART_MAX: Length = Length::from_m(0.03);
/// Allowed difference of the turn at rest. Assumption: four steps of the base's heading.
const TURN_APART_STEPS: f64 = 4.0;
/// Additional allowance as a share of the path or turn. Assumption.
const APART_SHARE_MAX: f64 = 0.01;
/// Largest lag of the base behind its commands. Assumption: two periods of the loops, an exchange on the serial line
/// and a period for its ramps.
const LAG_MAX: Span = Span::from_millis(150);
/// Longest time in which the odometer of a base that moves may not count. Assumption: steering brakes at 15 deg/s^2, and
/// its last step of heading takes 0.2 s.
const STILL_MAX: Span = Span::from_millis(250);
/// A base that goes at this speed counts a step of its path in 10 ms, m/s.
const CREEP: f64 = 0.01;
/// Number of remembered commands: one per period of about 27 ms, for [`LAG_MAX`] and a period more.
const ORDERS: usize = 8;

/// Watches one drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FollowWatch {
    path: Axis,
    steering: Axis,
    /// Last commanded speed of a drive that was broken off, m/s.
    broken_off_at: f64,
}

/// Checks that the odometry counts while the base says that it moves. Whether the base obeys, and when, does not matter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct CountWatch(Option<(Timestamp, Length, Angle)>);

impl CountWatch {
    /// The base does not move, or not along its path.
    pub(crate) fn rests(&mut self) {
        self.0 = None;
    }

    /// True if a base that moves along its path cannot report this at `now`: it has reported the same for too long.
    pub(crate) fn counts_nothing(
        &mut self,
        now: Timestamp,
        displacement: Length,
        heading: Angle,
    ) -> bool {
        match self.0 {
            Some((since, path, angle)) if (path, angle) == (displacement, heading) => {
                now - since > STILL_MAX
            }
            _ => {
                self.0 = Some((now, displacement, heading));
                false
            }
        }
    }
}

/// Drive or steering; SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Axis {
    /// The odometer at the start.
    from: f64,
    apart_max: f64,
    told: f64,
    last: Option<(Timestamp, f64)>,
    /// The integral of the commands at the time of each; the oldest first.
    orders: [Option<(Timestamp, f64)>; ORDERS],
}

impl FollowWatch {
    /// Starts a drive at these readings of the odometry.
    pub(crate) fn new(displacement: Length, heading: Angle) -> Self {
        let turn_apart_max = HEADING_STEP * TURN_APART_STEPS;
        Self {
            path: Axis::new(displacement.m(), PATH_APART_MAX.m()),
            steering: Axis::new(heading.rad(), turn_apart_max.rad()),
            broken_off_at: 0.0,
        }
    }

    /// The base is commanded to drive at `speed` and to steer at `rate` from `now` on.
    pub(crate) fn tell(&mut self, now: Timestamp, speed: Speed, rate: AngularRate) {
        self.path.tell(now, speed.m_per_s());
        self.steering.tell(now, rate.rad_per_s());
    }

    /// True if a moving base can report this at `now`.
    pub(crate) fn could_be_on_the_way(
        &self,
        now: Timestamp,
        displacement: Length,
        heading: Angle,
    ) -> bool {
        self.path.could_be_on_the_way(now, displacement.m())
            && self.steering.could_be_on_the_way(now, heading.rad())
    }

    /// The base is commanded to stand at `now`, and brakes at `ramp`. Afterwards [`Self::fell_short`] counts what it goes
    /// meanwhile.
    pub(crate) fn break_off(&mut self, now: Timestamp, ramp: Acceleration) {
        let speed = self.path.rate();
        self.path.tell(now, 0.0);
        self.path.told += speed * speed.abs() / (2.0 * ramp.m_per_s2());
        self.broken_off_at = speed;
    }

    /// True if the base's path is to change, unless it has come to rest.
    pub(crate) fn drives(&self) -> bool {
        self.path.rate().abs().max(self.broken_off_at.abs()) > CREEP
    }

    /// True if a base at rest went less than commanded. It may have gone further: the command to stop can be late.
    pub(crate) fn fell_short(&self, displacement: Length) -> bool {
        let Axis { from, told, .. } = self.path;
        (from + told - displacement.m()) * f64::copysign(1.0, told) > self.path.apart_max()
    }

    /// True if a base at rest can report this.
    pub(crate) fn could_be_there(&self, displacement: Length, heading: Angle) -> bool {
        self.path.could_be_there(displacement.m()) && self.steering.could_be_there(heading.rad())
    }
}

impl Axis {
    fn new(from: f64, apart_max: f64) -> Self {
        Self { from, apart_max, told: 0.0, last: None, orders: [None; ORDERS] }
    }

    /// The last commanded rate.
    fn rate(&self) -> f64 {
        self.last.map_or(0.0, |(_, rate)| rate)
    }

    fn tell(&mut self, now: Timestamp, rate: f64) {
        if let Some((since, before)) = self.last.replace((now, rate)) {
            self.told += before * (now - since).as_secs_f64();
        }
        self.orders.rotate_left(1);
        self.orders[ORDERS - 1] = Some((now, self.told));
    }

    fn could_be_on_the_way(&self, now: Timestamp, odometer: f64) -> bool {
        let went = odometer - self.from;
        let (told, told_before) = (self.told, self.told_before(now - LAG_MAX));
        let slack = self.apart_max();
        // Either way round: between what was commanded until a lag ago and until now.
        went >= told.min(told_before) - slack && went <= told.max(told_before) + slack
    }

    fn could_be_there(&self, odometer: f64) -> bool {
        (odometer - self.from - self.told).abs() <= self.apart_max()
    }

    /// The integral of the commands at `then`, or at the oldest remembered command.
    fn told_before(&self, then: Timestamp) -> f64 {
        let known = self.orders.iter().flatten();
        let before = known.clone().rfind(|(at, _)| *at <= then);
        before.or(known.clone().next()).map_or(0.0, |(_, told)| *told)
    }

    fn apart_max(&self) -> f64 {
        self.apart_max + self.told.abs() * APART_SHARE_MAX
    }
}

#[cfg(test)]
mod tests {
    use super::{Acceleration, Angle, AngularRate, FollowWatch, Length, Span, Speed, Timestamp};

    /// A watch commanded to drive at 0.4 m/s for `seconds`; the caller chooses the odometer reading.
    fn driven(seconds: i64) -> FollowWatch {
        let mut watch = FollowWatch::new(Length::from_m(7.0), Angle::ZERO);
        for millis in (0..seconds * 1_000).step_by(25) {
            let now = Timestamp::ZERO + Span::from_millis(millis);
            watch.tell(now, Speed::from_m_per_s(0.4), AngularRate::ZERO);
        }
        watch.tell(Timestamp::ZERO + Span::from_secs(seconds), Speed::ZERO, AngularRate::ZERO);
        watch
    }

    #[test]
    fn an_odometer_that_stood_still_or_jumped_shows() {
        let watch = driven(10);
        let at = |m: f64| Length::from_m(7.0 + m);
        let on_the_way =
            |m| watch.could_be_on_the_way(Timestamp::from_secs_f64(10.0), at(m), Angle::ZERO);
        let there = |m| watch.could_be_there(at(m), Angle::ZERO);
        assert!(there(4.0) && there(3.94) && !there(3.9) && !there(4.5));
        // 0.15 s late and 7 cm off passes; a standstill of a quarter of a second does not.
        assert!(on_the_way(3.9) && !on_the_way(3.86) && !on_the_way(4.1));
    }

    /// Found by a campaign: an odometer stuck in the last half second before the base fell silent.
    #[test]
    fn a_base_that_is_stopped_on_its_way_still_has_to_brake() {
        for sign in [1.0, -1.0] {
            let mut watch = FollowWatch::new(Length::from_m(7.0), Angle::ZERO);
            watch.tell(Timestamp::ZERO, Speed::from_m_per_s(0.4 * sign), AngularRate::ZERO);
            watch.break_off(Timestamp::from_secs_f64(2.0), Acceleration::from_m_per_s2(0.8));
            let fell_short = |m: f64| watch.fell_short(Length::from_m(7.0 + m * sign));
            assert!(!fell_short(0.9) && fell_short(0.85), "0.8 m and 0.1 m to brake, but for 4 cm");
            assert!(!fell_short(1.5), "it may have heard of it late");
        }
    }

    /// Found by a campaign: gyro and odometer both stuck when a turn began, so that they agreed.
    #[test]
    fn a_steering_that_reports_no_turn_shows() {
        let mut watch = FollowWatch::new(Length::ZERO, Angle::ZERO);
        for millis in (0..=3_000).step_by(25) {
            let now = Timestamp::ZERO + Span::from_millis(millis);
            watch.tell(now, Speed::ZERO, AngularRate::from_deg_per_s(30.0));
        }
        let on_the_way = |deg| {
            let now = Timestamp::from_secs_f64(3.0);
            watch.could_be_on_the_way(now, Length::ZERO, Angle::from_deg(deg))
        };
        assert!(on_the_way(90.0) && on_the_way(84.0) && !on_the_way(82.0) && !on_the_way(0.0));
        let there = |deg| watch.could_be_there(Length::ZERO, Angle::from_deg(deg));
        assert!(there(88.2) && !there(87.0) && !there(0.0));
    }
}
