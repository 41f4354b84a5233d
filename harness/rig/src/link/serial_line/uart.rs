//! How a UART reads bits at the wrong time: 8 data bits, no parity, 1 stop bit.

use wire::packet::Packet;

/// Bits of a byte on the line: start, eight data bits with the lowest first, stop.
const BITS_PER_BYTE: usize = 10;
const DATA_BITS: usize = 8;

/// Reads what `sent` puts on an idle line, from bit `from` on. `rate` is the number of bits that the sender sends in
/// one bit time of the receiver. The receiver waits for an edge to 0, samples each bit once, in its middle by its own
/// clock, and drops a byte whose stop bit is 0.
pub(super) fn read(sent: &[u8], rate: f64, from: usize) -> Packet {
    let bits = sent.len() * BITS_PER_BYTE;
    let level = |bit: usize| -> bool {
        let byte = sent.get(bit / BITS_PER_BYTE).copied().unwrap_or(0xff);
        match bit % BITS_PER_BYTE {
            // After the last byte the line is idle, which is 1.
            0 => bit >= bits,
            place @ 1..=DATA_BITS => byte >> (place - 1) & 1 == 1,
            _ => true,
        }
    };
    let sample =
        |start: usize, place: usize| level((start as f64 + (place as f64 + 0.5) * rate) as usize);
    let mut read = Packet::new();
    let mut bit = from;
    while bit < bits {
        let edge = !level(bit) && (bit == from || level(bit - 1));
        if !edge {
            bit += 1;
            continue;
        }
        let byte = (1..=DATA_BITS)
            .fold(0, |byte, place| byte | u8::from(sample(bit, place)) << (place - 1));
        if sample(bit, DATA_BITS + 1) {
            // At most as many as were sent: a byte takes nine and a half bits.
            read.push(byte);
        }
        // The receiver looks for the next edge from the middle of the stop bit on.
        bit = ((bit as f64 + (DATA_BITS as f64 + 1.5) * rate) as usize).max(bit + 1);
    }
    read
}

#[cfg(test)]
mod tests {
    use super::read;
    use proptest::prelude::*;

    proptest! {
        /// The middle of the stop bit, 9.5 bits on, moves by half a bit at 5.3 %.
        #[test]
        fn drift_within_five_per_cent_does_no_harm(
            bytes in prop::collection::vec(any::<u8>(), 0..=64), rate in 0.951f64..1.052,
        ) {
            let heard = read(&bytes, rate, 0);
            prop_assert_eq!(heard.as_slice(), bytes.as_slice());
        }

        #[test]
        fn nothing_panics_and_no_byte_is_added(
            bytes in prop::collection::vec(any::<u8>(), 0..=64), rate in 0.8f64..1.2, from in 0usize..11,
        ) {
            prop_assert!(read(&bytes, rate, from).len() <= bytes.len() * 5 / 4 + 1);
        }
    }

    #[test]
    fn a_fast_sender_shifts_the_high_bits_and_loses_bytes() {
        // At 7 % the seventh data bit is read in the eighth, and that in the stop bit.
        assert_eq!(read(&[0x55], 1.07, 0).as_slice(), [0x95]);
        assert_ne!(read(&[0x00, 0x00, 0x00], 1.07, 0).as_slice(), [0, 0, 0]);
    }

    #[test]
    fn a_slip_reads_other_bytes_until_a_gap() {
        let sent = [0xa5, 0x3c, 0x99];
        let slipped: Vec<_> = (1..10).map(|from| read(&sent, 1.0, from)).collect();
        assert!(slipped.iter().all(|heard| heard.as_slice() != sent));
        assert!(slipped.iter().any(|heard| !heard.is_empty()));
    }
}
