//! Reads an ASC file.

use super::super::entry::Entry;
use super::super::error::{Defect, LogError};
use super::super::lines::Lines;
use super::super::{Format, ReadEntries, hex};
use super::date;
use super::event::{self, Base};
use std::fmt;
use std::io::Read;
use std::path::Path;
use wire::time::{Span, Timestamp};

/// The first event of every measurement.
const BEGINNING: &[u8] = b"Start of measurement";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Times {
    /// The start of the measurement.
    Absolute,
    /// The previous event.
    Relative,
}

/// The entries of an ASC file.
#[derive(Debug)]
pub(crate) struct Reader<R: Read> {
    lines: Lines<R>,
    base: Base,
    times: Times,
    began: Timestamp,
    /// Line and text of a date that is not understood, as long as no other is.
    refused: Option<(u64, String)>,
    /// Time of the last event since the start.
    last: Span,
    passed_over: u64,
}

enum Line<'a> {
    Nothing,
    Date(&'a [u8]),
    Base(Base, Times),
    /// Time and the rest of the line.
    Event(i64, &'a [u8]),
    /// An unknown line that is not an event.
    Other,
}

impl<R: Read> Reader<R> {
    /// Reads from `input`; errors name `path`.
    pub(crate) fn new(path: &Path, input: R) -> Self {
        Self {
            lines: Lines::new(path, input, Format::Asc),
            base: Base::Hex,
            times: Times::Absolute,
            began: Timestamp::ZERO,
            refused: None,
            last: Span::ZERO,
            passed_over: 0,
        }
    }
}

impl<R: Read + fmt::Debug> ReadEntries for Reader<R> {
    fn read(&mut self) -> Result<Option<Entry>, LogError> {
        while self.lines.advance()? {
            let line = parse(self.lines.text()).map_err(|defect| self.lines.malformed(defect))?;
            match line {
                Line::Nothing => {}
                Line::Other => self.passed_over += 1,
                Line::Base(base, times) => (self.base, self.times) = (base, times),
                Line::Date(text) => {
                    let text = date::text(text);
                    match date::parse(&text) {
                        Some(nanos) => {
                            (self.began, self.refused) = (Timestamp::from_nanos(nanos), None);
                        }
                        None if self.began == Timestamp::ZERO && !text.is_empty() => {
                            self.refused = Some((self.lines.number(), shown(&text)));
                        }
                        None => {}
                    }
                }
                Line::Event(nanos, text) => {
                    let since = match self.times {
                        Times::Absolute => 0,
                        Times::Relative => self.last.as_nanos(),
                    };
                    self.last = Span::from_nanos(since.saturating_add(nanos));
                    let event = event::parse(text, self.base)
                        .map_err(|defect| self.lines.malformed(defect))?;
                    let Some((channel, direction, payload)) = event else {
                        self.passed_over +=
                            u64::from(!text.trim_ascii().eq_ignore_ascii_case(BEGINNING));
                        continue;
                    };
                    let at = self.began.as_nanos().saturating_add(self.last.as_nanos());
                    let at = Timestamp::from_nanos(at);
                    return Ok(Some(Entry { at, channel, direction, payload }));
                }
            }
        }
        Ok(None)
    }

    /// Number of events so far that are not frames of a CAN bus, and of lines that are not understood.
    fn passed_over(&self) -> u64 {
        self.passed_over
    }

    fn notes(&self) -> Vec<String> {
        let refused = self.refused.as_ref().map(|(line, date)| {
            format!("the date `{date}` in line {line} is not understood: times count from 1970")
        });
        refused.into_iter().chain(self.lines.note()).collect()
    }
}

/// The date for a message: shortened, without control characters.
fn shown(date: &str) -> String {
    const CHARS_MAX: usize = 60;
    date.chars().take(CHARS_MAX).collect::<String>().escape_debug().to_string()
}

fn parse(line: &[u8]) -> Result<Line<'_>, Defect> {
    if line.is_empty() || line.starts_with(b"//") {
        return Ok(Line::Nothing);
    }
    let (first, rest) = hex::word(line);
    if first[0].is_ascii_digit() {
        let time = hex::seconds(first);
        let time =
            time.ok_or_else(|| Defect::new("a time in seconds such as `0.000271`", first))?;
        return Ok(Line::Event(time, rest));
    }
    let is = |word: &[u8], text: &[u8]| word.eq_ignore_ascii_case(text);
    let (second, behind) = hex::word(rest);
    Ok(match first {
        word if is(word, b"date") => Line::Date(rest),
        word if is(word, b"base") => base(rest)?,
        word if is(word, b"begin") && is(second, b"triggerblock") => Line::Date(behind),
        word if is(word, b"end") && is(second, b"triggerblock") => Line::Nothing,
        // `internal events logged`, `no internal events logged`.
        word if is(word, b"internal") || is(word, b"no") => Line::Nothing,
        _ => Line::Other,
    })
}

/// `hex  timestamps absolute`; timestamps are absolute by default.
fn base(text: &[u8]) -> Result<Line<'static>, Defect> {
    let (number, rest) = hex::word(text);
    let base = match number {
        b"hex" => Base::Hex,
        b"dec" => Base::Dec,
        other => return Err(Defect::new("`hex` or `dec` behind `base`", other)),
    };
    let (_timestamps, rest) = hex::word(rest);
    let times = match hex::word(rest).0 {
        b"absolute" | b"" => Times::Absolute,
        b"relative" => Times::Relative,
        other => return Err(Defect::new("`absolute` or `relative` timestamps", other)),
    };
    Ok(Line::Base(base, times))
}
