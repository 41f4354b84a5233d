//! A value in a record.

use super::super::error::Defect;
use super::blocks::Block;

/// Place and type of a channel's value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    byte: usize,
    bit: u32,
    bits: u32,
    kind: Number,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Number {
    Unsigned { big: bool },
    Signed { big: bool },
    Float { big: bool },
    Bytes,
}

impl Field {
    /// The field of a channel (`CN` block).
    pub(super) fn of(channel: &Block) -> Result<Self, Defect> {
        let (byte, bit, bits) = (channel.u32(4), u32::from(channel.u8(3)), channel.u32(8));
        let kind = match channel.u8(2) {
            kind @ (0 | 1) => Number::Unsigned { big: kind == 1 },
            kind @ (2 | 3) => Number::Signed { big: kind == 3 },
            kind @ (4 | 5) => Number::Float { big: kind == 5 },
            _ => Number::Bytes,
        };
        let field = Self { byte: byte as usize, bit, bits, kind };
        let fits = match kind {
            Number::Unsigned { .. } | Number::Signed { .. } => bit < 8 && (1..=64).contains(&bits),
            Number::Float { .. } => bit == 0 && matches!(bits, 16 | 32 | 64),
            Number::Bytes => bit == 0 && bits.is_multiple_of(8),
        };
        if fits {
            return Ok(field);
        }
        let found = format!("{bits} bits from bit {bit}");
        Err(Defect::new("a value of at most 64 bits, or whole bytes", found))
    }

    /// The field of a variable-length channel: a record has the offset of its data, a 64-bit number for any type.
    pub(super) fn place_of(channel: &Block) -> Self {
        let kind = Number::Unsigned { big: false };
        Self { byte: channel.u32(4) as usize, bit: 0, bits: 64, kind }
    }

    pub(super) const fn end(&self) -> usize {
        self.byte + (self.bit as usize + self.bits as usize).div_ceil(8)
    }

    /// Its bytes in a record, which is as long as [`Self::end`].
    pub(super) fn bytes<'a>(&self, record: &'a [u8]) -> &'a [u8] {
        record.get(self.byte..self.end()).unwrap_or_default()
    }

    /// A number without a fraction; `None` for a floating-point number or bytes.
    pub(super) fn integer(&self, record: &[u8]) -> Option<i128> {
        let bytes = self.bytes(record);
        let raw = |big: bool| {
            let add = |sum: u128, byte: &u8| sum << 8 | u128::from(*byte);
            let all = if big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
            all >> self.bit & ((1 << self.bits) - 1)
        };
        // At most 64 bits.
        match self.kind {
            Number::Unsigned { big } => Some(raw(big) as i128),
            Number::Signed { big } => {
                let raw = raw(big) as i128;
                let is_negative = raw >> (self.bits - 1) & 1 == 1;
                Some(if is_negative { raw - (1 << self.bits) } else { raw })
            }
            Number::Float { .. } | Number::Bytes => None,
        }
    }

    /// An unsigned number of up to 64 bits; zero for anything else.
    pub(super) fn number(&self, record: &[u8]) -> u64 {
        self.integer(record).and_then(|number| u64::try_from(number).ok()).unwrap_or(0)
    }

    pub(super) fn float(&self, record: &[u8]) -> Option<f64> {
        let Number::Float { big } = self.kind else { return None };
        match *self.bytes(record) {
            [a, b] if big => Some(half(u16::from_be_bytes([a, b]))),
            [a, b] => Some(half(u16::from_le_bytes([a, b]))),
            [a, b, c, d] if big => Some(f32::from_be_bytes([a, b, c, d]).into()),
            [a, b, c, d] => Some(f32::from_le_bytes([a, b, c, d]).into()),
            [a, b, c, d, e, f, g, h] if big => Some(f64::from_be_bytes([a, b, c, d, e, f, g, h])),
            [a, b, c, d, e, f, g, h] => Some(f64::from_le_bytes([a, b, c, d, e, f, g, h])),
            _ => None,
        }
    }
}

/// A 16-bit floating-point number (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    let size = match exponent {
        // Subnormal numbers.
        0 => fraction * 2f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        _ => (1.0 + fraction / 1_024.0) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// Time of a group: its master channel and the conversion to seconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    pub(super) field: Field,
    /// `P1` and `P2` of a linear conversion.
    pub(super) offset: f64,
    pub(super) factor: f64,
}

impl Clock {
    /// Nanoseconds since the start of the measurement; `None` for an invalid time.
    pub(super) fn nanos(&self, record: &[u8]) -> Option<i128> {
        let factor = self.factor * 1e9;
        let whole = factor.round();
        // A factor such as 1e-9 is a whole number of nanoseconds, so the conversion is exact.
        let is_whole = whole >= 1.0 && (factor - whole).abs() < 1e-6 && self.offset == 0.0;
        match self.field.integer(record) {
            Some(number) if is_whole && whole < 1e18 => number.checked_mul(whole as i128),
            number => {
                let number = number.map(|number| number as f64).or(self.field.float(record))?;
                let nanos = ((self.offset + self.factor * number) * 1e9).round();
                (nanos.abs() < 1e19).then_some(nanos as i128)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Clock, Field, Number};

    const fn field(byte: usize, bit: u32, bits: u32, kind: Number) -> Field {
        Field { byte, bit, bits, kind }
    }

    #[test]
    fn numbers_wherever_they_are() {
        let record = [0xff, 0b1010_0110, 0x12, 0x34];
        let unsigned = |big| Number::Unsigned { big };
        assert_eq!(field(1, 1, 3, unsigned(false)).integer(&record), Some(0b011));
        assert_eq!(field(2, 0, 16, unsigned(false)).integer(&record), Some(0x3412));
        assert_eq!(field(2, 0, 16, unsigned(true)).integer(&record), Some(0x1234));
        assert_eq!(field(0, 0, 8, Number::Signed { big: false }).integer(&record), Some(-1));
        assert_eq!(field(0, 0, 8, Number::Bytes).integer(&record), None);
        let half = 0.5f64.to_be_bytes();
        assert_eq!(field(0, 0, 64, Number::Float { big: true }).float(&half), Some(0.5));
        let nine = [0b1010_0000, 0, 0, 0, 0, 0, 0, 0, 0b0001_1111];
        let all = Some(0xf800_0000_0000_0005);
        assert_eq!(field(0, 5, 64, unsigned(false)).integer(&nine), all);
    }

    /// IEEE 754: 1.5, the largest, the smallest above zero, minus two.
    #[test]
    fn halves() {
        for (bits, number) in [
            (0x3e00_u16, 1.5),
            (0x7bff, 65_504.0),
            (0x0001, 5.960_464_477_539_063e-8),
            (0xc000, -2.0),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            let float = |big| field(0, 0, 16, Number::Float { big });
            assert_eq!(float(false).float(&bits.to_le_bytes()), Some(number));
            assert_eq!(float(true).float(&bits.to_be_bytes()), Some(number));
        }
        assert!(super::half(0x7e00).is_nan());
    }

    #[test]
    fn whole_nanoseconds_are_kept() {
        let most = i64::MAX.to_le_bytes();
        let field = field(0, 0, 64, Number::Signed { big: false });
        let clock = Clock { field, offset: 0.0, factor: 1e-9 };
        assert_eq!(clock.nanos(&most), Some(i64::MAX.into()));
        let clock = Clock { field, offset: 0.0, factor: 1e-6 };
        assert_eq!(clock.nanos(&7i64.to_le_bytes()), Some(7_000));
        let clock = Clock { field, offset: 1.0, factor: 0.5e-9 };
        assert_eq!(clock.nanos(&6i64.to_le_bytes()), Some(1_000_000_003));
        let field = super::Field { kind: Number::Float { big: false }, ..field };
        let clock = Clock { field, offset: 0.0, factor: 1.0 };
        assert_eq!(clock.nanos(&0.25f64.to_le_bytes()), Some(250_000_000));
        assert_eq!(clock.nanos(&f64::NAN.to_le_bytes()), None);
    }
}
