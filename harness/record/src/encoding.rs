//! Encoding of a record: its length as a varint, then postcard of (time since the previous record, device, kind).
//!
//! The difference instead of the instant saves three bytes per gyro sample. Bytes of a serial line, by far the largest
//! part of a full record, are encoded from a slice into the same bytes as from a [`RecordKind`].

use super::{Device, Record, RecordKind};
use serde::{Deserialize, Serialize, Serializer};
use wire::time::Timestamp;

/// The longest record; the harness' own texts and the calibration in a command are far shorter.
pub const RECORD_BYTES_MAX: usize = 64 * 1024;

/// Bytes of the longest length prefix: three groups of seven bits hold [`RECORD_BYTES_MAX`].
pub(super) const PREFIX_BYTES_MAX: usize = 3;

/// Takes the place of a record's length: ends a block, or in format 2 the file.
pub(super) const MARK: u8 = 0;

/// [`RecordKind::Bytes`] without the vector; the variant index must be that of the original.
#[derive(Serialize)]
pub(super) enum BorrowedKind<'a> {
    Bytes(#[serde(serialize_with = "as_bytes")] &'a [u8]),
}

fn as_bytes<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bytes(bytes)
}

#[derive(Serialize, Deserialize)]
struct Encoded<K> {
    since_last_ns: i64,
    device: Device,
    kind: K,
}

/// Replaces the content of `buffer` with the payload of a record, whose kind may be borrowed. The time difference wraps,
/// so any instant can be encoded.
pub(super) fn encode(
    buffer: &mut Vec<u8>,
    last: Timestamp,
    at: Timestamp,
    device: Device,
    kind: &impl Serialize,
) -> postcard::Result<()> {
    buffer.clear();
    let since_last_ns = at.as_nanos().wrapping_sub(last.as_nanos());
    let encoded = Encoded { since_last_ns, device, kind };
    *buffer = postcard::to_extend(&encoded, std::mem::take(buffer))?;
    Ok(())
}

pub(super) fn decode(payload: &[u8], last: Timestamp) -> postcard::Result<Record> {
    let (encoded, rest) = postcard::take_from_bytes::<Encoded<RecordKind>>(payload)?;
    if !rest.is_empty() {
        return Err(postcard::Error::DeserializeBadEncoding);
    }
    let at = Timestamp::from_nanos(last.as_nanos().wrapping_add(encoded.since_last_ns));
    Ok(Record { at, device: encoded.device, kind: encoded.kind })
}

/// The length of a payload as a varint, least significant group first, and the number of bytes used.
pub(super) fn prefix(length: usize) -> ([u8; PREFIX_BYTES_MAX], usize) {
    let mut bytes = [0; PREFIX_BYTES_MAX];
    let mut rest = length;
    for (index, byte) in bytes.iter_mut().enumerate() {
        *byte = (rest & 0x7f) as u8;
        rest >>= 7;
        if rest == 0 {
            return (bytes, index + 1);
        }
        *byte |= 0x80;
    }
    (bytes, PREFIX_BYTES_MAX)
}
