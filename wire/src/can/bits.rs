//! Number of bits of a frame on the wire, and their duration (ISO 11898-1:2015).
//!
//! After five equal bits the sender stuffs one of the other value, so the length of a frame depends on its content. In
//! a classic frame stuffing extends to the end of the checksum, which is therefore computed; in a CAN FD frame it
//! extends to the end of the data, and stuff bits after that have fixed places.

use super::{BitRates, CanFrame, Id, Kind};
use crate::time::Span;
use crc::{CRC_15_CAN, Crc, Table};

/// Delimiter of the checksum, acknowledgement and its delimiter, end of frame, intermission.
const CLASSIC_END: u32 = 1 + 2 + 7 + 3;
/// The same bits of a CAN FD frame after the checksum delimiter.
const FD_END: u32 = CLASSIC_END - 1;
const CHECKSUM_BITS: u32 = 15;
/// From ESI to the length.
const FD_CONTROL_BITS: u32 = 5;

impl CanFrame {
    /// Bits on the wire from start of frame to the end of the intermission, stuff bits included.
    pub fn bits(&self) -> u32 {
        self.parts().iter().sum()
    }

    /// Duration of the first `bits` of the frame. A frame with a rate switch has the faster rate from ESI to the
    /// delimiter of the CRC.
    pub fn time_of(&self, bits: u32, rates: BitRates) -> Span {
        let switches = self.fd_flags().is_some_and(|flags| flags.bit_rate_switch);
        if !switches {
            return rates.bit() * i64::from(bits);
        }
        let [head, data, _] = self.parts();
        let fast = bits.saturating_sub(head).min(data);
        rates.bit() * i64::from(bits - fast) + rates.data_bit() * i64::from(fast)
    }

    /// Duration of the frame on the wire.
    pub fn duration(&self, rates: BitRates) -> Span {
        self.time_of(self.bits(), rates)
    }

    /// Numbers of bits before the data phase, in it, and after it.
    fn parts(&self) -> [u32; 3] {
        let Kind::Fd(flags) = self.kind else {
            let (checked, length) = self.checked();
            let checked =
                checked << CHECKSUM_BITS | u128::from(CHECKSUM.checksum(&checked.to_be_bytes()));
            let length = length + CHECKSUM_BITS;
            return [0, 0, length + stuff_bits(checked, length) + CLASSIC_END];
        };
        let mut line = Line::default();
        let (head, length) = match self.id {
            // Start and identifier; RRS, IDE and FDF; reserved.
            Id::Standard(id) => (u64::from(id.as_raw()) << 4 | 0b0010, 16),
            // Start and the first part of the identifier, SRR and IDE, its second part; RRS and FDF; reserved.
            Id::Extended(id) => (extended(id.as_raw()) << 3 | 0b010, 35),
        };
        line.send(head << 1 | u64::from(flags.bit_rate_switch), length + 1);
        let head = length + 1 + line.stuffed;
        // A stuff bit after the last of these already has the data rate.
        line.stuffed = 0;
        let code = embedded_can::Frame::dlc(self) as u64;
        line.send(u64::from(flags.error_state) << 4 | code, FD_CONTROL_BITS);
        self.data().iter().for_each(|byte| line.send_byte(*byte));
        let data = 8 * self.data().len() as u32;
        // Stuff count and checksum with a stuff bit before each four of them; the delimiter.
        let behind = if data <= 128 { 4 + 17 + 6 } else { 4 + 21 + 7 } + 1;
        [head, FD_CONTROL_BITS + data + line.stuffed + behind, FD_END]
    }

    /// The bits that the checksum of a classic frame covers, the last one lowest, and their number.
    fn checked(&self) -> (u128, u32) {
        let control = u64::from(self.is_remote()) << 6 | u64::from(self.length);
        let (head, length) = match self.id {
            Id::Standard(id) => (u64::from(id.as_raw()) << 7 | control, 19),
            Id::Extended(id) => (extended(id.as_raw()) << 7 | control, 39),
        };
        let bits = 8 * self.data().len() as u32;
        let mut eight = [0; 8];
        eight.copy_from_slice(&self.data[..8]);
        let data = u128::from(u64::from_be_bytes(eight)) >> (u64::BITS - bits);
        (u128::from(head) << bits | data, length + bits)
    }
}

/// The identifier with SRR and IDE between its two parts.
fn extended(id: u32) -> u64 {
    let (first, rest) = (u64::from(id >> 18), u64::from(id & 0x3_ffff));
    first << 20 | 0b11 << 18 | rest
}

/// Checksum of the classic frame. It starts at zero, so that zeros before the frame leave it as it is.
static CHECKSUM: Crc<u16, Table<16>> = Crc::<u16, Table<16>>::new(&CRC_15_CAN);

/// Number of stuff bits in the lowest `length` of `bits`, including one after the last.
fn stuff_bits(bits: u128, length: u32) -> u32 {
    let whole = length / u8::BITS;
    let mut line = Line::default();
    line.send((bits >> (whole * u8::BITS)) as u64, length % u8::BITS);
    let bytes = bits.to_be_bytes();
    bytes[bytes.len() - whole as usize..].iter().for_each(|byte| line.send_byte(*byte));
    line.stuffed + u32::from(line.alike == ALIKE_MAX)
}

/// State of bit stuffing on a line.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    /// The last bit; meaningless if `alike` is zero.
    last: bool,
    /// Number of equal bits at the end.
    alike: u32,
    stuffed: u32,
}

/// Number of equal bits before a stuff bit.
const ALIKE_MAX: u32 = 5;
/// Number of states of a line: its last bit and the number of equal bits.
const STATES: usize = 2 * (ALIKE_MAX as usize + 1);

/// For each state and byte: the next state and the number of stuff bits.
static BYTES: [[(u8, u8); 256]; STATES] = bytes();

const fn bytes() -> [[(u8, u8); 256]; STATES] {
    let mut table = [[(0, 0); 256]; STATES];
    let mut state = 0;
    while state < STATES {
        let mut byte = 0;
        while byte < 256 {
            let mut line = Line::in_state(state);
            line.send(byte as u64, u8::BITS);
            table[state][byte] = (line.state() as u8, line.stuffed as u8);
            byte += 1;
        }
        state += 1;
    }
    table
}

impl Line {
    const fn in_state(state: usize) -> Self {
        Self { last: state % 2 == 1, alike: state as u32 / 2, stuffed: 0 }
    }

    const fn state(&self) -> usize {
        2 * self.alike as usize + self.last as usize
    }

    /// Sends the lowest `length` of `bits`, the highest first. A stuff bit is added when the next bit is sent.
    const fn send(&mut self, bits: u64, length: u32) {
        let mut left = length;
        while left > 0 {
            left -= 1;
            if self.alike == ALIKE_MAX {
                (self.last, self.alike) = (!self.last, 1);
                self.stuffed += 1;
            }
            let bit = bits >> left & 1 != 0;
            self.alike = if self.alike > 0 && bit == self.last { self.alike + 1 } else { 1 };
            self.last = bit;
        }
    }

    /// Sends eight bits, with the same result as [`send`](Self::send).
    fn send_byte(&mut self, byte: u8) {
        let (state, stuffed) = BYTES[self.state()][usize::from(byte)];
        let stuffed = self.stuffed + u32::from(stuffed);
        *self = Self { stuffed, ..Self::in_state(state.into()) };
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FdFlags, StandardId, tests::any_frame};
    use super::{BitRates, CHECKSUM, CHECKSUM_BITS, CanFrame, Line, Span};
    use proptest::prelude::*;

    /// Computes the checksum bit by bit, as the standard describes it.
    fn checksum_of(bits: u128, length: u32) -> u16 {
        (0..length).rev().fold(0, |sum, place| {
            let next = bits >> place & 1 != 0;
            let differs = next != (sum & 1 << 14 != 0);
            (sum << 1 & 0x7fff) ^ if differs { 0x4599 } else { 0 }
        })
    }

    #[test]
    fn the_checksum_is_that_of_the_catalogue() {
        let digits = b"123456789".iter().fold(0, |bits, byte| bits << 8 | u128::from(*byte));
        assert_eq!(
            (CHECKSUM.checksum(&digits.to_be_bytes()), checksum_of(digits, 72)),
            (0x059e, 0x059e)
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5_000))]

        #[test]
        fn a_classic_frame_has_the_stuff_bits_of_its_line(frame in any_frame(), bits: u128, few: u128, length in 5u32..=118) {
            if frame.fd_flags().is_none() {
                let (checked, length) = frame.checked();
                let sum = checksum_of(checked, length);
                prop_assert_eq!(sum, CHECKSUM.checksum(&checked.to_be_bytes()));
                let mut line = Line::default();
                for place in (0..length).rev() {
                    line.send((checked >> place) as u64, 1);
                }
                line.send(sum.into(), CHECKSUM_BITS);
                let behind = u32::from(line.alike == 5);
                let plain = length + CHECKSUM_BITS + 13;
                prop_assert_eq!(frame.bits(), plain + line.stuffed + behind);
            }
            // Rare bits make long runs.
            for bits in [bits, bits & few, bits & few & few.rotate_left(7), bits | few, !0, 0] {
                let bits = bits & u128::MAX >> (128 - length);
                let mut line = Line::default();
                (0..length).rev().for_each(|place| line.send((bits >> place) as u64, 1));
                let expected = line.stuffed + u32::from(line.alike == 5);
                prop_assert_eq!(super::stuff_bits(bits, length), expected, "{:#b}, {}", bits, length);
            }
        }
    }

    proptest! {
        #[test]
        fn a_byte_is_its_bits(bytes: [u8; 12], few: [u8; 12]) {
            let (mut by_bits, mut by_bytes) = (Line::default(), Line::default());
            for (byte, few) in bytes.into_iter().zip(few) {
                // Rare bits make long runs.
                for byte in [byte, byte & few & few.rotate_left(3), byte | few] {
                    by_bits.send(byte.into(), u8::BITS);
                    by_bytes.send_byte(byte);
                }
                prop_assert_eq!((by_bits.state(), by_bits.stuffed), (by_bytes.state(), by_bytes.stuffed));
            }
        }
    }

    /// K. Tindell, A. Burns, A. Wellings, "Calculating Controller Area Network (CAN) message response times", 1995: at
    /// most one stuff bit for each four of 34 bits and the data, less one.
    #[test]
    fn frames_reach_the_most_stuff_bits_and_none() {
        let frame =
            |id: u16, data: &[u8]| CanFrame::new(StandardId::new(id).unwrap(), data).unwrap();
        let (mut least, mut most) = (u32::MAX, 0);
        for id in 0..0x800 {
            for byte in [0x0f, 0x3c, 0x87, 0xf0, 0x78, 0x1e, 0x55] {
                let stuffed = frame(id, &[byte; 8]).bits() - 111;
                (least, most) = (least.min(stuffed), most.max(stuffed));
            }
        }
        assert_eq!(least, 0);
        assert!((20..=(34 + 64 - 1) / 4).contains(&most), "{most}");
    }

    #[test]
    fn a_fd_frame_has_none_behind_its_data() {
        let fd = |byte: u8, length: usize| {
            CanFrame::fd(StandardId::new(0x555).unwrap(), FdFlags::default(), &[byte; 64][..length])
                .unwrap()
                .bits()
        };
        // Without data the frame ends in seven zeros: one stuff bit.
        assert_eq!([0, 16, 20].map(|length| fd(0x55, length)), [63, 190, 227]);
        // Each five are followed by a stuff bit except the last: 64 ones, and 384 zeros with one of the length before
        // them.
        let stuffed = |byte: u8, length: usize| fd(byte, length) - fd(0x55, length);
        assert_eq!([stuffed(0xff, 8), stuffed(0, 48)], [12, 76]);
    }

    #[test]
    fn only_a_frame_that_switches_is_faster() {
        let rates = BitRates { nominal: 500_000, data: Some(2_000_000) };
        let fd = |bit_rate_switch| {
            let flags = FdFlags { bit_rate_switch, error_state: false };
            CanFrame::fd(StandardId::new(0x555).unwrap(), flags, &[0x55; 64]).unwrap()
        };
        // 29 bits of arbitration; 5 + 512 + 32 + 1 of data.
        assert_eq!(fd(false).duration(rates), Span::from_micros(2 * 579));
        assert_eq!(fd(true).duration(rates), Span::from_nanos(29 * 2_000 + 550 * 500));
        assert_eq!(fd(true).time_of(17, rates), Span::from_nanos(17 * 2_000));
        assert_eq!(fd(true).time_of(19, rates), Span::from_nanos(17 * 2_000 + 2 * 500));
    }
}
