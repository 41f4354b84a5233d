//! The checksum at the end of a packet on a serial line.

use crate::file::ByteOrder;
use crate::protection::Checksum;

/// A checksum at the end of a packet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trailer {
    pub(crate) checksum: Checksum,
    pub(crate) order: ByteOrder,
    /// The first byte that it covers; the last is the one before the checksum.
    pub(crate) from: usize,
}

impl Trailer {
    /// Writes the checksum over the last bytes of `packet`.
    pub(crate) fn seal(self, packet: &mut [u8]) {
        let (sum, at) = self.sum(packet);
        for (byte, new) in packet.iter_mut().skip(at).zip(sum) {
            *byte = new;
        }
    }

    /// True if the last bytes of `packet` are the checksum of the preceding ones.
    pub(crate) fn holds(self, packet: &[u8]) -> bool {
        let (sum, at) = self.sum(packet);
        packet.get(at..).is_some_and(|found| found == &sum[..self.checksum.length()])
    }

    /// The checksum in transmission order, and its position.
    fn sum(self, packet: &[u8]) -> ([u8; 4], usize) {
        let length = self.checksum.length();
        let at = packet.len().saturating_sub(length);
        let value = self.checksum.value(packet.get(self.from..at).unwrap_or_default());
        let mut bytes = value.to_le_bytes();
        if self.order == ByteOrder::Big {
            bytes[..length].reverse();
        }
        (bytes, at)
    }
}

#[cfg(test)]
mod tests {
    use super::{ByteOrder, Checksum, Trailer};

    #[test]
    fn the_sum_of_the_specification_of_modbus() {
        // Modbus over serial line V1.02, appendix B: 02 07 has the CRC 0x1241, low byte first (41 12).
        let modbus = Trailer {
            checksum: Checksum::named("crc16-modbus").unwrap(),
            order: ByteOrder::Little,
            from: 0,
        };
        let mut packet = [0x02, 0x07, 0, 0];
        modbus.seal(&mut packet);
        assert_eq!(packet, [0x02, 0x07, 0x41, 0x12]);
        assert!(modbus.holds(&packet));
        assert!(!Trailer { order: ByteOrder::Big, ..modbus }.holds(&packet));
        assert!(!Trailer { from: 1, ..modbus }.holds(&packet));
    }

    #[test]
    fn a_packet_that_is_shorter_than_its_checksum_is_not_sound() {
        let trailer = Trailer {
            checksum: Checksum::named("crc32-iso-hdlc").unwrap(),
            order: ByteOrder::Big,
            from: 2,
        };
        for length in 0..4 {
            assert!(!trailer.holds(&[0; 4][..length]));
        }
    }
}
