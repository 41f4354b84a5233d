//! Settings of a serial port, and the duration of a byte.

use crate::time::Span;
use serde::{Deserialize, Serialize};

crate::words! {
    /// Parity of a serial port.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Parity {
        /// No parity bit.
        #[default]
        None = "none",
        /// An even number of ones.
        Even = "even",
        /// An odd number of ones.
        Odd = "odd",
    }
}

/// Settings of a serial port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SerialSettings {
    /// Bits per second on the line.
    pub baud: u32,
    /// Data bits, 5 to 8.
    pub data_bits: u8,
    /// Parity bit.
    pub parity: Parity,
    /// Stop bits, 1 or 2.
    pub stop_bits: u8,
}

impl SerialSettings {
    /// Eight data bits, no parity, one stop bit.
    pub const fn new_8n1(baud: u32) -> Self {
        Self { baud, data_bits: 8, parity: Parity::None, stop_bits: 1 }
    }

    /// Bits on the line for one byte, the start bit included.
    pub const fn bits_per_byte(self) -> u32 {
        let parity = match self.parity {
            Parity::None => 0,
            Parity::Even | Parity::Odd => 1,
        };
        1 + self.data_bits as u32 + parity + self.stop_bits as u32
    }

    /// Time on the line for `bytes` bytes without a gap. At a baud rate of zero it is infinite.
    pub fn time_for(self, bytes: usize) -> Span {
        let bits = i64::from(self.bits_per_byte()).saturating_mul(bytes as i64);
        bits.saturating_mul(1_000_000_000)
            .checked_div(i64::from(self.baud))
            .map_or(Span::MAX, Span::from_nanos)
    }
}

#[cfg(test)]
mod tests {
    use super::{Parity, SerialSettings};
    use crate::time::Span;

    #[test]
    fn a_navigator_frame_fills_five_sixths_of_its_period() {
        // devices.md: 100 frames of 8 bytes are 8,000 bit/s of 9,600.
        assert_eq!(SerialSettings::new_8n1(9_600).time_for(8 * 6), Span::from_millis(50));
    }

    #[test]
    fn parity_and_stop_bits_cost_time() {
        let slow = SerialSettings { baud: 1_000, data_bits: 7, parity: Parity::Even, stop_bits: 2 };
        assert_eq!(slow.time_for(1), Span::from_millis(11));
        assert_eq!(SerialSettings::new_8n1(0).time_for(1), Span::MAX);
    }
}
