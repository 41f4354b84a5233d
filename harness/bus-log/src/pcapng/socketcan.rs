//! A packet of `LINKTYPE_CAN_SOCKETCAN` (tcpdump.org/linktypes/LINKTYPE_CAN_SOCKETCAN.html).
//!
//! | bytes | contents |
//! |---|---|
//! | 4 | identifier, **big-endian**, with `CAN_EFF_FLAG`, `CAN_RTR_FLAG`, `CAN_ERR_FLAG` of linux/can.h |
//! | 1 | length of the data |
//! | 1 | `CANFD_BRS`, `CANFD_ESI`, and `CANFD_FDF` that makes it a CAN FD frame |
//! | 2 | reserved |
//! | … | the data |

use super::super::entry::{ErrorFrame, Payload};
use super::super::error::Defect;
use wire::can::{
    CanFrame, DATA_BYTES_MAX, EXTENDED_FLAG, FD_FLAG, FdFlags, REMOTE_FLAG, StandardId,
};
use wire::can_error::ERROR_FLAG;

pub const HEADER_BYTES: usize = 8;

/// Appends the packet of a frame; `false` if the payload is not a frame.
pub(super) fn push(packet: &mut Vec<u8>, payload: &Payload) -> bool {
    let (id, length, flags, data) = match payload {
        Payload::Frame(frame) => {
            let flags = frame.fd_flags().map_or(0, |flags| flags.bits() | FD_FLAG);
            (frame.word(), frame.length(), flags, frame.data())
        }
        Payload::Error(error) => {
            (error.class() | ERROR_FLAG, DATA_BYTES_MAX, 0, &error.details[..])
        }
        Payload::Serial(_) => return false,
    };
    packet.extend(id.to_be_bytes());
    // A frame has at most 64 bytes.
    packet.extend([length as u8, flags, 0, 0]);
    packet.extend_from_slice(data);
    true
}

/// Parses the frame in a packet. Ignores bytes after its data, as in a buffer of a whole `struct can_frame`.
pub(super) fn parse(packet: &[u8]) -> Result<Payload, Defect> {
    let Some((header, data)) = packet.split_first_chunk::<HEADER_BYTES>() else {
        return Err(Defect::new("a packet of at least 8 bytes", packet));
    };
    let [a, b, c, d, length, flags, ..] = *header;
    let id = u32::from_be_bytes([a, b, c, d]);
    let length = usize::from(length);
    let bad = |expected| Err(Defect::new(expected, format!("{header:02x?}")));
    let raw = id & !(EXTENDED_FLAG | REMOTE_FLAG | ERROR_FLAG);
    if id & ERROR_FLAG != 0 {
        let mut details = [0; DATA_BYTES_MAX];
        let known = length.min(data.len()).min(DATA_BYTES_MAX);
        details[..known].copy_from_slice(&data[..known]);
        // The mask leaves 29 bits.
        return Ok(Payload::Error(ErrorFrame::new(raw, details).unwrap_or(ErrorFrame::BUS_ERROR)));
    }
    if id & EXTENDED_FLAG == 0 && raw > u32::from(StandardId::MAX.as_raw()) {
        return bad("an identifier of 11 bits without its flag");
    }
    let is_remote = id & REMOTE_FLAG != 0;
    if !is_remote && data.len() < length {
        return bad("as many bytes as the length says");
    }
    let is_fd = !is_remote && (flags & FD_FLAG != 0 || length > DATA_BYTES_MAX);
    let frame = CanFrame::of_word(id, is_fd.then(|| FdFlags::from_bits(flags)), length, data);
    frame.map_or_else(
        || bad("a length that such a frame can have"),
        |frame| Ok(Payload::Frame(frame)),
    )
}

#[cfg(test)]
mod tests {
    use super::{Payload, parse, push};
    use proptest::prelude::*;

    #[test]
    fn a_frame_as_wireshark_has_it() {
        // Example from the description of the link type: 0x12345678 extended, three bytes.
        let packet = [0x92, 0x34, 0x56, 0x78, 3, 0, 0, 0, 0xaa, 0xbb, 0xcc];
        let payload = parse(&packet).unwrap();
        let Payload::Frame(frame) = payload else { panic!("{payload:?}") };
        assert_eq!(frame.data(), [0xaa, 0xbb, 0xcc]);
        let mut again = Vec::new();
        assert!(push(&mut again, &payload));
        assert_eq!(again, packet);
    }

    proptest! {
        #[test]
        fn no_packet_makes_it_panic(packet in prop::collection::vec(any::<u8>(), 0..100)) {
            if let Ok(payload) = parse(&packet) {
                let mut again = Vec::new();
                prop_assert!(push(&mut again, &payload));
                prop_assert_eq!(parse(&again).unwrap(), payload);
            }
        }
    }
}
