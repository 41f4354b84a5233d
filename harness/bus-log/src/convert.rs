//! Converts one bus log to another.

use super::{Channel, Entry, Kept, LogError, LogWriter, Payload};
use std::fmt;

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Converted {
    pub written: u64,
    pub frames_left_out: u64,
    /// Packets of serial lines that the format cannot hold.
    pub packets_left_out: u64,
    /// The numbers that the file has in place of names of channels.
    pub numbered: Vec<(usize, Channel)>,
}

impl Converted {
    pub const fn is_whole(&self) -> bool {
        self.frames_left_out == 0 && self.packets_left_out == 0
    }
}

impl fmt::Display for Converted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entries = if self.written == 1 { "entry" } else { "entries" };
        write!(f, "{} {entries}", self.written)?;
        if self.frames_left_out > 0 {
            write!(f, ", {} frames left out", self.frames_left_out)?;
        }
        if self.packets_left_out > 0 {
            write!(f, ", {} packets of serial lines left out", self.packets_left_out)?;
        }
        for (place, (number, channel)) in self.numbered.iter().enumerate() {
            write!(f, "{} {number} is {channel}", if place == 0 { "; channel" } else { "," })?;
        }
        Ok(())
    }
}

/// Writes all entries in order and ends the log.
///
/// # Errors
/// The first error of the reader or the writer; the file then holds what came before it.
pub fn convert<E: From<LogError>>(
    entries: impl IntoIterator<Item = Result<Entry, E>>,
    mut writer: LogWriter<'_>,
) -> Result<Converted, E> {
    let mut converted = Converted::default();
    for entry in entries {
        let entry = match entry {
            Ok(entry) => entry,
            Err(error) => {
                // Good entries are kept; the error of the reader is the one that matters.
                let _ = writer.finish();
                return Err(error);
            }
        };
        match (writer.write(&entry)?, entry.payload) {
            (Kept::Written, _) => converted.written += 1,
            (Kept::LeftOut, Payload::Serial(_)) => converted.packets_left_out += 1,
            (Kept::LeftOut, _) => converted.frames_left_out += 1,
        }
    }
    converted.numbered = writer.numbered();
    writer.finish()?;
    Ok(converted)
}
