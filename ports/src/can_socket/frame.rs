//! Conversion between the socket's frames and those of the bench.

use socketcan::{CanAnyFrame, CanFdFrame, CanRawFrame, EmbeddedFrame as _};
use wire::can::{CanFrame, FdFlags};
use wire::can_error::{CanErrorEvent, ERROR_FLAG};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    Frame(CanFrame),
    /// The interface's report on the bus.
    Error(CanErrorEvent),
    /// Data of a length that no such frame has.
    Unsupported,
}

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

/// Converts to a frame for a raw socket; `None` if that is impossible.
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
