//! CAN frames as they cross the link: `struct can_frame` of `linux/can.h`.

use embedded_can::Frame as _;
use wire::can::{CanFrame, ExtendedId, Id, StandardId};

/// Bytes of a frame.
pub(crate) const FRAME_BYTES: usize = 16;
const EXTENDED: u32 = 1 << 31;
const REMOTE: u32 = 1 << 30;
const ERROR: u32 = 1 << 29;

/// The frame as the shim knows it.
pub(crate) fn encode(frame: &CanFrame) -> [u8; FRAME_BYTES] {
    let id = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() | EXTENDED,
    };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let mut bytes = [0; FRAME_BYTES];
    bytes[..4].copy_from_slice(&(id | remote).to_ne_bytes());
    bytes[4] = frame.dlc() as u8;
    bytes[8..8 + frame.data().len()].copy_from_slice(frame.data());
    bytes
}

/// The frame that a program sent; `None` for an error message, or one that is no frame.
pub(crate) fn decode(bytes: &[u8; FRAME_BYTES]) -> Option<CanFrame> {
    let word = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let length = usize::from(bytes[4]);
    if word & ERROR != 0 {
        return None;
    }
    let id = if word & EXTENDED != 0 {
        Id::Extended(ExtendedId::new(word & ExtendedId::MAX.as_raw())?)
    } else {
        Id::Standard(StandardId::new((word & u32::from(StandardId::MAX.as_raw())) as u16)?)
    };
    if word & REMOTE != 0 {
        CanFrame::new_remote(id, length)
    } else {
        CanFrame::new(id, bytes.get(8..8 + length)?)
    }
}

#[cfg(test)]
mod tests {
    use super::{decode, encode};
    use embedded_can::Frame as _;
    use wire::can::{CanFrame, ExtendedId, StandardId};

    #[test]
    fn frames_cross_the_link_and_errors_do_not() {
        let standard = CanFrame::new(StandardId::new(0x123).unwrap(), &[1, 2, 3]).unwrap();
        let extended = CanFrame::new(ExtendedId::new(0x1234_5678).unwrap(), &[]).unwrap();
        let remote = CanFrame::new_remote(StandardId::MAX, 4).unwrap();
        for frame in [standard, extended, remote] {
            assert_eq!(decode(&encode(&frame)), Some(frame));
        }
        let mut error = encode(&standard);
        error[3] |= 0x20;
        assert_eq!(decode(&error), None);
        let mut long = encode(&standard);
        long[4] = 9;
        assert_eq!(decode(&long), None);
    }
}
