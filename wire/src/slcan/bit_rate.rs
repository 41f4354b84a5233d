//! Bit rates: the nine of the protocol, and the registers for any other.

use serde::{Deserialize, Serialize};

crate::tabled! {
    /// The bit rates that have a command of their own, `S0` to `S8`.
    #[derive(
        Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
    )]
    pub enum BitRate {
        /// `S0`, 10 kbit/s
        Kbit10 = 10_000,
        /// `S1`, 20 kbit/s
        Kbit20 = 20_000,
        /// `S2`, 50 kbit/s
        Kbit50 = 50_000,
        /// `S3`, 100 kbit/s
        Kbit100 = 100_000,
        /// `S4`, 125 kbit/s
        Kbit125 = 125_000,
        /// `S5`, 250 kbit/s
        Kbit250 = 250_000,
        /// `S6`, 500 kbit/s
        #[default]
        Kbit500 = 500_000,
        /// `S7`, 800 kbit/s
        Kbit800 = 800_000,
        /// `S8`, 1 Mbit/s
        Mbit1 = 1_000_000,
    }
    /// In bits per second.
    pub fn bits_per_second() -> u32
}

impl BitRate {
    /// The digit after the `S`.
    pub const fn digit(self) -> u8 {
        b'0' + self as u8
    }

    /// The bit rate of this digit.
    pub fn from_digit(digit: u8) -> Option<Self> {
        Self::ALL.get(usize::from(digit.checked_sub(b'0')?)).copied()
    }

    /// The bit rate of `bits_per_second`, if there is a command for it.
    pub fn from_bits_per_second(bits_per_second: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|rate| rate.bits_per_second() == bits_per_second)
    }
}

/// The bus timing registers of an SJA1000, as set by `s`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct BitTiming {
    /// Synchronisation jump width (bits 7 and 6) and prescaler (bits 5 to 0).
    pub btr0: u8,
    /// Sampling (bit 7), time segment 2 (bits 6 to 4) and 1 (bits 3 to 0).
    pub btr1: u8,
}

/// The clock of the adapters' SJA1000, in hertz (CANUSB manual: 16 MHz crystal).
const CLOCK_HZ: u32 = 16_000_000;

impl BitTiming {
    /// In bits per second, rounded down, at the adapters' clock of 16 MHz (SJA1000 data sheet, 6.5: a time
    /// quantum is 2 (BRP + 1) clocks, a bit 1 + (TSEG1 + 1) + (TSEG2 + 1) quanta).
    pub const fn bits_per_second(self) -> u32 {
        let prescaler = (self.btr0 & 0x3F) as u32 + 1;
        let segment_1 = (self.btr1 & 0x0F) as u32 + 1;
        let segment_2 = (self.btr1 >> 4 & 0x07) as u32 + 1;
        CLOCK_HZ / (2 * prescaler * (1 + segment_1 + segment_2))
    }
}

#[cfg(test)]
mod tests {
    use super::{BitRate, BitTiming};

    #[test]
    fn digits_and_rates_come_back() {
        for (digit, rate) in (b'0'..).zip(BitRate::ALL) {
            assert_eq!(rate.digit(), digit);
            assert_eq!(BitRate::from_digit(digit), Some(rate));
            assert_eq!(BitRate::from_bits_per_second(rate.bits_per_second()), Some(rate));
        }
        assert_eq!(BitRate::from_digit(b'9'), None);
        assert_eq!(BitRate::from_digit(b'\r'), None);
        assert_eq!(BitRate::from_bits_per_second(83_333), None);
    }

    #[test]
    fn the_usual_registers_give_the_usual_rates() {
        // The usual table for an SJA1000 at 16 MHz.
        for (btr0, btr1, bits_per_second) in [
            (0x00, 0x14, 1_000_000),
            (0x00, 0x1C, 500_000),
            (0x01, 0x1C, 250_000),
            (0x03, 0x1C, 125_000),
            (0x31, 0x1C, 10_000),
        ] {
            assert_eq!(BitTiming { btr0, btr1 }.bits_per_second(), bits_per_second);
        }
    }
}
