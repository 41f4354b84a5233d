//! The interface of every device on a line: a state machine with time as an argument.

use crate::can::CanFrame;
use crate::packet::Packet;
use crate::time::Timestamp;
use core::fmt::Debug;

/// A unit of transmission: bytes of a serial line, or a frame of a CAN bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transmit {
    /// On a serial line.
    Bytes(Packet),
    /// On a CAN bus.
    Frame(CanFrame),
}

impl Transmit {
    /// Its bytes, to be written; a frame becomes no bytes.
    #[inline]
    pub const fn packet_mut(&mut self) -> &mut Packet {
        if let Self::Frame(_) = self {
            *self = Self::Bytes(Packet::new());
        }
        match self {
            Self::Bytes(packet) => packet,
            Self::Frame(_) => unreachable!(),
        }
    }
}

/// A port of a device, by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PortId(pub u8);

/// A device without IO and without a clock: an emulator or a controller.
///
/// After each call of [`receive`](Self::receive) or [`wake`](Self::wake) the owner calls [`transmit`](Self::transmit)
/// until it returns `None`, and then asks for the next wake-up.
pub trait Device: Debug + Send {
    /// Takes input of a port: bytes in runs of any length, or one frame.
    fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit);

    /// Does the work due at `now`.
    fn wake(&mut self, now: Timestamp);

    /// Time at which [`wake`](Self::wake) has work if nothing arrives before; [`Timestamp::MAX`]: never.
    fn next_wakeup(&self) -> Timestamp;

    /// The next output and its port.
    fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)>;
}
