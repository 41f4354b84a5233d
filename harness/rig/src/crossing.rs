//! How packets and frames get from one end of a simulated bench's lines to the other.
//!
//! Virtual time does not notice: at the instant at which a packet has arrived it goes in at one end, and what comes out
//! at the other is what the receiver gets. Without a crossing that is the packet itself. With `Kernel` (crate `live`) it
//! is what was read from a pty or a CAN socket after the packet was written to the
//! other side; nothing waits, and a lap takes as long as its system calls.
//!
//! Verdicts and records do not depend on the crossing. A crossing that loses or changes anything ends the run with an
//! error.

mod failure;

pub use failure::{CrossingFailure, How};

use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Timestamp;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrossedLine {
    /// Name in messages: that of the device at one end, or of the line itself.
    pub name: Arc<str>,
    pub is_can: bool,
    /// A CAN FD bus.
    pub is_fd: bool,
    /// The device's end; what it sends goes toward the host.
    pub device_end: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Toward {
    Device,
    /// To the controller or the plan.
    Host,
}

/// The kernel's part in a crossing. Serial lines cross ptys in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelBus {
    /// Ptys only: a CAN bus has no pty.
    Pty,
    /// Frames cross `vcan0`.
    Vcan,
    /// Frames cross a pty as the lines of an slcan adapter.
    Slcan,
}

/// Carries packets and frames from end to end at one instant.
pub trait Crossing: Send {
    /// Carries what the end `from` of the line sent, both by their places in the rig, and replaces it with what comes
    /// out. Returns `false` if it did not get through.
    fn carry(&mut self, now: Timestamp, line: usize, from: usize, what: &mut Transmit) -> bool;

    /// Returns what else came out at once, in order, after the last call of `carry`.
    fn more(&mut self) -> Option<Transmit> {
        None
    }

    /// Returns the failure since the last call. A failed line carries nothing more.
    fn failure(&mut self) -> Option<CrossingFailure>;

    /// Name of the medium for a summary.
    fn bus(&self) -> &'static str;
}

/// A crossing, or none: then everything stays in memory.
pub type MaybeCrossing = Option<Box<dyn Crossing>>;

/// Name of the medium for a summary.
pub fn bus_of(crossing: &MaybeCrossing) -> &'static str {
    crossing.as_ref().map_or("memory", |crossing| crossing.bus())
}
