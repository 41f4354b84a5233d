//! Hexadecimal and decimal numbers of a fixed number of digits.

use crate::packet::Packet;

const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

/// Adds the lowest `digits` hexadecimal digits of `value`, the highest first.
pub(super) fn push_hex(packet: &mut Packet, value: u32, digits: u32) {
    for place in (0..digits).rev() {
        packet.push(DIGITS[(value >> (4 * place) & 0xF) as usize]);
    }
}

/// The value of hexadecimal digits, in either case; `None` for an invalid digit, and for more than eight.
pub(super) fn parse_hex(digits: &[u8]) -> Option<u32> {
    if digits.len() > 8 {
        return None;
    }
    digits.iter().try_fold(0, |value, digit| Some(value << 4 | u32::from(nibble(*digit)?)))
}

/// The value of decimal digits; `None` for an invalid digit, and for more than four.
pub(super) fn parse_decimal(digits: &[u8]) -> Option<u16> {
    if digits.len() > 4 {
        return None;
    }
    digits.iter().try_fold(0, |value, digit| {
        digit.is_ascii_digit().then(|| value * 10 + u16::from(digit - b'0'))
    })
}

/// The value of one hexadecimal digit.
#[inline]
pub(super) fn nibble(digit: u8) -> Option<u8> {
    char::from(digit).to_digit(16).map(|value| value as u8)
}
