//! `SYSTEMTIME` of Windows: year, month, weekday, day, hour, minute, second, millisecond.

use chrono::{DateTime, Datelike as _, NaiveDate, Timelike as _};

pub(super) const BYTES: usize = 16;

/// Nanoseconds since 1970; `None` if it is not a date, such as the zeros of a file without one.
pub(super) fn parse(bytes: &[u8; BYTES]) -> Option<i64> {
    let (words, _) = bytes.as_chunks::<2>();
    let word = |index: usize| u32::from(u16::from_le_bytes(words[index]));
    NaiveDate::from_ymd_opt(word(0) as i32, word(1), word(3))?
        .and_hms_milli_opt(word(4), word(5), word(6), word(7))?
        .and_utc()
        .timestamp_nanos_opt()
}

/// The date of a time in nanoseconds since 1970, to the millisecond.
pub(super) fn format(nanos: i64) -> [u8; BYTES] {
    let date = DateTime::from_timestamp_nanos(nanos);
    let words = [
        date.year() as u32,
        date.month(),
        date.weekday().num_days_from_sunday(),
        date.day(),
        date.hour(),
        date.minute(),
        date.second(),
        date.timestamp_subsec_millis(),
    ];
    let mut bytes = [0; BYTES];
    for (place, word) in bytes.chunks_mut(2).zip(words) {
        // Each of them is less than 10,000.
        place.copy_from_slice(&(word as u16).to_le_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::{format, parse};

    #[test]
    fn dates_come_back_to_the_millisecond() {
        let saturday = 1_506_783_973_191_000_000;
        let bytes = [0xe1, 7, 9, 0, 6, 0, 30, 0, 15, 0, 6, 0, 13, 0, 191, 0];
        assert_eq!(format(saturday + 999_999), bytes);
        assert_eq!(parse(&bytes), Some(saturday));
        assert_eq!(parse(&format(0)), Some(0));
        assert_eq!(parse(&[0; 16]), None);
        assert_eq!(parse(&[0xff; 16]), None);
    }
}
