//! A packet of `LINKTYPE_CAN_SOCKETCAN` (tcpdump.org/linktypes/LINKTYPE_CAN_SOCKETCAN.html).
//!
//! | bytes | what |
//! |---|---|
//! | 4 | identifier, **big-endian**, with `CAN_EFF_FLAG`, `CAN_RTR_FLAG`, `CAN_ERR_FLAG` of linux/can.h |
//! | 1 | length of the data |
//! | 1 | `CANFD_BRS`, `CANFD_ESI`, and `CANFD_FDF` that makes it a CAN FD frame |
//! | 2 | reserved |
//! | … | the data |

use super::super::entry::{ErrorFrame, FD_BYTES_MAX, FdFlags, FdFrame, Payload};
use super::super::error::Defect;
use embedded_can::Frame as _;
use wire::can::{
    CanFrame, DATA_BYTES_MAX, EXTENDED_FLAG, ExtendedId, Id, REMOTE_FLAG, StandardId, word,
};
use wire::can_error::ERROR_FLAG;

/// Bytes before the data.
pub const HEADER_BYTES: usize = 8;

/// The layout says that the frame is one of CAN FD.
const FDF: u8 = 0x04;

/// Appends the packet of a frame; false for what is none.
pub(super) fn push(packet: &mut Vec<u8>, payload: &Payload) -> bool {
    let (id, length, flags, data) = match payload {
        Payload::Frame(frame) => (frame.word(), frame.dlc(), 0, frame.data()),
        Payload::Fd(frame) => {
            let flags = frame.flags().bits() | FDF;
            (word(frame.id()), frame.data().len(), flags, frame.data())
        }
        Payload::Error(error) => {
            (error.class() | ERROR_FLAG, DATA_BYTES_MAX, 0, &error.details[..])
        }
        Payload::Serial(_) => return false,
    };
    packet.extend(id.to_be_bytes());
    // No frame is longer than 64 bytes.
    packet.extend([length as u8, flags, 0, 0]);
    packet.extend_from_slice(data);
    true
}

/// The frame in a packet. Bytes behind its data, as in a buffer of a whole `struct can_frame`, are not
/// read.
pub(super) fn parse(packet: &[u8]) -> Result<Payload, Defect> {
    let Some((header, data)) = packet.split_first_chunk::<HEADER_BYTES>() else {
        return Err(Defect::new("a packet of at least 8 bytes", packet));
    };
    let [a, b, c, d, length, flags, ..] = *header;
    let id = u32::from_be_bytes([a, b, c, d]);
    let length = usize::from(length);
    let bad = |expected| Err(Defect::new(expected, format!("{header:02x?}").as_bytes()));
    let raw = id & !(EXTENDED_FLAG | REMOTE_FLAG | ERROR_FLAG);
    if id & ERROR_FLAG != 0 {
        let mut details = [0; DATA_BYTES_MAX];
        let known = length.min(data.len()).min(DATA_BYTES_MAX);
        details[..known].copy_from_slice(&data[..known]);
        // The mask leaves 29 bits.
        return Ok(Payload::Error(ErrorFrame::new(raw, details).unwrap_or(ErrorFrame::BUS_ERROR)));
    }
    let id = if id & EXTENDED_FLAG != 0 {
        ExtendedId::new(raw).map(Id::Extended)
    } else {
        u16::try_from(raw).ok().and_then(StandardId::new).map(Id::Standard)
    };
    let Some(identifier) = id else { return bad("an identifier of 11 bits without its flag") };
    let is_remote = header[0] & (REMOTE_FLAG >> 24) as u8 != 0;
    if is_remote {
        return match CanFrame::new_remote(identifier, length) {
            Some(frame) => Ok(Payload::Frame(frame)),
            None => bad("a remote request for at most 8 bytes"),
        };
    }
    let Some(data) = data.get(..length) else { return bad("as many bytes as the length says") };
    let is_fd = flags & FDF != 0 || length > DATA_BYTES_MAX;
    let payload = match is_fd && length <= FD_BYTES_MAX {
        true => FdFrame::new(identifier, FdFlags::from_bits(flags), data).map(Payload::Fd),
        false => CanFrame::new(identifier, data).map(Payload::Frame),
    };
    payload.map_or_else(|| bad("a length that such a frame can have"), Ok)
}

#[cfg(test)]
mod tests {
    use super::{Payload, parse, push};
    use proptest::prelude::*;

    #[test]
    fn a_frame_as_wireshark_has_it() {
        // From the description of the link type: 0x12345678 extended, three bytes.
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
