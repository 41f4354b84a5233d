//! How packets and frames get from one end of a simulated bench's lines to the other.
//!
//! Time is virtual and does not notice: at the instant at which a packet has arrived it goes in at one end,
//! and what comes out at the other is what the receiver gets. With [`Memory`] that is the packet itself. With
//! `Kernel` (crate `live`) it is what was read from a pty or a CAN socket after the packet was written to
//! the other side, so that a lap takes what its system calls take and nothing waits.
//!
//! Verdicts and records do not depend on the crossing. One that loses or changes anything ends the run in
//! error.

mod failure;

pub use failure::{CrossingFailure, How};

use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Timestamp;

/// A line that is crossed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrossedLine {
    /// As messages name it: after the device at its one end, or by its own name.
    pub name: Arc<str>,
    /// It is a CAN bus.
    pub is_can: bool,
    /// Which of its ends is the device's; what comes from there goes toward the host.
    pub device_end: usize,
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
    /// Ptys only: a CAN bus has no pty.
    Pty,
    /// Frames cross `vcan0`.
    Vcan,
    /// Frames cross a pty as the lines of an slcan adapter.
    Slcan,
}

/// What carries packets and frames from end to end at one instant.
pub trait Crossing {
    /// Carries what the end `from` of the line sent, both by their places in the rig; what comes out takes its place.
    /// `false` when it did not get through.
    fn carry(&mut self, now: Timestamp, line: usize, from: usize, what: &mut Transmit) -> bool;

    /// What else came out at once, in order, after what was carried last.
    #[inline(always)]
    fn more(&mut self) -> Option<Transmit> {
        None
    }

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
    fn carry(&mut self, _: Timestamp, _: usize, _: usize, _: &mut Transmit) -> bool {
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
