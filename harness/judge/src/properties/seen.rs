//! What a monitor is shown, as it happens.

use controller::Output;
use controller::mission::{Mission, Report};
use described::Decoded;
use wire::can::CanFrame;
use wire::units::{AngularRate, Pose, Speed};

/// What is true of the base at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Where it is; the heading is the turret's, not wrapped.
    pub pose: Pose,
    /// Along the path; backward is negative.
    pub speed: Speed,
    /// Of the steering.
    pub steer_rate: AngularRate,
}

/// One thing that happened. The truth is shown before what is judged by it, at the same instant.
#[derive(Debug, Clone, Copy)]
pub enum Seen<'a> {
    /// What is true of the base now.
    Truth(Truth),
    /// The controller received these bytes from the gyro.
    GyroBytes(&'a [u8]),
    /// The controller received these bytes from the base.
    BaseBytes(&'a [u8]),
    /// The controller received this frame from the base's bus.
    BaseFrame(&'a CanFrame),
    /// The controller was given this mission.
    Told(&'a Mission),
    /// The controller sent this.
    Sent(&'a Output),
    /// The controller reported this.
    Report(&'a Report),
    /// A step of the plan, here called a lap, began.
    LapBegan,
    /// It ended.
    LapEnded,
    /// Somebody carried the robot elsewhere.
    Placed,
    /// So many faults are at work now.
    Faults {
        /// How many.
        active: usize,
        /// One of them that no input of the controller shows.
        unseen: Option<&'static str>,
    },
    /// A node left the bus for too many errors.
    BusOff,
    /// A message of a node has arrived.
    Message {
        /// Whose, by its place among the speakers of the rig.
        speaker: usize,
        /// What it says, and how its counter and checksum are.
        decoded: Decoded<'a>,
    },
}
