//! The 8-byte frame that the Navigator and the E-Core 2000 share.
//!
//! The top bit is set on the first byte and clear on the other seven. The remaining 56 bits, first
//! byte first, are seven data bytes; all seven sum to zero modulo 256, so the first of them is the
//! two's-complement negative of the sum of the other six (the payload).
//!
//! Source: two public decoders of the KVH E-Core 2000 (`gyroread.c`, University of California, 2002;
//! `gyroComponent.cpp`, Heudiasyc, 2006). The former masks the low bits of its second data byte with `0x06` before a
//! shift by five; the pattern of the neighbouring lines shows that `0x60` is meant.
//!
//! Every change of a single byte is detected. A changed top bit breaks the frame. The seven other bits lie in two
//! adjacent data bytes, in the low m bits of one and above the low m + 1 bits of the other, and no two such changes
//! sum to zero modulo 256.

use super::tally::Tally;

pub(super) const FRAME_BYTES: usize = 8;

/// The first byte of a good frame always starts a new one, whatever precedes it, so that garbage never costs a good
/// frame.
pub(super) const RESYNC_BYTES_MAX: usize = FRAME_BYTES;

/// Set on the first byte of a frame only.
const START: u8 = 0x80;
const START_BITS: u64 = 0x8080_8080_8080_8080;
const START_PATTERN: u64 = 0x8000_0000_0000_0000;
const PAYLOAD_BITS: u32 = 48;

/// Six payload bytes, first byte most significant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Payload(u64);

impl Payload {
    #[inline]
    pub(super) fn from_bytes([a, b, c, d, e, f]: [u8; 6]) -> Self {
        Self(u64::from_be_bytes([0, 0, a, b, c, d, e, f]))
    }

    #[inline]
    pub(super) fn to_bytes(self) -> [u8; 6] {
        let [_, _, a, b, c, d, e, f] = self.0.to_be_bytes();
        [a, b, c, d, e, f]
    }
}

/// The frame that carries `payload`.
#[inline]
pub(super) fn encode(payload: Payload) -> [u8; FRAME_BYTES] {
    let checksum = byte_sum(payload.0).wrapping_neg();
    let frame = START_PATTERN | spread(payload.0 | u64::from(checksum) << PAYLOAD_BITS);
    frame.to_be_bytes()
}

/// Finds frames in a stream and delivers the payload of each with a correct checksum.
#[derive(Debug, Clone)]
pub(super) struct Deframer {
    tally: Tally,
    /// The bytes of an incomplete frame, the newest in the low bits.
    pending: u64,
    pending_bytes: usize,
}

impl Deframer {
    pub(super) const fn new() -> Self {
        Self { tally: Tally::new(), pending: 0, pending_bytes: 0 }
    }

    pub(super) const fn tally(&self) -> &Tally {
        &self.tally
    }

    pub(super) const fn bytes_pending(&self) -> usize {
        self.pending_bytes
    }

    #[inline]
    pub(super) fn feed(&mut self, mut bytes: &[u8], deliver: &mut impl FnMut(Payload)) {
        loop {
            if self.pending_bytes == 0 {
                // The usual case: whole frames, evaluated in place.
                while let Some((frame, rest)) = bytes.split_first_chunk::<FRAME_BYTES>() {
                    let frame = u64::from_be_bytes(*frame);
                    if frame & START_BITS != START_PATTERN {
                        break;
                    }
                    bytes = rest;
                    self.judge(frame, deliver);
                }
            }
            let Some((&byte, rest)) = bytes.split_first() else {
                return;
            };
            bytes = rest;
            self.push(byte, deliver);
        }
    }

    fn push(&mut self, byte: u8, deliver: &mut impl FnMut(Payload)) {
        if byte & START != 0 {
            self.discard(self.pending_bytes);
            self.pending = u64::from(byte);
            self.pending_bytes = 1;
        } else if self.pending_bytes == 0 {
            self.discard(1);
        } else {
            self.pending = self.pending << 8 | u64::from(byte);
            self.pending_bytes += 1;
            if self.pending_bytes == FRAME_BYTES {
                self.pending_bytes = 0;
                self.judge(self.pending, deliver);
            }
        }
    }

    /// Evaluates a frame with correct start bits.
    #[inline]
    fn judge(&mut self, frame: u64, deliver: &mut impl FnMut(Payload)) {
        let data = gather(frame);
        if byte_sum(data) == 0 {
            self.tally.good_frame();
            deliver(Payload(data & ((1 << PAYLOAD_BITS) - 1)));
        } else {
            self.tally.checksum_error();
            self.discard(FRAME_BYTES);
        }
    }

    fn discard(&mut self, bytes: usize) {
        if bytes > 0 {
            self.tally.discard(bytes);
            self.tally.lose_lock();
        }
    }
}

/// Gathers the low seven bits of eight bytes into 56 bits.
#[inline]
const fn gather(frame: u64) -> u64 {
    let x = (frame & 0x007f_007f_007f_007f) | ((frame & 0x7f00_7f00_7f00_7f00) >> 1);
    let x = (x & 0x0000_3fff_0000_3fff) | ((x & 0x3fff_0000_3fff_0000) >> 2);
    (x & 0x0000_0000_0fff_ffff) | ((x & 0x0fff_ffff_0000_0000) >> 4)
}

/// Spreads 56 bits over the low seven bits of eight bytes.
#[inline]
const fn spread(data: u64) -> u64 {
    let x = (data & 0x0000_0000_0fff_ffff) | ((data << 4) & 0x0fff_ffff_0000_0000);
    let x = (x & 0x0000_3fff_0000_3fff) | ((x << 2) & 0x3fff_0000_3fff_0000);
    (x & 0x007f_007f_007f_007f) | ((x << 1) & 0x7f00_7f00_7f00_7f00)
}

/// The sum of the eight bytes of `word`, modulo 256.
#[inline]
const fn byte_sum(word: u64) -> u8 {
    const EVEN_BYTES: u64 = 0x00ff_00ff_00ff_00ff;
    // Four sums of two bytes, then all four of them in the top 16 bits; no sum carries over.
    let pairs = (word & EVEN_BYTES) + ((word >> 8) & EVEN_BYTES);
    (pairs.wrapping_mul(0x0001_0001_0001_0001) >> 48) as u8
}

/// Declares the public `Decoder` of a format in these frames, whose `decode` turns a payload into a sample.
macro_rules! decoder {
    () => {
        /// Bytes to samples.
        #[derive(Debug, Clone)]
        pub struct Decoder {
            deframer: kvh_frame::Deframer,
        }

        impl Decoder {
            /// A decoder without input. The stream carries rates only; the mode is ignored.
            pub const fn new(_: super::OutputMode) -> Self {
                Self { deframer: kvh_frame::Deframer::new() }
            }

            /// Takes bytes in pieces of any length and passes each completed sample to `deliver`.
            #[inline]
            pub fn feed(&mut self, bytes: &[u8], deliver: &mut impl FnMut(GyroSample)) {
                self.deframer.feed(bytes, &mut |payload| deliver(decode(payload)));
            }

            /// The counters so far.
            pub const fn counters(&self) -> super::Counters {
                self.deframer.tally().counters()
            }

            /// Bytes of an incomplete frame.
            pub const fn bytes_pending(&self) -> usize {
                self.deframer.bytes_pending()
            }
        }
    };
}

pub(super) use decoder;

#[cfg(test)]
mod tests {
    use super::{Deframer, FRAME_BYTES, Payload, byte_sum, encode, gather, spread};
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The seven data bytes, one shift each, as in the public decoders.
    fn data_bytes(frame: [u8; 8]) -> [u8; 7] {
        core::array::from_fn(|i| {
            let (left, right) = (u16::from(frame[i]) & 0x7f, u16::from(frame[i + 1]) & 0x7f);
            ((left << 7 | right) >> (6 - i)) as u8
        })
    }

    fn payloads(bytes: &[u8]) -> Vec<[u8; 6]> {
        let mut found = Vec::new();
        Deframer::new().feed(bytes, &mut |payload| found.push(payload.to_bytes()));
        found
    }

    proptest! {
        #[test]
        fn the_data_bytes_are_where_the_public_decoders_look(payload: [u8; 6]) {
            let packet = encode(Payload::from_bytes(payload));
            let frame: [u8; 8] = packet.as_slice().try_into().unwrap();
            prop_assert!(frame[0] >= 0x80 && frame[1..].iter().all(|&byte| byte < 0x80));
            let data = data_bytes(frame);
            prop_assert_eq!(&data[1..], &payload);
            let sum = payload.iter().fold(0u8, |sum, &byte| sum.wrapping_add(byte));
            prop_assert_eq!(data[0], sum.wrapping_neg());
        }

        #[test]
        fn gathering_undoes_spreading(data in 0u64..1 << 56) {
            prop_assert_eq!(gather(spread(data)), data);
        }

        #[test]
        fn bytes_sum_modulo_256(word: u64) {
            let sum = word.to_be_bytes().iter().fold(0u8, |sum, &byte| sum.wrapping_add(byte));
            prop_assert_eq!(byte_sum(word), sum);
        }

        #[test]
        fn a_changed_byte_costs_its_frame_and_no_other(
            sent in prop::collection::vec(any::<[u8; 6]>(), 1..6),
            at: prop::sample::Index,
            change in 1u8..,
        ) {
            let mut bytes: Vec<u8> = sent
                .iter()
                .flat_map(|&payload| encode(Payload::from_bytes(payload)).as_slice().to_vec())
                .collect();
            let at = at.index(bytes.len());
            bytes[at] ^= change;
            let mut expected = sent;
            expected.remove(at / FRAME_BYTES);
            prop_assert_eq!(payloads(&bytes), expected);
        }
    }

    #[test]
    fn every_change_of_one_byte_is_caught() {
        let payload = [0x09, 0xc4, 0x00, 0x07, 0x26, 0x66];
        let packet = encode(Payload::from_bytes(payload));
        for at in 0..FRAME_BYTES {
            for change in 1..=u8::MAX {
                let mut bytes = packet.as_slice().to_vec();
                bytes[at] ^= change;
                assert!(payloads(&bytes).is_empty(), "byte {at} changed by {change:#04x}");
            }
        }
        assert_eq!(payloads(packet.as_slice()), [payload]);
    }
}
