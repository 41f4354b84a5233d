//! Checks that gyro and steering odometry turn alike.
//!
//! The controller receives both all the time. From the start of a drive, a good gyro and a good base differ only by
//! the base's own errors. A larger difference means that one of the two is wrong; the controller cannot tell which.
//!
//! The same holds for the last second or two, over which these errors are smaller: a bias that leaps on a straight line
//! shows there first.

use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length};

/// Limit for any drive. Assumption: three steps of the K2A's heading of 0.3 deg, and as much again for noise of the
/// gyro.
const APART_MAX: Angle = Angle::from_deg(1.0);
/// Limit per radian of turn: the base turns 1.1 % too far (from the paper's laps); a little more than twice that.
const APART_PER_TURN: f64 = 0.025;
/// Limit per metre: twice the drift of the base's own heading of 0.125 deg/m (from the paper's laps).
const APART_DEG_PER_M: f64 = 0.25;
/// Largest age difference of the compared headings. Assumption: one exchange on the serial line.
const AGE: Span = Span::from_millis(60);
/// Limit for a part of a drive. Assumption: a step of the K2A's heading of 0.3 deg, and a play of the steering of 0.5 deg,
/// the greatest of its class.
const PART_APART_MAX: Angle = Angle::from_deg(0.8);
/// Least length of a part; at most twice that.
const PART: Span = Span::from_secs(1);
/// Duration for which they may differ by more: as long as a gyro may be silent.
const PATIENCE: Span = Span::from_millis(100);

/// Compares the headings from the start of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct HeadingWatch {
    start: Option<Heard>,
    last_path: Length,
    path: Length,
    /// The larger of the two turns.
    turned: Angle,
    part: Part,
    apart_since: Option<Timestamp>,
    part_apart_since: Option<Timestamp>,
}

/// The last part of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Part {
    start: Option<Heard>,
    /// Start of the next part, and when it was heard.
    next: Option<(Timestamp, Heard)>,
}

/// State at a motion message of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Heard {
    pub(crate) gyro: Angle,
    pub(crate) odometry: Angle,
    pub(crate) displacement: Length,
    /// The gyro's rate, or zero if the base stands: one of the two headings is older by this rate times a time.
    pub(crate) rate: AngularRate,
}

impl HeadingWatch {
    /// The next motion message starts a comparison.
    pub(crate) fn begin(&mut self) {
        *self = Self::default();
    }

    /// Takes a motion message. Returns true while the headings have differed by too much for too long.
    pub(crate) fn differs(&mut self, now: Timestamp, heard: Heard) -> bool {
        let Some(start) = self.start else {
            self.start = Some(heard);
            self.last_path = heard.displacement;
            return false;
        };
        self.path += (heard.displacement - self.last_path).abs();
        self.last_path = heard.displacement;
        self.turned = self.turned.max(turned(start, heard));
        let alike = self.agree(start, heard);
        let part_alike = self.part.agrees(now, heard);
        is_late(&mut self.apart_since, now, alike)
            | is_late(&mut self.part_apart_since, now, part_alike)
    }

    /// True if they may differ like that at the end of a drive, where both stand: nothing is late, and nothing will change
    /// by waiting.
    pub(crate) fn agree_at_rest(&self, gyro: Angle, odometry: Angle) -> bool {
        let displacement = self.last_path;
        let heard = Heard { gyro, odometry, displacement, rate: AngularRate::ZERO };
        self.start.is_none_or(|start| self.agree(start, heard))
            && self.part.start.is_none_or(|start| Part::agree(start, heard))
    }

    fn agree(&self, start: Heard, heard: Heard) -> bool {
        apart(start, heard) <= APART_MAX + grows(self.turned, self.path) + heard.rate.abs() * AGE
    }
}

impl Part {
    /// Takes a motion message; true if the headings turned alike since the start of the part.
    fn agrees(&mut self, now: Timestamp, heard: Heard) -> bool {
        let (since, next) = *self.next.get_or_insert((now, heard));
        if now - since >= PART {
            self.start = Some(next);
            self.next = Some((now, heard));
        }
        self.start.is_none_or(|start| Self::agree(start, heard))
    }

    fn agree(start: Heard, heard: Heard) -> bool {
        let path = (heard.displacement - start.displacement).abs();
        // At its start, too, one of the two may have been late.
        let late = (heard.rate.abs() + start.rate.abs()) * AGE;
        apart(start, heard) <= PART_APART_MAX + grows(turned(start, heard), path) + late
    }
}

/// Difference between the turns of the two headings.
fn apart(start: Heard, heard: Heard) -> Angle {
    ((heard.gyro - start.gyro) - (heard.odometry - start.odometry)).abs()
}

/// The larger of the two turns.
fn turned(start: Heard, heard: Heard) -> Angle {
    (heard.gyro - start.gyro).abs().max((heard.odometry - start.odometry).abs())
}

/// By how much a base like the paper's may err over such a turn and path.
fn grows(turned: Angle, path: Length) -> Angle {
    turned * APART_PER_TURN + Angle::from_deg(APART_DEG_PER_M * path.m())
}

/// True if the headings have not been alike for too long.
fn is_late(since: &mut Option<Timestamp>, now: Timestamp, alike: bool) -> bool {
    if alike {
        *since = None;
        return false;
    }
    now - *since.get_or_insert(now) >= PATIENCE
}

#[cfg(test)]
mod tests {
    use super::{Angle, AngularRate, HeadingWatch, Heard, Length, Span, Timestamp};

    /// A turn of 90 deg at 30 deg/s, or 4 m, as both report it; returns when the difference is noticed, s.
    fn noticed(rate_deg: f64, both: impl Fn(f64) -> (f64, f64), speed: f64) -> Option<f64> {
        let mut watch = HeadingWatch::default();
        watch.begin();
        (0..500).map(|n| f64::from(n) * 0.02).find(|&s| {
            let driven_s = s.min(if speed > 0.0 { 10.0 } else { 3.0 });
            let (gyro, odometry) = both(driven_s);
            let heard = Heard {
                gyro: Angle::from_deg(gyro),
                odometry: Angle::from_deg(odometry),
                displacement: Length::from_m(speed * driven_s),
                rate: AngularRate::from_deg_per_s(if driven_s == s { rate_deg } else { 0.0 }),
            };
            watch.differs(Timestamp::ZERO + Span::from_secs_f64(s), heard)
        })
    }

    #[test]
    fn the_papers_base_and_a_good_gyro_agree() {
        // Quantised to 0.3 deg, 60 ms late, with the errors of the shipped base and as much again in the gyro.
        let step = |deg: f64| (deg / 0.3).round() * 0.3;
        assert_eq!(
            noticed(30.0, |s| (30.0 * s * 0.99, step(30.0 * (s - 0.05) * 1.011)), 0.0),
            None
        );
        assert_eq!(noticed(0.0, |s| (0.01 * s, step(-0.125 * 0.4 * s)), 0.4), None);
    }

    #[test]
    fn a_gyro_that_stops_or_drifts_away_is_noticed() {
        let at = noticed(30.0, |s| (30.0 * s.min(1.0), 30.0 * s), 0.0).expect("it stood for 2 s");
        assert!((1.0..1.4).contains(&at), "{at}");
        assert!(noticed(0.0, |s| (0.3 * s, 0.0), 0.4).is_some());
    }

    /// 3,000 deg/h for 1.6 s leave 1.3 deg: the whole line of 4 m may err by 2 deg, two seconds of it by less.
    #[test]
    fn a_leap_of_the_bias_shows_on_a_straight_line() {
        let step = |deg: f64| (deg / 0.3).round() * 0.3;
        let leap = |s: f64| 3_000.0 / 3_600.0 * (s - 4.0).clamp(0.0, 1.6);
        // The steering follows the gyro.
        let at = noticed(0.0, |s| (0.0, step(-leap(s) - 0.125 * 0.4 * s)), 0.4).expect("it leapt");
        assert!((4.9..6.0).contains(&at), "{at}");
        // Play of the steering, by the end of which the odometry is ahead.
        assert_eq!(noticed(0.0, |s| (0.0, step(0.5 * f64::from(u8::from(s > 4.0)))), 0.4), None);
    }

    /// Found by a campaign: a gyro that drifted while the base crept, and the base's last word came as it stood.
    #[test]
    fn at_the_end_of_a_drive_nothing_is_late() {
        let mut watch = HeadingWatch::default();
        let heard = |gyro, odometry| Heard {
            gyro: Angle::from_deg(gyro),
            odometry: Angle::from_deg(odometry),
            displacement: Length::ZERO,
            rate: AngularRate::from_deg_per_s(30.0),
        };
        let at = |s| Timestamp::from_secs_f64(s);
        assert!(!watch.differs(at(0.0), heard(0.0, 0.0)));
        assert!(!watch.differs(at(9.0), heard(-90.0, -94.8)), "it may be late");
        let deg = Angle::from_deg;
        assert!(!watch.agree_at_rest(deg(-90.0), deg(-94.8)));
        assert!(watch.agree_at_rest(deg(-90.0), deg(-93.0)));
        watch.begin();
        assert!(watch.agree_at_rest(deg(0.0), deg(50.0)), "nothing to compare with");
    }

    /// Found by a campaign: a bias that leapt while the base was silent, which ended after the base was heard to stand.
    #[test]
    fn a_leap_during_a_silence_shows_as_soon_as_the_base_is_heard_to_stand() {
        let mut watch = HeadingWatch::default();
        let heard = |gyro| Heard {
            gyro: Angle::from_deg(gyro),
            odometry: Angle::from_deg(-90.0),
            displacement: Length::ZERO,
            rate: AngularRate::ZERO,
        };
        for tenth in 0..20 {
            let at = Timestamp::ZERO + Span::from_millis(100 * tenth);
            assert!(!watch.differs(at, heard(-90.0)));
        }
        assert!(!watch.differs(Timestamp::from_secs_f64(2.8), heard(-88.7)), "it may be late");
        let at_rest = |gyro| watch.agree_at_rest(Angle::from_deg(gyro), Angle::from_deg(-90.0));
        assert!(!at_rest(-88.7) && at_rest(-89.3));
    }

    #[test]
    fn what_is_late_for_a_moment_is_not_wrong() {
        let late = |s: f64| if (1.0..1.09).contains(&s) { 30.0 } else { 30.0 * s };
        assert_eq!(noticed(30.0, |s| (late(s), 30.0 * s), 0.0), None);
    }
}
