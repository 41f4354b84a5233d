//! Writes the blocks at the start of an MDF file, which describe its groups and channels.

use super::laid::{BEGIN_BYTES, Blocks, begin};
use super::{CG_BUS_EVENT, CG_PLAIN, CN_FIXED, CN_MASTER, Kind};

/// Data types of channels.
const UNSIGNED: u8 = 0;
const SIGNED: u8 = 2;
const BYTES: u8 = 10;
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

/// The start of a file, of constant length. `began` is in nanoseconds since 1970.
pub(super) fn head(is_finished: bool, began: u64, groups: [Written; Kind::ALL.len()]) -> Vec<u8> {
    let mut blocks = Blocks::behind_begin();
    let mut next = 0;
    for (kind, written) in Kind::ALL.into_iter().zip(groups).rev() {
        next = data_group(&mut blocks, kind, written, next);
    }
    let history = blocks.history(began);
    let mut bytes = blocks.into_bytes();
    bytes[..BEGIN_BYTES].copy_from_slice(&begin(is_finished, began, next, history, 0));
    bytes
}

fn data_group(blocks: &mut Blocks, kind: Kind, written: Written, next: u64) -> u64 {
    let channel_group = channel_group(blocks, kind, written.records);
    blocks.push(b"##DG", &[next, channel_group, written.data, 0], &[0; 8])
}

fn channel_group(blocks: &mut Blocks, kind: Kind, records: u64) -> u64 {
    let bytes = record_bytes(kind) as u32;
    let name = blocks.text(kind.name());
    // Type bus; bus type CAN.
    let source_name = blocks.text("CAN");
    let source = blocks.push(b"##SI", &[source_name, source_name, 0], &[2, 2, 0, 0, 0, 0, 0, 0]);
    let (mut first, mut at) = (0, bytes);
    for (value, length) in values(kind).iter().rev() {
        at -= length;
        let data_type = if *length > 8 { BYTES } else { UNSIGNED };
        let full = format!("{}.{value}", kind.name());
        first = channel(blocks, &full, [first, 0, 0, 0], source, CN_FIXED, data_type, at, *length);
    }
    let all = bytes - TIME_BYTES;
    let frame = [0, first, 0, 0];
    let frame = channel(blocks, kind.name(), frame, source, CN_FIXED, BYTES, TIME_BYTES, all);
    let unit = blocks.text("s");
    // Linear: seconds are the number times 1e-9, without an offset.
    let mut linear = vec![1, 0, 0, 0, 0, 0, 2, 0];
    linear.extend([0; 16]);
    linear.extend(0f64.to_le_bytes());
    linear.extend(1e-9f64.to_le_bytes());
    let seconds = blocks.push(b"##CC", &[0, unit, 0, 0], &linear);
    let links = [frame, 0, seconds, unit];
    let time = channel(blocks, "Timestamp", links, 0, CN_MASTER, SIGNED, 0, TIME_BYTES);
    let mut data = Vec::new();
    // Its records have no record number.
    data.extend(0u64.to_le_bytes());
    data.extend(records.to_le_bytes());
    data.extend((CG_BUS_EVENT | CG_PLAIN).to_le_bytes());
    data.extend([b'.', 0, 0, 0, 0, 0]);
    data.extend(bytes.to_le_bytes());
    data.extend([0; 4]);
    blocks.push(b"##CG", &[0, time, name, source, 0, 0], &data)
}

/// `links` are the next channel, the components, the conversion and the unit.
#[expect(clippy::too_many_arguments, reason = "a channel has as many properties")]
fn channel(
    blocks: &mut Blocks,
    name: &str,
    links: [u64; 4],
    source: u64,
    kind: u8,
    data_type: u8,
    at: u32,
    bytes: u32,
) -> u64 {
    let name = blocks.text(name);
    let [next, parts, conversion, unit] = links;
    let is_master = kind == CN_MASTER;
    let flags = if is_master { 0 } else { CN_BUS_EVENT };
    let mut data = vec![kind, u8::from(is_master), data_type, 0];
    data.extend(at.to_le_bytes());
    data.extend((8 * bytes).to_le_bytes());
    data.extend(flags.to_le_bytes());
    data.extend([0; 56]);
    blocks.push(b"##CN", &[next, parts, name, source, conversion, 0, unit, 0], &data)
}
