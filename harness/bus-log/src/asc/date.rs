//! Dates in the head of an ASC file: `Sat Sep 30 15:06:13.191 2017`, on some machines with `am` or `pm` before the
//! year, on others with German months.

use chrono::{DateTime, NaiveDateTime};

/// chrono formats of the known variants, without the weekday.
const FORMS: [&str; 2] = ["%b %d %I:%M:%S%.f %p %Y", "%b %d %H:%M:%S%.f %Y"];

const GERMAN: [(&str, &str); 4] = [("Mär", "Mar"), ("Mai", "May"), ("Okt", "Oct"), ("Dez", "Dec")];

/// Parses a date with its weekday as nanoseconds since 1970; `None` if it is not understood.
pub(super) fn parse(text: &str) -> Option<i64> {
    let (_weekday, mut date) = text.trim().split_once(' ').map(|(w, d)| (w, d.to_owned()))?;
    for (german, english) in GERMAN {
        date = date.replace(german, english);
    }
    FORMS
        .iter()
        .find_map(|form| NaiveDateTime::parse_from_str(date.trim(), form).ok())
        .and_then(|date| date.and_utc().timestamp_nanos_opt())
}

/// Formats a time in nanoseconds since 1970, to the millisecond.
pub(super) fn format(nanos: i64) -> String {
    DateTime::from_timestamp_nanos(nanos).format("%a %b %d %H:%M:%S%.3f %Y").to_string()
}

#[cfg(test)]
mod tests {
    use super::{format, parse};

    #[test]
    fn dates_of_several_tools() {
        let noon_ish = 1_506_783_973_191_000_000;
        assert_eq!(format(noon_ish), "Sat Sep 30 15:06:13.191 2017");
        assert_eq!(parse("Sat Sep 30 15:06:13.191 2017"), Some(noon_ish));
        assert_eq!(parse("Sam Sep 30 03:06:13.191 pm 2017"), Some(noon_ish));
        assert_eq!(parse("Sat Sep 30 15:06:13 2017"), Some(1_506_783_973_000_000_000));
        assert_eq!(parse("Mit Okt 4 08:00:00 2017"), parse("Wed Oct 04 08:00:00.000 2017"));
        for text in ["", "today", "Sat Foo 30 15:06:13 2017", "Sat Sep 31 15:06:13 2017"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
