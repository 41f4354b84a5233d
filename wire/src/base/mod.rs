//! The command set of a K2A-style synchro-drive base, defined once for two transports.
//!
//! A host sends [`Request`]s; the base answers with [`Reply`]s. Each has one payload of at most eight
//! bytes ([`payload`]), laid out in `wire/dbc/k2a.dbc`:
//!
//! * on **CAN** ([`can_link`]) a payload is the data of the frame with the message's identifier, and the base sends
//!   [`Reply::Motion`] and [`Reply::Pose`] unprompted;
//! * on the **serial** line ([`serial_link`]) a Cybermotion-style write puts the payload at the message's register
//!   address, and a read fetches it from there.
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
//! A pose can be read in motion but written at rest only (the paper). Neither a CAN frame nor the checksum byte of the
//! serial line can report the result: both mean *received*, not *done*. [`Motion::pose_write`] reports whether a pose
//! was accepted, and [`Motion::pose_write_counter`] identifies the write that this result belongs to. A host therefore
//! counts its pose writes modulo [`POSE_WRITE_MODULUS`] and waits for a [`Motion`] with its own counter. On both
//! transports the counter of a lost write never appears, and the host may repeat the write with the same counter.

pub mod can_link;
mod message;
pub mod payload;
pub mod serial_link;

pub use message::Message;

use crate::units::{Acceleration, Angle, AngularAcceleration, AngularRate, Length, Pose, Speed};
use serde::{Deserialize, Serialize};

/// Resolution of the heading in the base's own odometry (the paper: 0.3 deg).
pub const HEADING_STEP: Angle = Angle::from_deg(0.3);

/// Requests of a host to the base.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Move at these rates; must be repeated within the base's command time-out.
    SetVelocity {
        /// Speed along the wheels' direction.
        drive: Speed,
        /// Rate at which the wheels and the turret steer.
        steer: AngularRate,
    },
    /// Limit the change of the rates. Both limits are above zero.
    SetAcceleration {
        /// Limit for the drive.
        drive: Acceleration,
        /// Limit for the steering.
        steer: AngularAcceleration,
    },
    /// Set the base's pose. Carried out at rest only; the result is in [`Motion::pose_write`].
    WritePose {
        /// The pose, x and y within the range of the layout ([`payload`]: 419 m).
        pose: Pose,
        /// Returned in [`Motion::pose_write_counter`]; modulo [`POSE_WRITE_MODULUS`].
        counter: u8,
    },
    /// Stop with the acceleration limits in force, and discard the velocity command.
    Stop,
    /// Send [`Reply::Motion`] (serial only; on CAN the base sends it unprompted).
    ReadMotion,
    /// Send [`Reply::Pose`] (serial only; on CAN the base sends it unprompted).
    ReadPose,
}

/// Modulus of the counter of pose writes.
pub const POSE_WRITE_MODULUS: u8 = 4;

/// Result of the last pose write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseWriteResult {
    /// No pose write since power-up.
    #[default]
    None,
    /// Accepted.
    Accepted,
    /// Refused: the base was moving.
    RefusedInMotion,
    /// Refused: the pose exceeds the base's own limits.
    RefusedValue,
}

/// The base's motion by its own odometry and status.
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
    /// No velocity command arrived in time; the base stopped by itself.
    pub command_timed_out: bool,
    /// The emergency stop is pressed.
    pub emergency_stop: bool,
    /// A drive reports a fault.
    pub fault: bool,
    /// Result of the last pose write.
    pub pose_write: PoseWriteResult,
    /// Counter of that pose write, modulo [`POSE_WRITE_MODULUS`].
    pub pose_write_counter: u8,
    /// Sequence number of this message, modulo 256.
    pub sequence: u8,
}

/// Replies of the base to a host.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// Odometry and status.
    Motion(Motion),
    /// The pose by the base's own dead reckoning. Its layout is finer than the odometry behind it
    /// ([`HEADING_STEP`]), since a written pose comes from a better source.
    Pose(Pose),
}
