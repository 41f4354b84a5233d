//! The frames and bytes in the record of a run, as a log of its controller's node, or of the harness on the lines of a rig.
//!
//! | record | channel | direction |
//! |---|---|---|
//! | frame of the base | [`CAN`] | received |
//! | frame of the controller | [`CAN`] | sent |
//! | bytes of gyro, base or table | the device's name | received |
//! | bytes of the plan to the only device | that device's name | sent |
//! | other bytes of controller or plan | the sender's name | sent |
//! | frames of the nodes of a rig that the harness played (testers, emulated and replayed nodes) | the name of their line | sent |
//! | frames of nodes under test, and of faults | the name of the line | received |
//! | bytes of a node that talks to the device of a serial line | the name of the line | sent |
//! | bytes of that device | the name of the line | received |
//!
//! For the paper's robot a record names the sender of bytes but not the line: bytes of a controller that talks to a
//! gyro and a base on serial lines are all on the channel `controller`. Times are bench times since the start of the
//! run: a log that needs a date shows 1970.

use super::{CHANNEL_BYTES_MAX, Channel, Direction, Entry, Payload};
use record::header::Header;
use record::reader::RecordError;
use record::{Device, Record, RecordKind};
use std::collections::VecDeque;
use wire::packet::{BYTES_MAX, Packet};

/// Channel of the frames of a run.
pub const CAN: Channel = Channel::CAN0;

/// The entries of a record. Ends after an error of the record.
#[derive(Debug)]
pub struct Recorded<I> {
    records: I,
    header: Header,
    /// Remaining entries of a record that makes several.
    waiting: VecDeque<Entry>,
}

impl<I: Iterator<Item = Result<Record, RecordError>>> Recorded<I> {
    /// The entries in `records`; `header` names the devices.
    pub fn new(header: Header, records: impl IntoIterator<IntoIter = I>) -> Self {
        Self { records: records.into_iter(), header, waiting: VecDeque::new() }
    }
}

impl<I: Iterator<Item = Result<Record, RecordError>>> Iterator for Recorded<I> {
    type Item = Result<Entry, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(entry) = self.waiting.pop_front() {
                return Some(Ok(entry));
            }
            match self.records.next()? {
                Ok(record) => self.waiting.extend(entries(&self.header, &record)),
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// Bytes that arrived together and exceed a packet become several entries at the same time.
fn entries(header: &Header, record: &Record) -> Vec<Entry> {
    let node = header.node(record.device);
    let is_frame = matches!(record.kind, RecordKind::Frame(_));
    let direction = Some(match record.device {
        Device::Controller | Device::Plan => Direction::Tx,
        Device::Node(_)
            if node.is_some_and(|node| if is_frame { node.played } else { node.host }) =>
        {
            Direction::Tx
        }
        Device::Gyro
        | Device::Base
        | Device::Table
        | Device::Absolute
        | Device::Device
        | Device::Node(_) => Direction::Rx,
    });
    let entry = |channel, payload| Entry { at: record.at, channel, direction, payload };
    let line = header.line_of(record.device).filter(|line| *line != Device::Base.name());
    let line = line.map(|line| Channel::new(line.get(..CHANNEL_BYTES_MAX).unwrap_or(line)));
    let line = line.flatten();
    match &record.kind {
        RecordKind::Frame(frame) => {
            // A frame of the plan is one that a fault put on the bus: all nodes received it.
            let heard = (record.device == Device::Plan).then_some(Direction::Rx);
            let entry = entry(line.unwrap_or(CAN), Payload::Frame(*frame));
            vec![Entry { direction: heard.or(direction), ..entry }]
        }
        RecordKind::Bytes(bytes) => {
            // The plan talks to the only device of a bench on that one's line.
            let is_of_device = record.device == Device::Plan
                && header.lines.iter().any(|line| line.device == Device::Device);
            let whose = if is_of_device { Device::Device } else { record.device };
            let named = || Channel::new(whose.name());
            let Some(line) = line.or_else(named) else { return Vec::new() };
            let packets = bytes.chunks(BYTES_MAX).filter_map(Packet::from_slice);
            packets.map(|packet| entry(line, Payload::Serial(packet))).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, Direction, Payload, Recorded};
    use record::header::Header;
    use record::samples::{one_of_each, record};
    use record::{Device, RecordKind};
    use wire::packet::BYTES_MAX;

    #[test]
    fn frames_and_bytes_and_nothing_else() {
        let mut records = one_of_each();
        records.push(record(1.0, Device::Controller, RecordKind::Bytes(vec![7; BYTES_MAX + 1])));
        let entries: Vec<_> = Recorded::new(Header::default(), records.into_iter().map(Ok))
            .map(Result::unwrap)
            .collect();
        let seen: Vec<_> = entries
            .iter()
            .map(|entry| {
                let bytes = match &entry.payload {
                    Payload::Frame(frame) => frame.data().len(),
                    Payload::Serial(packet) => packet.len(),
                    other => panic!("{other:?}"),
                };
                (entry.channel, entry.direction.unwrap(), bytes)
            })
            .collect();
        let line = |name| Channel::new(name).unwrap();
        let expected = [
            (line("gyro"), Direction::Rx, 5),
            (line("can0"), Direction::Rx, 2),
            (line("controller"), Direction::Tx, BYTES_MAX),
            (line("controller"), Direction::Tx, 1),
        ];
        assert_eq!(seen, expected);
    }
}
