//! Entries for tests.

use crate::{
    Channel, Direction, Entry, ErrorFrame, Format, LogError, LogReader, LogWriter, Payload,
};
use embedded_can::Frame as _;
use proptest::prelude::*;
use std::io::Cursor;
use std::path::Path;
use wire::can::{CanFrame, ExtendedId, FdFlags, Id, StandardId};
use wire::packet::Packet;
use wire::time::Timestamp;

/// The entries of a file with these bytes, as far as it can be read, and the error that ends it.
pub(super) fn read(format: Format, bytes: &[u8]) -> (Vec<Entry>, Option<LogError>) {
    let mut entries = Vec::new();
    let reader = match LogReader::new(Path::new("bus.log"), Cursor::new(bytes), format) {
        Ok(reader) => reader,
        Err(error) => return (entries, Some(error)),
    };
    for entry in reader {
        match entry {
            Ok(entry) => entries.push(entry),
            Err(error) => return (entries, Some(error)),
        }
    }
    (entries, None)
}

/// A complete file.
pub(super) fn written(format: Format, entries: &[Entry]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = LogWriter::new(Path::new("bus.log"), &mut bytes, format).unwrap();
    for entry in entries {
        let _ = writer.write(entry).unwrap();
    }
    writer.finish().unwrap();
    bytes.into_inner()
}

fn any_id() -> impl Strategy<Value = Id> {
    prop_oneof![
        (0u16..=0x7ff).prop_map(|raw| Id::Standard(StandardId::new(raw).unwrap())),
        (0u32..=0x1fff_ffff).prop_map(|raw| Id::Extended(ExtendedId::new(raw).unwrap())),
    ]
}

fn any_data(max: usize) -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..=max)
}

/// Any frame or error of a bus.
pub(super) fn any_frame() -> impl Strategy<Value = Payload> {
    let fd = (any_id(), any::<(bool, bool)>(), any_data(64)).prop_map(|(id, flags, mut data)| {
        let flags = FdFlags { bit_rate_switch: flags.0, error_state: flags.1 };
        while CanFrame::fd(id, flags, &data).is_none() {
            data.pop();
        }
        Payload::Frame(CanFrame::fd(id, flags, &data).unwrap())
    });
    prop_oneof![
        (any_id(), any_data(8))
            .prop_map(|(id, data)| Payload::Frame(CanFrame::new(id, &data).unwrap())),
        (any_id(), 0usize..=8)
            .prop_map(|(id, length)| Payload::Frame(CanFrame::new_remote(id, length).unwrap())),
        fd,
        (0u32..=0x1fff_ffff, any::<[u8; 8]>())
            .prop_map(|(class, details)| Payload::Error(ErrorFrame::new(class, details).unwrap())),
    ]
}

/// Any entry of a bus or a line, at any time since 1970.
pub(super) fn any_entry() -> impl Strategy<Value = Entry> {
    let serial = any_data(64).prop_map(|data| Packet::from_slice(&data).unwrap());
    let payload = prop_oneof![4 => any_frame(), 1 => serial.prop_map(Payload::Serial)];
    let direction = prop::option::of(prop::sample::select(vec![Direction::Rx, Direction::Tx]));
    ("[a-z]{1,12}[0-9]{1,3}", 0i64..i64::MAX, direction, payload).prop_map(
        |(channel, nanos, direction, payload)| Entry {
            at: Timestamp::from_nanos(nanos),
            channel: Channel::new(&channel).unwrap(),
            direction,
            payload,
        },
    )
}
