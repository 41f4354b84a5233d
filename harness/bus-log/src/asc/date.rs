//! Dates in the head of an ASC file: `Sat Sep 30 15:06:13.191 2017`, on some machines with `am` or `pm` before the
//! year. Vector's tools write weekday and month in the language of the machine, and in its encoding.

use chrono::{DateTime, NaiveDate, NaiveTime};
use std::borrow::Cow;

/// How the names of the months begin in Czech, Dutch, English, French, German, Italian, Polish, Portuguese, Spanish and
/// the languages of Scandinavia.
const MONTHS: [&[&str]; 12] = [
    &["jan", "jän", "gen", "ene", "sty", "led"],
    &["feb", "fév", "fev", "lut", "úno"],
    &["mar", "mär", "maa", "mrt", "mrz", "bře"],
    &["apr", "avr", "abr", "kwi", "dub"],
    &["may", "mai", "mag", "maj", "mei", "kvě"],
    &["jun", "juin", "giu", "cze", "čvn"],
    &["jul", "juil", "lug", "lip", "čvc"],
    &["aug", "aoû", "aou", "ago", "sie", "srp"],
    &["sep", "set", "wrz", "zář"],
    &["oct", "okt", "ott", "out", "paź", "říj"],
    &["nov", "lis"],
    &["dec", "dez", "déc", "dic", "des", "gru", "pro"],
];

/// The text of a date: UTF-8, otherwise Latin-1.
pub(super) fn text(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes.trim_ascii()) {
        Ok(text) => text.into(),
        Err(_) => {
            bytes.trim_ascii().iter().map(|byte| char::from(*byte)).collect::<String>().into()
        }
    }
}

/// Parses a date with its weekday as nanoseconds since 1970; `None` if it is not understood.
pub(super) fn parse(text: &str) -> Option<i64> {
    let (mut time, mut half, mut year, mut day, mut month) = (None, None, None, None, None);
    let mut name = String::new();
    for word in text.split_whitespace() {
        let word = word.trim_end_matches(['.', ',']).to_lowercase();
        let digits = word.bytes().take_while(u8::is_ascii_digit).count();
        match (word.as_str(), digits) {
            (clock, _) if clock.contains(':') => time = Some(word),
            ("am" | "a.m", _) => half = Some(false),
            ("pm" | "p.m", _) => half = Some(true),
            (all, 4) if all.len() == 4 => year = all.parse().ok(),
            (all, 1 | 2) if all.len() == digits => day = all.parse().ok(),
            // `11月`, in whatever encoding.
            (numbered, 1 | 2) if !numbered[digits..].is_ascii() => {
                month = numbered[..digits].parse().ok();
            }
            // The weekday comes before the month: `mar` is a Tuesday or the month of March.
            (_, 0) => name = word,
            _ => return None,
        }
    }
    let begins = |names: &&[&str]| names.iter().any(|begin| name.starts_with(begin));
    let named = || MONTHS.iter().position(begins).map(|place| place as u32 + 1);
    let date = NaiveDate::from_ymd_opt(year?, month.or_else(named)?, day?)?;
    date.and_time(clock(&time?, half)?).and_utc().timestamp_nanos_opt()
}

/// Parses `15:06:13.191`; `half` is the second one of the day if the clock has twelve hours.
fn clock(text: &str, half: Option<bool>) -> Option<NaiveTime> {
    let (hours, rest) = text.split_once(':')?;
    let hours = match (hours.parse().ok()?, half) {
        (12, Some(false)) => 0,
        (hours @ 0..12, Some(true)) => hours + 12,
        (hours, _) => hours,
    };
    let rest = rest.replace(',', ".");
    let (form, rest) = if rest.contains('.') { ("%H:%M:%S%.f", rest) } else { ("%H:%M:%S", rest) };
    NaiveTime::parse_from_str(&format!("{hours:02}:{rest}"), form).ok()
}

/// Formats a time in nanoseconds since 1970, to the millisecond.
pub(super) fn format(nanos: i64) -> String {
    DateTime::from_timestamp_nanos(nanos).format("%a %b %d %H:%M:%S%.3f %Y").to_string()
}

#[cfg(test)]
mod tests {
    use super::{format, parse, text};

    const NOON_ISH: i64 = 1_506_783_973_191_000_000;

    #[test]
    fn dates_of_several_tools() {
        assert_eq!(format(NOON_ISH), "Sat Sep 30 15:06:13.191 2017");
        assert_eq!(parse("Sat Sep 30 15:06:13.191 2017"), Some(NOON_ISH));
        assert_eq!(parse("Sam Sep 30 03:06:13.191 pm 2017"), Some(NOON_ISH));
        assert_eq!(parse("Sat Sep 30 15:06:13.191 pm 2017"), Some(NOON_ISH));
        assert_eq!(parse("Sat Sep 30 12:00:00 am 2017"), parse("Sat Sep 30 00:00:00 2017"));
        assert_eq!(parse("Sat Sep 30 15:06:13 2017"), Some(1_506_783_973_000_000_000));
        assert_eq!(parse("Mit Okt 4 08:00:00 2017"), parse("Wed Oct 04 08:00:00.000 2017"));
        let wrong = [
            "",
            "today",
            "Sat Foo 30 15:06:13 2017",
            "Sat Sep 31 15:06:13 2017",
            "Sat Sep 30 25:06:13 2017",
            "30.09.2017 15:06:13",
        ];
        for text in wrong {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    /// As Windows abbreviates the names.
    #[test]
    fn dates_in_the_language_of_the_machine() {
        let november = parse("Wed Nov 12 14:22:05.123 2025");
        assert!(november.is_some());
        for text in [
            "Mi Nov 12 14:22:05.123 2025",
            "Mi. Nov. 12 14:22:05,123 2025",
            "mer. nov. 12 02:22:05.123 pm 2025",
            "śr. lis 12 14:22:05.123 2025",
            "周三 11月 12 14:22:05.123 2025",
        ] {
            assert_eq!(parse(text), november, "{text}");
        }
        let tuesday = |month| parse(&format!("Tue {month} 4 08:00:00 2025"));
        for (name, month) in [
            ("Di Mrz", "Mar"),
            ("Di Mär", "Mar"),
            ("mar. mars", "Mar"),
            ("mar giu", "Jun"),
            ("mar. juin", "Jun"),
            ("mar. juil.", "Jul"),
            ("mar. août", "Aug"),
            ("Di Dez", "Dec"),
            ("mar. déc.", "Dec"),
            ("út čvc", "Jul"),
        ] {
            let date = parse(&format!("{name} 4 08:00:00 2025"));
            assert!(date.is_some() && date == tuesday(month), "{name}");
        }
        let latin_1 = b" Di M\xe4r 4 08:00:00 2025\r";
        assert_eq!(parse(&text(latin_1)), tuesday("Mar"));
    }
}
