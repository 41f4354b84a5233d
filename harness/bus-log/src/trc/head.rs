//! The comments at the start of a TRC file, which describe the rest.

use super::super::error::Defect;
use super::super::hex;
use super::{DAYS_TO_1970, NANOS_A_DAY};
use chrono::NaiveDateTime;

/// Most columns: PEAK's files have nine.
const COLUMNS_MAX: usize = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    /// `N`, `R`, and any other column of one word.
    Other,
    /// `O`: the time.
    Time,
    /// `T`: the type of message; in versions 1.1 to 1.3 also its direction.
    Type,
    /// `B`.
    Bus,
    /// `I`.
    Identifier,
    /// `d`.
    Direction,
    /// `L`: a data length code.
    Code,
    /// `l`: a length.
    Length,
    /// `D`: the data, to the end of the line.
    Data,
}

use Column::{Bus, Code, Data, Identifier, Length, Other, Time, Type};

/// Properties known before the first message.
#[derive(Debug)]
pub(super) struct Head {
    /// `None` if the version requires them and the file has not given them yet.
    pub(super) columns: Option<Vec<Column>>,
    /// Start of the trace, ns since 1970.
    pub(super) began: i64,
    /// Whether a number gave the start, which takes precedence over a comment.
    exact: bool,
}

impl Default for Head {
    /// Version 1.0, which has no head.
    fn default() -> Self {
        let columns = vec![Other, Time, Identifier, Code, Data];
        Self { columns: Some(columns), began: 0, exact: false }
    }
}

impl Head {
    /// Takes a comment, without its semicolon.
    pub(super) fn take(&mut self, comment: &[u8]) -> Result<(), Defect> {
        if let Some(version) = comment.strip_prefix(b"$FILEVERSION=") {
            self.columns = columns_of(version.trim_ascii())?;
        } else if let Some(days) = comment.strip_prefix(b"$STARTTIME=") {
            let days = days.trim_ascii();
            self.began = start(days).ok_or_else(|| {
                Defect::new("a start in days since 1899-12-30, before 2262", days)
            })?;
            self.exact = true;
        } else if let Some(letters) = comment.strip_prefix(b"$COLUMNS=") {
            self.columns = Some(columns(letters.trim_ascii())?);
        } else if let Some(date) = comment.trim_ascii().strip_prefix(b"Start time:")
            && !self.exact
        {
            self.began = date_of(date.trim_ascii()).unwrap_or(self.began);
        }
        Ok(())
    }
}

fn columns_of(version: &[u8]) -> Result<Option<Vec<Column>>, Defect> {
    Ok(Some(match version {
        b"1.0" => vec![Other, Time, Identifier, Code, Data],
        b"1.1" => vec![Other, Time, Type, Identifier, Code, Data],
        b"1.2" => vec![Other, Time, Bus, Type, Identifier, Code, Data],
        b"1.3" => vec![Other, Time, Bus, Type, Identifier, Other, Code, Data],
        b"2.0" | b"2.1" => return Ok(None),
        other => return Err(Defect::new("version 1.0 to 1.3, 2.0 or 2.1", other)),
    }))
}

fn columns(letters: &[u8]) -> Result<Vec<Column>, Defect> {
    let expected = "columns such as `N,O,T,B,I,d,R,L,D` with O, T, I, L or l, and D last";
    let column = |letter: &[u8]| match letter.trim_ascii() {
        b"O" => Time,
        b"T" => Type,
        b"B" => Bus,
        b"I" => Identifier,
        b"d" => Column::Direction,
        b"L" => Code,
        b"l" => Length,
        b"D" => Data,
        _ => Other,
    };
    let columns: Vec<_> =
        letters.split(|byte| *byte == b',').take(COLUMNS_MAX).map(column).collect();
    let has = |wanted: Column| columns.contains(&wanted);
    let whole = has(Time) && has(Type) && has(Identifier) && (has(Code) || has(Length));
    let data_at = columns.iter().position(|column| *column == Data);
    if whole && data_at.is_some_and(|at| at + 1 == columns.len()) {
        Ok(columns)
    } else {
        Err(Defect::new(expected, letters))
    }
}

/// Nanoseconds since 1970 of a start in days, to the microsecond.
fn start(days: &[u8]) -> Option<i64> {
    let (whole, fraction) =
        days.split_at(days.iter().position(|b| *b == b'.').unwrap_or(days.len()));
    let days = i64::try_from(hex::decimal(whole)?).ok()?.checked_sub(DAYS_TO_1970 as i64)?;
    let of_day = match fraction {
        [] => 0,
        fraction => hex::scaled(&[b"0", fraction].concat(), NANOS_A_DAY)?,
    };
    let micros = (of_day + 500) / 1_000;
    days.checked_mul(NANOS_A_DAY as i64)?.checked_add(micros * 1_000)
}

/// Nanoseconds since 1970 of a date such as `11.09.2002 16:00:20.682`.
fn date_of(text: &[u8]) -> Option<i64> {
    let text = std::str::from_utf8(text).ok()?;
    let date = NaiveDateTime::parse_from_str(text, "%d.%m.%Y %H:%M:%S%.f").ok()?;
    date.and_utc().timestamp_nanos_opt()
}

#[cfg(test)]
mod tests {
    use super::{Head, start};

    #[test]
    fn a_start_is_in_days() {
        // PEAK's own example shows 2021-12-18 14:28:07.062 beside it.
        assert_eq!(start(b"44548.6028595139"), Some(1_639_837_687_062_001_000));
        assert_eq!(start(b"25569"), Some(0));
        assert_eq!(start(b"25570.5"), Some(129_600_000_000_000));
        assert_eq!(start(b"0"), Some(-2_209_161_600_000_000_000));
        for text in [&b""[..], b"44548.", b".5", b"today", b"999999999"] {
            assert_eq!(start(text), None, "{}", String::from_utf8_lossy(text));
        }
    }

    #[test]
    fn the_date_of_a_comment_counts_without_a_start() {
        let mut head = Head::default();
        head.take(b"   Start time: 11.09.2002 16:00:20.682").unwrap();
        assert_eq!(head.began, 1_031_760_020_682_000_000);
        head.take(b"$STARTTIME=25569").unwrap();
        head.take(b" Start time: 11.09.2002 16:00:20.682").unwrap();
        assert_eq!(head.began, 0);
    }
}
