//! Frames as the socket has them, and as everybody else has them.

use socketcan::{CanAnyFrame, CanFdFrame, CanRawFrame, EmbeddedFrame as _};
use wire::can::{CanFrame, FdFlags};
use wire::can_error::{CanErrorEvent, ERROR_FLAG};

/// What a read gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// A frame.
    Frame(CanFrame),
    /// What the interface says of the bus.
    Error(CanErrorEvent),
    /// Data of a length that such a frame does not have.
    Unsupported,
}

/// What a frame of a raw socket is.
pub fn from_socket(frame: &CanRawFrame) -> Heard {
    let (id, fd, length, data): (u32, Option<FdFlags>, u8, &[u8]) = match frame {
        CanRawFrame::Classic(frame) => (frame.can_id, None, frame.can_dlc, &frame.data),
        CanRawFrame::Fd(frame) => {
            (frame.can_id, Some(FdFlags::from_bits(frame.flags)), frame.len, &frame.data)
        }
    };
    let length = usize::from(length);
    if id & ERROR_FLAG != 0 {
        return Heard::Error(CanErrorEvent::decode(id, data.get(..length).unwrap_or(data)));
    }
    CanFrame::of_word(id, fd, length, data).map_or(Heard::Unsupported, Heard::Frame)
}

/// As a raw socket takes it; `None` where it cannot.
pub fn to_socket(frame: &CanFrame) -> Option<CanAnyFrame> {
    if let Some(flags) = frame.fd_flags() {
        let flags = socketcan::id::FdFlags::from_bits_truncate(flags.bits());
        return CanFdFrame::with_flags(frame.id(), frame.data(), flags).map(CanAnyFrame::Fd);
    }
    if frame.is_remote() {
        socketcan::CanRemoteFrame::new_remote(frame.id(), frame.dlc()).map(CanAnyFrame::Remote)
    } else {
        socketcan::CanDataFrame::new(frame.id(), frame.data()).map(CanAnyFrame::Normal)
    }
}
