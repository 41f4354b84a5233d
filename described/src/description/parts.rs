//! Parts that several sections have: times, names of messages, and files.

use crate::error::{Mistake, Read};
use crate::files::Files;
use crate::hint;
use crate::layout::{Layout, Message, Sender};
use crate::place::Place;
use csv::{Position, ReaderBuilder, StringRecord, Trim};
use wire::time::Span;

/// Shortest period of a message. Assumption: half the frame time of a bus of 1 Mbit/s.
pub(super) const PERIOD_S_MIN: f64 = 50e-6;

/// Longer than any run: a larger time is a typing mistake.
const TIME_S_MAX: f64 = 1e6;

pub(super) fn question(name: &str, layout: &Layout, place: &Place) -> Read<usize> {
    let heard = |message: &&Message| message.sender == Sender::Host;
    layout.find(name).filter(|index| layout.messages()[*index].sender == Sender::Host).ok_or_else(
        || {
            let known = layout.messages().iter().filter(heard).map(|known| known.name.as_str());
            let known: Vec<&str> = known.collect();
            Mistake::new(place.clone(), format!("the device hears no message `{name}`"))
                .help(hint::proposal(name, &known))
        },
    )
}

/// Reads the file that the description names at `place`.
pub(crate) fn text(files: &mut dyn Files, name: &str, place: &Place) -> Read<String> {
    files.text(name).map_err(|error| place.mistake(format!("failed to read `{name}`: {error}")))
}

/// Parses a time of a file.
pub(super) fn seconds(value: f64, least: f64, place: &Place) -> Read<Span> {
    if (least..=TIME_S_MAX).contains(&value) {
        return Ok(Span::from_secs_f64(value));
    }
    Err(Mistake::new(place.clone(), format!("{value} s is not a time here"))
        .help(format!("from {least} s to {TIME_S_MAX} s")))
}

/// Reads the numbers of a CSV file, line by line in the columns that `select` finds in its first line; at most `lines`
/// lines.
pub(super) fn csv(
    (file, text): (&str, &str),
    place: &Place,
    lines: usize,
    select: impl FnOnce(&StringRecord) -> Read<Vec<usize>>,
) -> Read<Vec<f64>> {
    let failed = |error: csv::Error| Mistake::new(place.clone(), format!("`{file}`: {error}"));
    let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(text.as_bytes());
    let columns = select(reader.headers().map_err(failed)?)?;
    let mut numbers = Vec::new();
    for record in reader.records().take(lines) {
        let record = record.map_err(failed)?;
        let line = record.position().map_or(0, Position::line);
        for column in &columns {
            let cell = record.get(*column).unwrap_or_default();
            numbers.push(cell.parse::<f64>().map_err(|_| {
                let message = format!("`{file}` line {line}: `{cell}` is not a number");
                Mistake::new(place.clone(), message)
            })?);
        }
    }
    Ok(numbers)
}
