//! Moves of the base from rest to rest, from its own MOTION messages.
//!
//! The controller stops near the target and then corrects a stop that missed, so that one mission is often several
//! periods of motion. A period shorter than [`CORRECTION_MAX`] and [`CORRECTION_ANGLE_MAX`] belongs to the move before
//! it. Pose writes do not affect the displacement, but make the heading jump, so the heading is summed up only while
//! the base moves.

use wire::base::{Motion, Request};
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Length, Pose, Speed};

/// A period of motion with less displacement corrects the move before it. Assumption: 25 times the paper's
/// stop error of 2 mm, an eightieth of its shortest path.
pub const CORRECTION_MAX: Length = Length::from_m(0.05);

/// A period of motion with less turning corrects the move before it. Assumption: 50 times the paper's
/// error of 0.1 deg, an eighteenth of its corner.
pub const CORRECTION_ANGLE_MAX: Angle = Angle::from_deg(5.0);

/// Averaging time of a speed: ten messages of the cycle time in motion (GenMsgCycleTime of MOTION, 20 ms), so that the
/// displacement's step of 0.1 mm is 0.5 mm/s.
const SPEED_SPAN: Span = Span::from_millis(200);

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Time of the last message at rest before it.
    pub began: Timestamp,
    /// Time of the first message at rest after it, corrections included.
    pub ended: Timestamp,
    /// Distance by the base's displacement; backward is negative.
    pub travelled: Length,
    /// Angle by the base's odometry; counter-clockwise is positive.
    pub turned: Angle,
    /// Greatest mean speed over a fifth of a second, absolute.
    pub speed_max: Speed,
    /// Number of writes of the first pose written after the move, until the next move.
    pub pose_writes: u32,
}

impl Move {
    /// Whether the base travelled, and did not only turn on the spot.
    pub fn is_straight(&self) -> bool {
        self.travelled.abs() >= CORRECTION_MAX
    }
}

/// Detects moves in the frames of a base.
#[derive(Debug, Default)]
pub struct MoveWatch {
    rest: Option<(Timestamp, Motion)>,
    period: Option<Period>,
    /// The last move, which may still be corrected, and the pose written after it.
    open: Option<(Move, Option<Pose>)>,
    missed: bool,
    last_sequence: Option<u8>,
    lost: u64,
}

#[derive(Debug)]
struct Period {
    began: Timestamp,
    from: Motion,
    heading: Angle,
    turned: Angle,
    speed_since: (Timestamp, Length),
    speed_max: Speed,
}

impl MoveWatch {
    /// Takes a message of the base. Returns a move when the next one begins.
    pub fn motion(&mut self, at: Timestamp, motion: &Motion) -> Option<Move> {
        if let Some(last) = self.last_sequence.replace(motion.sequence) {
            self.lost += u64::from(motion.sequence.wrapping_sub(last).wrapping_sub(1));
        }
        if motion.moving {
            self.on_the_way(at, motion);
            return None;
        }
        let before = self.rest.replace((at, *motion));
        match (self.period.take(), before) {
            (Some(period), _) => self.period_over(at, motion, period),
            (None, Some((_, from))) => {
                // The base crept between two messages.
                let crept = motion.displacement - from.displacement;
                if let Some((open, _)) = &mut self.open {
                    open.travelled += crept;
                }
                None
            }
            (None, None) => None,
        }
    }

    /// Takes a request of the host.
    pub fn request(&mut self, request: &Request) {
        let Request::WritePose { pose, .. } = request else { return };
        if self.period.is_some() {
            return;
        }
        if let Some((open, written)) = &mut self.open {
            let first = written.get_or_insert(*pose);
            open.pose_writes += u32::from(first == pose);
        }
    }

    /// Ends the log; returns the last move, if there was one.
    pub fn finish(&mut self) -> Option<Move> {
        self.open.take().map(|(open, _)| open)
    }

    pub const fn is_moving(&self) -> bool {
        self.period.is_some()
    }

    /// Whether the log begins while the base moves: its first move is then incomplete.
    pub const fn missed_begin(&self) -> bool {
        self.missed
    }

    /// Messages of the base that are missing, by their sequence number.
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    fn on_the_way(&mut self, at: Timestamp, motion: &Motion) {
        let Some(period) = &mut self.period else {
            let Some((began, from)) = self.rest else {
                self.missed = true;
                return;
            };
            self.period = Some(Period {
                began,
                from,
                heading: motion.heading,
                turned: (motion.heading - from.heading).wrapped(),
                speed_since: (at, motion.displacement),
                speed_max: Speed::ZERO,
            });
            return;
        };
        period.turned += (motion.heading - period.heading).wrapped();
        period.heading = motion.heading;
        let (since, from) = period.speed_since;
        if at.since(since) >= SPEED_SPAN {
            let speed = (motion.displacement - from).m().abs() / at.since(since).as_secs_f64();
            period.speed_max = period.speed_max.max(Speed::from_m_per_s(speed));
            period.speed_since = (at, motion.displacement);
        }
    }

    fn period_over(&mut self, at: Timestamp, motion: &Motion, period: Period) -> Option<Move> {
        let travelled = motion.displacement - period.from.displacement;
        let turned = period.turned + (motion.heading - period.heading).wrapped();
        let corrects = travelled.abs() < CORRECTION_MAX && turned.abs() < CORRECTION_ANGLE_MAX;
        if corrects {
            if let Some((open, _)) = &mut self.open {
                open.travelled += travelled;
                open.turned += turned;
                open.ended = at;
            }
            return None;
        }
        let next = Move {
            began: period.began,
            ended: at,
            travelled,
            turned,
            speed_max: period.speed_max,
            pose_writes: 0,
        };
        self.open.replace((next, None)).map(|(open, _)| open)
    }
}
