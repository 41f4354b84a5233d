//! Inputs of a monitor.

use controller::Output;
use controller::mission::{Mission, Report};
use described::Decoded;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::units::{Angle, AngularRate, Pose, Speed};

/// True state of the base at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Pose; the heading is the turret's, not wrapped.
    pub pose: Pose,
    /// Speed along the path; negative backwards.
    pub speed: Speed,
    /// Speed at which the wheels turn: the same, unless they slip.
    pub wheels: Speed,
    /// The angle that leaps of the gyro's bias have added so far.
    pub leapt: Angle,
    /// Rate of the steering.
    pub steer_rate: AngularRate,
    /// What drive and steering follow: the orders, on the base's ramps.
    pub followed: (Speed, AngularRate),
}

/// One event. At the same instant the truth comes before everything judged by it.
#[derive(Debug, Clone, Copy)]
pub enum Seen<'a> {
    /// The true state of the base now.
    Truth(Truth),
    /// The controller received these bytes from the gyro.
    GyroBytes(&'a [u8]),
    /// The controller received these bytes from the base.
    BaseBytes(&'a [u8]),
    /// The controller received this frame from the base's bus.
    BaseFrame(&'a CanFrame),
    /// The controller received this mission.
    Told(&'a Mission),
    /// The controller sent this output.
    Sent(&'a Output),
    /// The controller sent this report.
    Report(&'a Report),
    /// A step of the plan began.
    StepBegan,
    /// It ended.
    StepEnded,
    /// A person moved the robot.
    Placed,
    /// The number of active faults changed to this.
    Faults(usize),
    /// An output of the controller has come through its line.
    Carried(&'a Transmit),
    /// The base did not say what was heard last: it was changed on its way.
    Misheard,
    /// A node went bus-off after too many errors.
    BusOff,
    /// A message of a node arrived.
    Message {
        /// The sender, as an index of the rig's speakers.
        speaker: usize,
        /// Decoded values, with the state of counter and checksum.
        decoded: Decoded<'a>,
    },
}
