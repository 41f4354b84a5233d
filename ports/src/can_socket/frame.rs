//! Frames as the socket has them, and as everybody else has them.

use socketcan::{CanRawFrame, EmbeddedFrame as _};
use wire::can::{CanFrame, DATA_BYTES_MAX, ExtendedId, Id, StandardId};
use wire::can_error::{CanErrorEvent, ERROR_FLAG};

/// An extended identifier (`CAN_EFF_FLAG` of `linux/can.h`).
const EXTENDED_FLAG: u32 = 1 << 31;
/// A remote request (`CAN_RTR_FLAG`).
const REMOTE_FLAG: u32 = 1 << 30;
/// The bits of an extended identifier (`CAN_EFF_MASK`).
const EXTENDED_MASK: u32 = (1 << 29) - 1;
/// The bits of a standard one (`CAN_SFF_MASK`).
const STANDARD_MASK: u16 = (1 << 11) - 1;

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
    let identifier = if id & EXTENDED_FLAG != 0 {
        ExtendedId::new(id & EXTENDED_MASK).map(Id::Extended)
    } else {
        StandardId::new(id as u16 & STANDARD_MASK).map(Id::Standard)
    };
    let frame = identifier.and_then(|identifier| {
        if id & REMOTE_FLAG != 0 {
            return CanFrame::new_remote(identifier, length);
        }
        let data = data.get(..length).filter(|data| data.len() <= DATA_BYTES_MAX)?;
        CanFrame::new(identifier, data)
    });
    frame.map_or(Heard::Unsupported, Heard::Frame)
}

/// As a raw socket takes it; `None` where it cannot.
pub fn to_socket(frame: &CanFrame) -> Option<socketcan::CanFrame> {
    if frame.is_remote() {
        socketcan::CanFrame::new_remote(frame.id(), frame.dlc())
    } else {
        socketcan::CanFrame::new(frame.id(), frame.data())
    }
}
