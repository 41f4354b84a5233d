//! Converts numbers and bytes from and to text, without intermediate strings.

const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

pub(super) fn digit(byte: u8) -> Option<u8> {
    char::from(byte).to_digit(16).map(|value| value as u8)
}

/// A number in one to eight hexadecimal digits.
pub(super) fn number(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    digits.iter().try_fold(0, |number, byte| Some(number << 4 | u32::from(digit(*byte)?)))
}

pub(super) fn decimal(digits: &[u8]) -> Option<u64> {
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0u64, |number, byte| {
        let value = char::from(*byte).to_digit(10)?;
        number.checked_mul(10)?.checked_add(u64::from(value))
    })
}

/// Parses `seconds.fraction` as nanoseconds; nine digits of the fraction count.
pub(super) fn seconds(text: &[u8]) -> Option<i64> {
    text.contains(&b'.').then(|| scaled(text, 1_000_000_000)).flatten()
}

/// Parses a number with or without a fraction, in units of `unit` nanoseconds, as nanoseconds. Rounds down, and ignores
/// digits of the fraction beyond 18.
pub(super) fn scaled(text: &[u8], unit: u64) -> Option<i64> {
    let point = text.iter().position(|byte| *byte == b'.').unwrap_or(text.len());
    let whole = decimal(&text[..point])?.checked_mul(unit)?;
    let part = match text.get(point + 1..) {
        None => 0,
        Some(digits) if digits.iter().all(u8::is_ascii_digit) => {
            let digits = &digits[..digits.len().min(18)];
            let fraction = u128::from(decimal(digits)?);
            // Less than the unit.
            (fraction * u128::from(unit) / 10u128.pow(digits.len() as u32)) as u64
        }
        Some(_) => return None,
    };
    i64::try_from(whole.checked_add(part)?).ok()
}

/// Appends two digits for each byte.
pub(super) fn push_bytes(text: &mut Vec<u8>, bytes: &[u8]) {
    for byte in bytes {
        text.push(DIGITS[usize::from(byte >> 4)]);
        text.push(DIGITS[usize::from(byte & 0xf)]);
    }
}

/// Appends each byte with a blank before it.
pub(super) fn push_spaced(text: &mut Vec<u8>, bytes: &[u8]) {
    for byte in bytes {
        text.push(b' ');
        push_bytes(text, &[*byte]);
    }
}

pub(super) fn push_number(text: &mut Vec<u8>, number: u32, digits: u32) {
    for index in (0..digits).rev() {
        text.push(DIGITS[(number >> (4 * index) & 0xf) as usize]);
    }
}

pub(super) fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    text.split_at(end)
}

#[cfg(test)]
mod tests {
    use super::{decimal, number, push_bytes, push_number, scaled, seconds, word};
    use proptest::prelude::*;

    #[test]
    fn numbers_and_what_is_none() {
        assert_eq!(number(b"7fF"), Some(0x7ff));
        assert_eq!(number(b"FFFFFFFF"), Some(u32::MAX));
        for text in [&b""[..], b"123456789", b"12g", b"-1", b" 1"] {
            assert_eq!(number(text), None);
        }
        assert_eq!(decimal(b"18446744073709551615"), Some(u64::MAX));
        for text in [&b""[..], b"18446744073709551616", b"1a", b"+1"] {
            assert_eq!(decimal(text), None);
        }
    }

    #[test]
    fn seconds_to_the_nanosecond() {
        assert_eq!(seconds(b"1436509052.249713"), Some(1_436_509_052_249_713_000));
        assert_eq!(seconds(b"0.000000001"), Some(1));
        assert_eq!(seconds(b"1.0000000019"), Some(1_000_000_001));
        assert_eq!(seconds(b"9223372036.854775807"), Some(i64::MAX));
        for text in [&b"9223372036.854775808"[..], b"1", b"1.", b".1", b"1.x", b"-1.0", b""] {
            assert_eq!(seconds(text), None, "{}", String::from_utf8_lossy(text));
        }
    }

    #[test]
    fn a_number_in_a_unit_of_its_own() {
        assert_eq!(scaled(b"1841", 1_000_000), Some(1_841_000_000));
        assert_eq!(scaled(b"17535.4", 1_000_000), Some(17_535_400_000));
        assert_eq!(scaled(b"0.0000019", 1_000_000), Some(1));
        assert_eq!(scaled(b"1.0000000000000000009", 1), Some(1));
        for text in [&b""[..], b".5", b"1.", b"1.5.2", b"-1", b"99999999999999"] {
            assert_eq!(scaled(text, 1_000_000_000), None, "{}", String::from_utf8_lossy(text));
        }
    }

    #[test]
    fn words_are_apart_by_any_white_space() {
        assert_eq!(word(b" \t one  two\r"), (&b"one"[..], &b"  two\r"[..]));
        assert_eq!(word(b" \r"), (&b""[..], &b""[..]));
    }

    proptest! {
        #[test]
        fn what_is_pushed_is_read(value: u32, bytes in prop::collection::vec(any::<u8>(), 0..9)) {
            let mut text = Vec::new();
            push_number(&mut text, value, 8);
            prop_assert_eq!(number(&text), Some(value));
            text.clear();
            push_bytes(&mut text, &bytes);
            prop_assert_eq!(text.len(), 2 * bytes.len());
            for (pair, byte) in text.chunks(2).zip(&bytes) {
                prop_assert_eq!(number(pair), Some(u32::from(*byte)));
            }
        }
    }
}
