//! Writes the blocks at the start of an MDF file, which describe its groups and channels.

use super::laid::{BEGIN_BYTES, BYTES, Blocks, Records, SIGNED, UNSIGNED, Values, begin};
use super::{CG_BUS_EVENT, CG_PLAIN, CN_FIXED, CN_MASTER, Kind};

const CN_BUS_EVENT: u32 = 1 << 10;
/// Bytes of a time, the first value of every record.
const TIME_BYTES: u32 = 8;

/// The values after the time of a record, with their lengths.
const VALUES: [(&str, u32); 10] = [
    ("BusChannel", 1),
    ("ID", 4),
    ("IDE", 1),
    ("DLC", 1),
    ("DataLength", 1),
    ("Dir", 1),
    ("EDL", 1),
    ("BRS", 1),
    ("ESI", 1),
    ("DataBytes", 64),
];

/// The values in records of that kind: the first ones of [`VALUES`].
const fn values(kind: Kind) -> &'static [(&'static str, u32)] {
    let count = match kind {
        Kind::Data => VALUES.len(),
        Kind::Remote => 6,
        Kind::Error => 1,
    };
    VALUES.split_at(count).0
}

pub(super) fn record_bytes(kind: Kind) -> usize {
    let values: u32 = values(kind).iter().map(|(_, bytes)| bytes).sum();
    (TIME_BYTES + values) as usize
}

/// Final values of a group.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Written {
    pub(super) records: u64,
    /// Address of the data; zero if there are none.
    pub(super) data: u64,
}

/// The start of a file, of constant length. `began` is in nanoseconds since 1970, `comment` the address of a comment, zero
/// if there is none.
pub(super) fn head(
    is_finished: bool,
    began: u64,
    groups: [Written; Kind::ALL.len()],
    comment: u64,
) -> Vec<u8> {
    let mut blocks = Blocks::behind_begin();
    let mut next = 0;
    for (kind, written) in Kind::ALL.into_iter().zip(groups).rev() {
        next = group(&mut blocks, kind, written, next);
    }
    let history = blocks.history(began);
    let mut bytes = blocks.into_bytes();
    bytes[..BEGIN_BYTES].copy_from_slice(&begin(is_finished, began, next, history, comment));
    bytes
}

fn group(blocks: &mut Blocks, kind: Kind, written: Written, next: u64) -> u64 {
    let bytes = record_bytes(kind) as u32;
    let name = blocks.text(kind.name());
    // Type bus; bus type CAN.
    let source_name = blocks.text("CAN");
    let source = blocks.push(b"##SI", &[source_name, source_name, 0], &[2, 2, 0, 0, 0, 0, 0, 0]);
    let (mut first, mut at) = (0, bytes);
    for (value, length) in values(kind).iter().rev() {
        at -= length;
        let data_type = if *length > 8 { BYTES } else { UNSIGNED };
        let name = blocks.text(&format!("{}.{value}", kind.name()));
        let links = [first, 0, name, source, 0, 0, 0, 0];
        first = blocks.channel(links, of_frame(data_type, at, *length));
    }
    let frame_name = blocks.text(kind.name());
    let links = [0, first, frame_name, source, 0, 0, 0, 0];
    let frame = blocks.channel(links, of_frame(BYTES, TIME_BYTES, bytes - TIME_BYTES));
    let unit = blocks.text("s");
    // Linear: seconds are the number times 1e-9, without an offset.
    let seconds = blocks.conversion(1, unit, &[], &[0.0, 1e-9]);
    let time_name = blocks.text("Timestamp");
    let time =
        Values { kind: CN_MASTER, data_type: SIGNED, flags: 0, ..of_frame(0, 0, TIME_BYTES) };
    let time = blocks.channel([frame, 0, time_name, 0, seconds, 0, unit, 0], time);
    // The parts of names are separated by dots.
    let flags = u64::from(CG_BUS_EVENT | CG_PLAIN) | u64::from(b'.') << 16;
    let records = Records { count: written.records, flags, bytes, invalid_bytes: 0 };
    blocks.group([time, name, source, 0], records, written.data, next)
}

/// Values of a bus event.
const fn of_frame(data_type: u8, at: u32, bytes: u32) -> Values {
    Values { kind: CN_FIXED, data_type, at, bytes, flags: CN_BUS_EVENT, invalid_bit: 0 }
}
