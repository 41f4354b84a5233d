//! The command set of a K2A-style synchro-drive base, once, for two transports.
//!
//! A host sends [`Request`]s; the base answers with [`Reply`]s. Each has one payload of at most eight
//! bytes ([`payload`]), laid out in `wire/dbc/k2a.dbc`:
//!
//! * on **CAN** ([`can_link`]) a payload is the data of the frame with the message's identifier, and
//!   the base sends [`Reply::Motion`] and [`Reply::Pose`] of its own accord;
//! * on the **serial** line ([`serial_link`]) it is what a Cybermotion-style write puts at the
//!   message's register address, or a read brings from it.
//!
//! | [`Message`] | CAN id | register | bytes | direction |
//! |---|---|---|---|---|
//! | set velocity | 0x101 | 1F00 | 4 | host to base |
//! | set acceleration | 0x102 | 1F08 | 4 | host to base |
//! | write pose | 0x103 | 1F10 | 8 | host to base |
//! | stop | 0x104 | 1F18 | 1 | host to base |
//! | motion | 0x181 | E000 | 8 | base to host |
//! | pose | 0x182 | E008 | 8 | base to host |
//!
//! The K2A's own addresses are not published. These are assumptions; 1F00 and E000 are the addresses
//! of the two published example lines ([`serial_link`]).
//!
//! # A pose write and its result
//!
//! A pose can be read in motion but written at rest only (the paper). Neither a CAN frame nor the one
//! checksum byte of the serial line can say so: both mean *received*, not *done*. Whether a pose was
//! taken over stands in [`Motion::pose_write`], and [`Motion::pose_write_counter`] says which write
//! that result belongs to. A host therefore counts its pose writes modulo [`POSE_WRITE_MODULUS`] and
//! waits for a [`Motion`] with the counter of its own. On both transports a write that is lost shows
//! as a counter that does not come, and may be repeated with the same counter.

pub mod can_link;
mod message;
pub mod payload;
pub mod serial_link;

pub use message::Message;

use crate::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};
use serde::{Deserialize, Serialize};

/// Resolution of the heading in the base's own odometry (the paper: 0.3 deg).
pub const HEADING_STEP: Angle = Angle::from_deg(0.3);

/// What a host asks of the base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Go at these rates; must be repeated within the base's command time-out.
    SetVelocity {
        /// Speed along the wheels' direction.
        drive: Speed,
        /// Rate at which the wheels and the turret steer.
        steer: AngularRate,
    },
    /// Change rates no faster than this. Both limits are above zero.
    SetAcceleration {
        /// Of the drive.
        drive: Acceleration,
        /// Of the steering.
        steer: AngularAcceleration,
    },
    /// Take this as your pose. Carried out at rest only; the result comes in [`Motion::pose_write`].
    WritePose {
        /// The pose, x and y within the range of the layout ([`payload`]: 419 m).
        pose: Pose,
        /// Comes back in [`Motion::pose_write`]; modulo [`POSE_WRITE_MODULUS`].
        counter: u8,
    },
    /// Stop with the acceleration limits in force, and forget the velocity command.
    Stop,
    /// Send [`Reply::Motion`] (serial only; on CAN it comes by itself).
    ReadMotion,
    /// Send [`Reply::Pose`] (serial only; on CAN it comes by itself).
    ReadPose,
}

/// Counter of pose writes runs modulo this.
pub const POSE_WRITE_MODULUS: u8 = 4;

/// What became of the last pose write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseWriteResult {
    /// None was received since power-up.
    #[default]
    None,
    /// Taken over.
    Accepted,
    /// Refused: the base was moving.
    RefusedInMotion,
    /// Refused: the base's own limits do not allow this pose.
    RefusedValue,
}

/// The base's motion, as its own odometry and status have it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Motion {
    /// Path length since power-up; backward motion counts down.
    #[serde(rename = "displacement_m")]
    pub displacement: Length,
    /// Heading by the base's odometry, in steps of [`HEADING_STEP`], in [-180, 180) deg.
    #[serde(rename = "heading_rad")]
    pub heading: Angle,
    /// Drive or steering is turning.
    pub moving: bool,
    /// No velocity command came in time; the base stopped by itself.
    pub command_timed_out: bool,
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// A drive reports a fault.
    pub fault: bool,
    /// What became of the last pose write.
    pub pose_write: PoseWriteResult,
    /// Counter of that pose write, modulo [`POSE_WRITE_MODULUS`].
    pub pose_write_counter: u8,
    /// Running number of this message, modulo 256.
    pub sequence: u8,
}

/// What the base tells a host.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// Odometry and status.
    Motion(Motion),
    /// The pose by the base's own dead reckoning. Its layout is finer than the odometry behind it
    /// ([`HEADING_STEP`]), since a written pose comes from a better source.
    Pose(Pose),
}
