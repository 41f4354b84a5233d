//! CAN frames as they cross the link: `struct can_frame` of `linux/can.h`.

use embedded_can::Frame as _;
use wire::can::CanFrame;
use wire::can_error::ERROR_FLAG;

/// Bytes of a frame.
pub(crate) const FRAME_BYTES: usize = 16;

/// The frame as the shim knows it.
pub(crate) fn encode(frame: &CanFrame) -> [u8; FRAME_BYTES] {
    let mut bytes = [0; FRAME_BYTES];
    bytes[..4].copy_from_slice(&frame.word().to_ne_bytes());
    bytes[4] = frame.dlc() as u8;
    bytes[8..8 + frame.data().len()].copy_from_slice(frame.data());
    bytes
}

/// The frame that a program sent; `None` for an error message, or one that is no frame.
pub(crate) fn decode(bytes: &[u8; FRAME_BYTES]) -> Option<CanFrame> {
    let word = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    if word & ERROR_FLAG != 0 {
        return None;
    }
    CanFrame::of_word(word, usize::from(bytes[4]), &bytes[8..])
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
