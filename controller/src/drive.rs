//! Straight lines and turns: the paper's five loops.
//!
//! | loop | section | here |
//! |---|---|---|
//! | prescribed speed with ramps | 4.2.1 (1) | [`Approach`] on metres, `Loop::Prescribed` |
//! | position loop near the end | 4.2.1 (2) | [`Approach`] on metres, `Loop::Closing` |
//! | steering correction | 4.2.1 (3) | [`Drive::steering`], closed by the heading source |
//! | prescribed rate with ramps | 4.2.2 (1) | [`Approach`] on radians, `Loop::Prescribed` |
//! | orientation loop near the end | 4.2.2 (2) | [`Approach`] on radians, closed by the heading source |

use crate::approach::{Approach, Loop, Tuning};
use crate::config::MotionConfig;
use crate::follow_watch::FollowWatch;
use crate::mission::{
    Activity, HeadingSource, MissionId, MissionResult, Straight, StraightResult, Turn, TurnResult,
};
use crate::mutant::{Mutant, Planted};
use wire::base::HEADING_STEP;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate, Length, Pose, Speed};

/// A mission may take this many times its nominal duration ...
const TIME_LIMIT_FACTOR: f64 = 3.0;
/// ... and this much more.
const TIME_LIMIT_MARGIN: Span = Span::from_secs(10);
/// A stop within this many tolerances needs no further approach: the paper's band is two of them.
const STOP_TOLERANCES: f64 = 1.8;

/// Input of the loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sight {
    pub(crate) now: Timestamp,
    /// From the heading source.
    pub(crate) heading: Angle,
    pub(crate) gyro_heading: Angle,
    pub(crate) odometry_heading: Angle,
    pub(crate) displacement: Length,
    /// The base reports that it moves.
    pub(crate) moving: bool,
    /// Heading to hold (straight) or to reach (turn).
    pub(crate) reference: Angle,
    pub(crate) pose: Pose,
    /// The heading is not known well enough to go on.
    pub(crate) hold: bool,
}

/// Output of the loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Wish {
    /// These rates for one period.
    Rates { drive: Speed, steer: AngularRate },
    /// At rest, as near as it gets.
    Finished(MissionResult),
    /// Took too long.
    TimedOut,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    Straight { from: Length, distance: Length, heading_error_max: Angle },
    Turn { from_gyro: Angle, from_odometry: Angle },
}

/// A moving mission.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    pub(crate) id: MissionId,
    motion: Motion,
    /// +1 forward or counter-clockwise, -1 backward or clockwise.
    direction: f64,
    approach: Approach,
    tolerance: f64,
    began: Timestamp,
    commanding_since: Timestamp,
    give_up: Timestamp,
    at_rest_since: Option<Timestamp>,
    held: bool,
    follows: FollowWatch,
    planted: Planted,
}

impl Drive {
    pub(crate) fn straight(
        id: MissionId,
        order: Straight,
        config: &MotionConfig,
        sight: &Sight,
    ) -> Self {
        let tuning = Tuning {
            speed: order.speed.m_per_s(),
            acceleration: config.acceleration.m_per_s2(),
            gain: config.position_gain,
            creep: config.creep_speed.m_per_s(),
            tolerance: config.position_tolerance.m(),
            delay: config.loop_delay,
        };
        let motion = Motion::Straight {
            from: sight.displacement,
            distance: order.distance,
            heading_error_max: Angle::ZERO,
        };
        Self::new(id, motion, order.distance.m(), tuning, sight)
    }

    /// `sight.reference` is already the target heading.
    pub(crate) fn turn(
        id: MissionId,
        order: Turn,
        source: HeadingSource,
        config: &MotionConfig,
        sight: &Sight,
    ) -> Self {
        let tolerance = match source {
            HeadingSource::Gyro => config.orientation_tolerance,
            // The odometry cannot resolve less than half of its step.
            HeadingSource::Odometry => config.orientation_tolerance.max(HEADING_STEP * 0.5),
        };
        let tuning = Tuning {
            speed: order.rate.rad_per_s(),
            acceleration: config.angular_acceleration.rad_per_s2(),
            gain: config.orientation_gain,
            creep: config.creep_rate.rad_per_s(),
            tolerance: tolerance.rad(),
            delay: config.loop_delay,
        };
        let motion =
            Motion::Turn { from_gyro: sight.gyro_heading, from_odometry: sight.odometry_heading };
        Self::new(id, motion, order.angle.rad(), tuning, sight)
    }

    fn new(
        id: MissionId,
        motion: Motion,
        signed_distance: f64,
        tuning: Tuning,
        sight: &Sight,
    ) -> Self {
        let now = sight.now;
        let nominal_s =
            signed_distance.abs() / tuning.speed + 2.0 * tuning.speed / tuning.acceleration;
        Self {
            id,
            motion,
            direction: 1f64.copysign(signed_distance),
            approach: Approach::new(tuning),
            tolerance: tuning.tolerance,
            began: now,
            commanding_since: now,
            give_up: now + Span::from_secs_f64(TIME_LIMIT_FACTOR * nominal_s) + TIME_LIMIT_MARGIN,
            at_rest_since: None,
            held: false,
            follows: FollowWatch::new(sight.displacement, sight.odometry_heading),
            planted: Planted::default(),
        }
    }

    pub(crate) const fn plant(&mut self, planted: Planted) {
        self.planted = planted;
    }

    pub(crate) const fn activity(&self) -> Activity {
        match (&self.motion, self.approach.at()) {
            (_, Loop::Arrived) => Activity::Settling,
            (Motion::Straight { .. }, Loop::Prescribed) => Activity::StraightPrescribed,
            (Motion::Straight { .. }, Loop::Closing) => Activity::StraightPosition,
            (Motion::Turn { .. }, Loop::Prescribed) => Activity::TurnPrescribed,
            (Motion::Turn { .. }, Loop::Closing) => Activity::TurnOrientation,
        }
    }

    /// True while the mission commands motion.
    pub(crate) fn is_commanding(&self) -> bool {
        self.approach.at() != Loop::Arrived && !self.held
    }

    /// Start time of the current command.
    pub(crate) const fn commanding_since(&self) -> Timestamp {
        self.commanding_since
    }

    pub(crate) const fn is_straight(&self) -> bool {
        matches!(self.motion, Motion::Straight { .. })
    }

    /// True if the odometry is plausible at rest.
    pub(crate) fn could_be_there(&self, sight: &Sight) -> bool {
        self.follows.could_be_there(sight.displacement, sight.odometry_heading)
    }

    /// What it was commanded so far.
    pub(crate) const fn follows(&self) -> &FollowWatch {
        &self.follows
    }

    /// The path of a drive that is broken off at `now`, in which the base brakes by its ramp.
    pub(crate) fn broken_off(mut self, now: Timestamp, config: &MotionConfig) -> FollowWatch {
        self.follows.break_off(now, config.base_acceleration());
        self.follows
    }

    /// Runs one period of the loops.
    pub(crate) fn tick(&mut self, sight: &Sight, config: &MotionConfig) -> Wish {
        let wish = self.wish(sight, config);
        if let Wish::Rates { drive, steer } = wish {
            self.follows.tell(sight.now, drive, steer);
        }
        wish
    }

    fn wish(&mut self, sight: &Sight, config: &MotionConfig) -> Wish {
        if sight.now >= self.give_up {
            return Wish::TimedOut;
        }
        let heading_error = sight.reference - sight.heading;
        if let Motion::Straight { heading_error_max, .. } = &mut self.motion {
            *heading_error_max = heading_error_max.max(heading_error.abs());
        }
        let remaining = self.remaining(sight);
        if self.approach.at() == Loop::Arrived {
            return self.settle(sight, remaining, config);
        }
        if self.held && !sight.hold {
            self.commanding_since = sight.now;
        }
        self.held = sight.hold;
        if self.held {
            return self.hold(heading_error, config);
        }
        let speed = self.direction * self.approach.speed(remaining, config.period);
        if self.planted.is(Mutant::PoseWrittenInMotion)
            && self.is_straight()
            && !self.is_commanding()
        {
            return Wish::Finished(self.result(sight, remaining));
        }
        match self.motion {
            Motion::Straight { .. } => Wish::Rates {
                drive: Speed::from_m_per_s(speed),
                steer: self.steering(heading_error, config),
            },
            Motion::Turn { .. } => {
                Wish::Rates { drive: Speed::ZERO, steer: AngularRate::from_rad_per_s(speed) }
            }
        }
    }

    /// Slows down as fast as the base can follow, and stands.
    fn hold(&mut self, heading_error: Angle, config: &MotionConfig) -> Wish {
        let ramp = match self.motion {
            Motion::Straight { .. } => config.acceleration.m_per_s2(),
            Motion::Turn { .. } => config.angular_acceleration.rad_per_s2(),
        };
        let ramp = ramp * config.base_acceleration_margin;
        let speed = self.direction * self.approach.hold(ramp, config.period);
        match self.motion {
            Motion::Straight { .. } if speed != 0.0 => Wish::Rates {
                drive: Speed::from_m_per_s(speed),
                steer: self.steering(heading_error, config),
            },
            Motion::Straight { .. } => Wish::Rates { drive: Speed::ZERO, steer: AngularRate::ZERO },
            Motion::Turn { .. } => {
                Wish::Rates { drive: Speed::ZERO, steer: AngularRate::from_rad_per_s(speed) }
            }
        }
    }

    /// Remaining distance in the direction of the mission; negative after an overshoot.
    fn remaining(&self, sight: &Sight) -> f64 {
        let signed = match self.motion {
            Motion::Straight { from, distance, .. } => (from + distance - sight.displacement).m(),
            Motion::Turn { from_gyro, from_odometry }
                if self.planted.is(Mutant::TurnByOdometry) =>
            {
                let turned = sight.odometry_heading - from_odometry;
                (sight.reference - from_gyro - turned).rad()
            }
            Motion::Turn { .. } => (sight.reference - sight.heading).rad(),
        };
        signed * self.direction
    }

    /// Loop (3) of section 4.2.1.
    fn steering(&self, heading_error: Angle, config: &MotionConfig) -> AngularRate {
        if self.approach.at() == Loop::Arrived || self.planted.is(Mutant::SteeringLoopOpen) {
            return AngularRate::ZERO;
        }
        let gain = match self.planted.is(Mutant::SteeringReversed) {
            true => -config.steering_gain,
            false => config.steering_gain,
        };
        AngularRate::from_rad_per_s(gain * heading_error.rad()).limited(config.steering_rate_max)
    }

    /// Waits for rest, then checks again: a stop that missed is approached again.
    fn settle(&mut self, sight: &Sight, remaining: f64, config: &MotionConfig) -> Wish {
        let standing = Wish::Rates { drive: Speed::ZERO, steer: AngularRate::ZERO };
        if sight.moving {
            self.at_rest_since = None;
            return standing;
        }
        let since = *self.at_rest_since.get_or_insert(sight.now);
        if sight.now - since < config.settle {
            return standing;
        }
        // The mission's time limit ends this: a mission that is done is within its tolerance.
        if remaining.abs() > STOP_TOLERANCES * self.tolerance {
            self.at_rest_since = None;
            self.approach.reopen();
            self.commanding_since = sight.now;
            return standing;
        }
        Wish::Finished(self.result(sight, remaining))
    }

    fn result(&self, sight: &Sight, remaining: f64) -> MissionResult {
        // Positive means further than commanded, in either direction.
        let stop_error = -remaining;
        let duration = sight.now - self.began;
        match self.motion {
            Motion::Straight { heading_error_max, .. } => MissionResult::Straight(StraightResult {
                stop_error: Length::from_m(stop_error),
                heading_error_max,
                heading_error: sight.reference - sight.heading,
                duration,
                pose_writes: 0,
                pose: sight.pose,
            }),
            Motion::Turn { from_gyro, from_odometry, .. } => MissionResult::Turn(TurnResult {
                stop_error: Angle::from_rad(stop_error),
                gyro_angle: sight.gyro_heading - from_gyro,
                odometry_angle: sight.odometry_heading - from_odometry,
                duration,
            }),
        }
    }
}
