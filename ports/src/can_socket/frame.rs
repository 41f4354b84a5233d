//! Frames as the socket has them, and as everybody else has them.

use socketcan::{CanRawFrame, EmbeddedFrame as _};
use wire::can::CanFrame;
use wire::can_error::{CanErrorEvent, ERROR_FLAG};

/// What a read gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// A frame.
    Frame(CanFrame),
    /// What the interface says of the bus.
    Error(CanErrorEvent),
    /// More data than a classic frame holds.
    Unsupported,
}

/// What a frame of a raw socket is.
pub fn from_socket(frame: &CanRawFrame) -> Heard {
    let (id, length, data): (u32, u8, &[u8]) = match frame {
        CanRawFrame::Classic(frame) => (frame.can_id, frame.can_dlc, &frame.data),
        CanRawFrame::Fd(frame) => (frame.can_id, frame.len, &frame.data),
    };
    let length = usize::from(length);
    if id & ERROR_FLAG != 0 {
        return Heard::Error(CanErrorEvent::decode(id, data.get(..length).unwrap_or(data)));
    }
    CanFrame::of_word(id, length, data).map_or(Heard::Unsupported, Heard::Frame)
}

/// As a raw socket takes it; `None` where it cannot.
pub fn to_socket(frame: &CanFrame) -> Option<socketcan::CanFrame> {
    if frame.is_remote() {
        socketcan::CanFrame::new_remote(frame.id(), frame.dlc())
    } else {
        socketcan::CanFrame::new(frame.id(), frame.data())
    }
}
