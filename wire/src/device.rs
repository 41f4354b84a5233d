//! What every end of a line does: it is fed and emptied, and time is an argument.

use crate::can::CanFrame;
use crate::packet::Packet;
use crate::time::Timestamp;
use core::fmt::Debug;

/// What is sent at once: some bytes of a serial line, or a frame of a CAN bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transmit {
    /// On a serial line.
    Bytes(Packet),
    /// On a CAN bus.
    Frame(CanFrame),
}

/// A port of a device, by its place among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PortId(pub u8);

/// A device without IO and without a clock: an emulator, or a controller.
///
/// After each of [`receive`](Self::receive) and [`wake`](Self::wake) its owner takes what it has to send, until there is
/// nothing, and asks when it wants to be woken.
pub trait Device: Debug + Send {
    /// Takes what arrived at a port: bytes as they come, or one frame.
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit);

    /// Does what is due `now`.
    fn wake(&mut self, now: Timestamp);

    /// When [`wake`](Self::wake) has something to do, if nothing arrives before; [`Timestamp::MAX`]: never.
    fn next_wakeup(&self) -> Timestamp;

    /// What goes out next, and at which port.
    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)>;
}
