//! Writes an MDF file of version 4.10.

use super::super::entry::{Channel, Direction, Entry, Payload};
use super::super::numbers::{CHANNELS_MAX, Numbers};
use super::super::{Kept, WriteEntries};
use super::Kind;
use super::head::{self, Written};
use super::laid;
use super::output::{Data, Output, Target};
use embedded_can::Frame as _;
use std::io;
use wire::can::{CanFrame, Id};

/// Records per data block: 344 KB of data frames.
const BLOCK_RECORDS: usize = 4_096;

/// Writes an MDF file of version 4.10.
///
/// The measurement begins with the first entry. `canN` gets bus N + 1 if that is free, any other name the lowest free
/// one; the comment of the header has the names. Entries beyond 32 channels are left out. An entry with unknown
/// direction counts as received, because the format cannot express it. Frames, remote requests and error frames have
/// separate groups, each with a buffer of 4,096 records.
#[derive(Debug)]
pub(crate) struct Writer<'w> {
    out: Output<'w>,
    numbers: Numbers,
    /// Start, nanoseconds since 1970; `None` before the first entry.
    began: Option<i64>,
    groups: Box<[Group; Kind::ALL.len()]>,
}

#[derive(Debug)]
struct Group {
    data: Data,
    count: u64,
}

impl Group {
    fn of(kind: Kind) -> Self {
        Self { data: Data::records(BLOCK_RECORDS * head::record_bytes(kind)), count: 0 }
    }
}

impl<'w> Writer<'w> {
    /// Reserves room for the head of the file in `out`.
    pub(crate) fn new(out: impl Target + 'w) -> io::Result<Self> {
        let head = head::head(false, 0, Default::default(), 0);
        let out = Output::new(out, &head)?;
        let numbers = Numbers::up_to(CHANNELS_MAX);
        let groups = Box::new(Kind::ALL.map(Group::of));
        Ok(Self { out, numbers, began: None, groups })
    }
}

impl WriteEntries for Writer<'_> {
    /// Bytes of serial lines are left out, and so are the details of an error frame.
    fn write(&mut self, entry: &Entry) -> io::Result<Kept> {
        let at = entry.at.as_nanos();
        let (kind, frame) = match &entry.payload {
            Payload::Frame(frame) if frame.is_remote() => (Kind::Remote, Some(frame)),
            Payload::Frame(frame) => (Kind::Data, Some(frame)),
            Payload::Error(_) => (Kind::Error, None),
            Payload::Serial(_) => return Ok(Kept::LeftOut),
        };
        let number = self.numbers.of(entry.channel);
        let number = number.and_then(|(number, _)| u8::try_from(number).ok());
        let Some(number) = number else { return Ok(Kept::LeftOut) };
        // Both count from 1970.
        let since = at - *self.began.get_or_insert(at);
        let group = &mut self.groups[kind as usize];
        group.count += 1;
        let push = |records: &mut Vec<u8>| {
            let end = records.len() + head::record_bytes(kind);
            records.extend(since.to_le_bytes());
            records.push(number);
            if let Some(frame) = frame {
                push_frame(records, frame, entry.direction);
            }
            // Pads a frame with less than 64 bytes, and a remote request without flags.
            records.resize(end, 0);
        };
        group.data.push(&mut self.out, push)?;
        Ok(Kept::Written)
    }

    fn numbered(&self) -> Vec<(usize, Channel)> {
        self.numbers.named()
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        // Before the last of the data: a file that is cut here lacks data, too, and says so.
        let names = self.numbers.named().into_iter();
        let names: Vec<_> =
            names.map(|(number, name)| (format!("channel {number}"), name.to_string())).collect();
        let comment = self.out.block(*b"##MD", &[], laid::comment(&names).as_bytes())?;
        let mut written = [Written::default(); Kind::ALL.len()];
        for (written, group) in written.iter_mut().zip(self.groups.iter_mut()) {
            *written = Written { records: group.count, data: group.data.finish(&mut self.out)? };
        }
        let began = self.began.unwrap_or(0).unsigned_abs();
        self.out.finish(&head::head(true, began, written, comment))
    }
}

/// A frame, from after its channel on.
fn push_frame(record: &mut Vec<u8>, frame: &CanFrame, direction: Option<Direction>) {
    let (id, is_extended) = match frame.id() {
        Id::Standard(id) => (u32::from(id.as_raw()), false),
        Id::Extended(id) => (id.as_raw(), true),
    };
    let sent = direction == Some(Direction::Tx);
    record.extend(id.to_le_bytes());
    let length = frame.data().len() as u8;
    record.extend([u8::from(is_extended), frame.dlc() as u8, length, u8::from(sent)]);
    if !frame.is_remote() {
        let flags = frame.fd_flags();
        let is = |flag: Option<bool>| u8::from(flag == Some(true));
        record.push(u8::from(flags.is_some()));
        record.push(is(flags.map(|flags| flags.bit_rate_switch)));
        record.push(is(flags.map(|flags| flags.error_state)));
        record.extend_from_slice(frame.data());
    }
}
