//! Bits per second of a bus.

use super::BIT_RATE;
use crate::time::Span;

/// Bits per second of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitRates {
    /// Rate of the arbitration phase and of classic frames.
    pub nominal: u32,
    /// Rate of the data phase of a CAN FD frame with a rate switch; `None` on a classic bus, which has no such frames.
    pub data: Option<u32>,
}

impl BitRates {
    /// A classic bus of the [usual rate](BIT_RATE).
    pub const USUAL: Self = Self { nominal: BIT_RATE, data: None };

    /// Duration of a bit, in whole nanoseconds.
    pub const fn bit(self) -> Span {
        bit_time(self.nominal)
    }

    /// Duration of a bit in the data phase of a frame with a rate switch.
    pub const fn data_bit(self) -> Span {
        match self.data {
            Some(rate) => bit_time(rate),
            None => self.bit(),
        }
    }
}

impl Default for BitRates {
    fn default() -> Self {
        Self::USUAL
    }
}

const fn bit_time(bits_per_s: u32) -> Span {
    let rate = if bits_per_s == 0 { 1 } else { bits_per_s };
    Span::from_nanos(1_000_000_000 / rate as i64)
}
