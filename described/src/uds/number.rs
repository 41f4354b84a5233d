//! Numbers in requests and responses.

use crate::file::FieldType;
use crate::layout::{Coding, Scale};

/// Type of a number of whole bytes, most significant byte first.
pub type NumberType = FieldType;

/// A number of whole bytes, most significant byte first: value = scale * number + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    coding: Coding,
    bits: u32,
    scale: Scale,
}

impl Number {
    /// `None` if the scale is zero or not finite, or the offset is not finite.
    pub fn new(kind: NumberType, scale: f64, offset: f64) -> Option<Self> {
        let (coding, bits) = Coding::of(kind);
        Scale::new(scale, offset).map(|scale| Self { coding, bits: bits as u32, scale })
    }

    /// Length in bytes.
    pub const fn bytes(&self) -> usize {
        self.bits as usize / 8
    }

    /// The value in the first bytes; `None` if there are too few.
    pub fn value(&self, data: &[u8]) -> Option<f64> {
        let data = data.get(..self.bytes())?;
        let raw = data.iter().fold(0, |raw: u64, byte| raw << 8 | u64::from(*byte));
        Some(self.scale.physical(self.coding.number(raw, self.bits)))
    }

    /// Appends the value, clipped to what the bytes can represent.
    pub(crate) fn put(&self, value: f64, data: &mut Vec<u8>) {
        let (least, greatest) = self.coding.limits(self.bits);
        let (least, greatest) = self.scale.range(least, greatest);
        let value = if value.is_nan() { 0.0 } else { value }.clamp(least, greatest);
        let raw = self.coding.raw(value, self.bits, self.scale, (least, greatest));
        let bytes = raw.unwrap_or_default().to_be_bytes();
        data.extend_from_slice(&bytes[bytes.len() - self.bytes()..]);
    }
}
