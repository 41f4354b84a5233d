//! CAN frames on the link: `struct canfd_frame` of `linux/can.h`, also for classic frames.

use wire::can::{CanFrame, FD_BYTES_MAX, FD_FLAG, FdFlags, fd_length};
use wire::can_error::ERROR_FLAG;

pub(crate) const FRAME_BYTES: usize = 8 + FD_BYTES_MAX;

pub(crate) fn encode(frame: &CanFrame) -> [u8; FRAME_BYTES] {
    let mut bytes = [0; FRAME_BYTES];
    bytes[..4].copy_from_slice(&frame.word().to_ne_bytes());
    bytes[4] = frame.length() as u8;
    bytes[5] = frame.fd_flags().map_or(0, |flags| flags.bits() | FD_FLAG);
    bytes[8..8 + frame.data().len()].copy_from_slice(frame.data());
    bytes
}

/// An error frame.
pub(crate) fn error(id: u32, data: [u8; 8]) -> [u8; FRAME_BYTES] {
    let mut bytes = [0; FRAME_BYTES];
    bytes[..4].copy_from_slice(&(id | ERROR_FLAG).to_ne_bytes());
    bytes[4] = data.len() as u8;
    bytes[8..16].copy_from_slice(&data);
    bytes
}

/// Decodes a frame of a program; `None` for an error message or an invalid frame.
pub(crate) fn decode(bytes: &[u8; FRAME_BYTES]) -> Option<CanFrame> {
    let word = u32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    if word & ERROR_FLAG != 0 {
        return None;
    }
    let length = usize::from(bytes[4]);
    match bytes[5] {
        flags if flags & FD_FLAG == 0 => CanFrame::of_word(word, None, length, &bytes[8..]),
        // An invalid length is padded to the next valid one, as in a controller.
        flags => CanFrame::of_word(
            word,
            Some(FdFlags::from_bits(flags)),
            fd_length(length)?,
            &bytes[8..],
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::{decode, encode};
    use embedded_can::Frame as _;
    use wire::can::{CanFrame, ExtendedId, FdFlags, StandardId};

    #[test]
    fn frames_cross_the_link_and_errors_do_not() {
        let standard = CanFrame::new(StandardId::new(0x123).unwrap(), &[1, 2, 3]).unwrap();
        let extended = CanFrame::new(ExtendedId::new(0x1234_5678).unwrap(), &[]).unwrap();
        let remote = CanFrame::new_remote(StandardId::MAX, 4).unwrap();
        let flags = FdFlags { bit_rate_switch: true, error_state: false };
        let fd = CanFrame::fd(StandardId::MAX, flags, &[7; 12]).unwrap();
        for frame in [standard, extended, remote, fd] {
            assert_eq!(decode(&encode(&frame)), Some(frame));
        }
        let mut error = encode(&standard);
        error[3] |= 0x20;
        assert_eq!(decode(&error), None);
        let mut uneven = encode(&fd);
        uneven[4] = 11;
        assert_eq!(decode(&uneven), Some(fd));
        let mut long = encode(&standard);
        long[4] = 9;
        assert_eq!(decode(&long), None);
    }
}
