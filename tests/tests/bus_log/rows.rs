//! Entries as rows of text that a reference prints in the same form: `micros channel kind identifier flags dlc data
//! direction`. An error frame has only its time: not every format contains more.

use bus_log::{Channel, Direction, Entry, ErrorFrame, Format, LogReader, LogWriter, Payload};
use embedded_can::Frame as _;
use std::fmt::Write as _;
use std::path::Path;
use wire::can::{CanFrame, ExtendedId, Id, StandardId};
use wire::time::Timestamp;

/// Returns the row of an entry.
pub fn row(entry: &Entry) -> String {
    // Programs that count in floating-point seconds are not exact to the nanosecond.
    let micros = (entry.at.as_nanos() + 500) / 1_000;
    let (kind, id, flags, dlc, data) = match &entry.payload {
        Payload::Frame(frame) => match frame.fd_flags() {
            Some(flags) => ("fd", frame.id(), flags.bits(), frame.data().len(), frame.data()),
            None => {
                let kind = if frame.is_remote() { "remote" } else { "data" };
                (kind, frame.id(), 0, frame.dlc(), frame.data())
            }
        },
        Payload::Error(_) => return format!("{micros} - error - 0 0 - -"),
        Payload::Serial(_) => panic!("no referee knows a serial line"),
    };
    let id = match id {
        Id::Standard(id) => format!("{:X}", id.as_raw()),
        Id::Extended(id) => format!("{:X}x", id.as_raw()),
    };
    let mut digits = String::new();
    for byte in data {
        write!(digits, "{byte:02x}").unwrap();
    }
    if digits.is_empty() {
        digits.push('-');
    }
    let direction = match entry.direction {
        Some(Direction::Rx) => "Rx",
        Some(Direction::Tx) => "Tx",
        None => "-",
    };
    format!("{micros} {} {kind} {id} {flags} {dlc} {digits} {direction}", entry.channel)
}

/// Returns the rows of entries, one per line.
pub fn rows<'a>(entries: impl IntoIterator<Item = &'a Entry>) -> String {
    entries.into_iter().map(|entry| row(entry) + "\n").collect()
}

/// Reads a file, without any errors.
pub fn read(path: &Path) -> Vec<Entry> {
    let format = Format::of_path(path).unwrap();
    LogReader::open(path, format).unwrap().map(Result::unwrap).collect()
}

pub fn write(path: &Path, entries: &[Entry]) {
    let mut writer = LogWriter::create(path, Format::of_path(path).unwrap()).unwrap();
    for entry in entries {
        let _ = writer.write(entry).unwrap();
    }
    writer.finish().unwrap();
}

/// Frames of every kind, as dense as on a bus. The first is at a whole millisecond, since the date in the head of an
/// ASC file is no finer. CAN FD frames contain data, since some programs read an empty one as a remote request.
pub fn sample() -> Vec<Entry> {
    let mut payloads = Vec::new();
    let (standard, extended) = (StandardId::new, ExtendedId::new);
    let ids: [Id; 4] = [
        standard(0).unwrap().into(),
        standard(0x7ff).unwrap().into(),
        extended(0x123).unwrap().into(),
        extended(0x1fff_ffff).unwrap().into(),
    ];
    let bytes: Vec<u8> = (0..64).map(|byte| byte * 4 + 1).collect();
    for id in ids {
        for length in 0..=8 {
            payloads.push(Payload::Frame(CanFrame::new(id, &bytes[..length]).unwrap()));
            payloads.push(Payload::Frame(CanFrame::new_remote(id, length).unwrap()));
        }
        for (bits, length) in [(0, 1), (1, 8), (2, 12), (3, 64), (1, 20), (0, 48)] {
            let flags = wire::can::FdFlags::from_bits(bits);
            payloads.push(Payload::Frame(CanFrame::fd(id, flags, &bytes[..length]).unwrap()));
        }
        payloads.push(Payload::Error(ErrorFrame::BUS_ERROR));
    }
    let entry = |(index, payload)| Entry {
        at: Timestamp::from_nanos(1_436_509_052_249_000_000 + index as i64 * 271_000),
        channel: Channel::numbered(index as u32 % 2),
        direction: Some(if index % 3 == 0 { Direction::Tx } else { Direction::Rx }),
        payload,
    };
    payloads.into_iter().enumerate().map(entry).collect()
}
