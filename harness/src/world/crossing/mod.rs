//! How packets and frames get from one end of a simulated bench's lines to the other.
//!
//! Time is virtual and does not notice: at the instant at which a packet has arrived it goes in at one end,
//! and what comes out at the other is what the receiver gets. With [`Memory`] that is the packet itself. With
//! `Kernel` (feature `live`) it is what was read from a pty or a CAN socket after the packet was written to
//! the other side, so that a lap takes what its system calls take and nothing waits.
//!
//! Verdicts and records do not depend on the crossing. One that loses or changes anything ends the run in
//! error.

#[cfg(feature = "live")]
mod can_wire;
mod failure;
#[cfg(feature = "live")]
mod kernel;
#[cfg(feature = "live")]
mod pty_wire;
#[cfg(feature = "live")]
mod slcan_wire;
#[cfg(test)]
#[cfg(feature = "live")]
mod tests;
#[cfg(feature = "live")]
mod wait;

pub use failure::{CrossingFailure, How};
#[cfg(feature = "live")]
pub use kernel::{Kernel, KernelError, VCAN_INTERFACE};

use std::fmt;
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// A line of the bench, named after the device at its one end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// The gyro and the controller.
    Gyro,
    /// The base and the controller, by serial line or CAN.
    Base,
    /// The table and the plan.
    Table,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gyro => "gyro",
            Self::Base => "base",
            Self::Table => "table",
        })
    }
}

/// Which way something goes on a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toward {
    /// To the device.
    Device,
    /// To the controller, or to the plan.
    Host,
}

/// What of the kernel the lines of a bench cross. Serial lines cross ptys in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelBus {
    /// Ptys alone: benches whose base is on CAN have none for it.
    Pty,
    /// Frames cross `vcan0`.
    Vcan,
    /// Frames cross a pty as the lines of an slcan adapter.
    Slcan,
}

/// What carries packets and frames from end to end at one instant.
pub trait Crossing {
    /// Carries bytes; what comes out takes the packet's place. `false` when it did not get through.
    fn bytes(&mut self, line: Line, toward: Toward, packet: &mut Packet) -> bool;

    /// Carries a frame between the controller and the base, likewise.
    fn frame(&mut self, now: Timestamp, toward: Toward, frame: &mut CanFrame) -> bool;

    /// What went wrong since this was last asked. A line that failed carries nothing more.
    fn failure(&mut self) -> Option<CrossingFailure>;

    /// What is crossed, as a summary says it.
    fn bus(&self) -> &'static str;
}

/// Nothing is crossed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Memory;

impl Crossing for Memory {
    #[inline(always)]
    fn bytes(&mut self, _: Line, _: Toward, _: &mut Packet) -> bool {
        true
    }

    #[inline(always)]
    fn frame(&mut self, _: Timestamp, _: Toward, _: &mut CanFrame) -> bool {
        true
    }

    #[inline(always)]
    fn failure(&mut self) -> Option<CrossingFailure> {
        None
    }

    fn bus(&self) -> &'static str {
        "memory"
    }
}
