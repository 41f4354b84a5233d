//! Selects the entries of a log that a port can send: the frames of one bus.

use super::{Channel, Entry, LogError, Payload};
use serde::Serialize;
use std::fmt;

/// The frames of one channel, in the order of the log. Other entries are counted.
///
/// Frames sent by the logging node are included: on the bus they were like the others.
#[derive(Debug)]
pub struct Playable<I> {
    entries: I,
    /// The channel; that of the first frame if none was named.
    channel: Option<Channel>,
    /// Channel of the first frame of any kind.
    first_seen: Option<Channel>,
    fd: bool,
    left_out: LeftOut,
}

/// Entries of a log that are not sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct LeftOut {
    pub other_channels: u64,
    /// CAN FD frames, if the port sends only classic ones.
    pub fd_frames: u64,
    /// Error frames: an error seen by a controller cannot be sent.
    pub error_frames: u64,
    pub packets: u64,
}

impl LeftOut {
    pub const fn total(self) -> u64 {
        self.other_channels + self.fd_frames + self.error_frames + self.packets
    }
}

impl fmt::Display for LeftOut {
    /// Formats the total and the count of each kind.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.total())?;
        let kinds = [
            (self.other_channels, "of other channels"),
            (self.fd_frames, "CAN FD frames"),
            (self.error_frames, "error frames"),
            (self.packets, "packets of serial lines"),
        ];
        let mut before = ": ";
        for (count, kind) in kinds.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "{before}{count} {kind}")?;
            before = ", ";
        }
        Ok(())
    }
}

impl<I: Iterator<Item = Result<Entry, LogError>>> Playable<I> {
    /// The frames of `channel`, or of the first frame's channel if it is `None`. CAN FD frames are included if `fd`.
    pub fn new(entries: I, channel: Option<Channel>, fd: bool) -> Self {
        Self { entries, channel, first_seen: None, fd, left_out: LeftOut::default() }
    }
}

impl<I> Playable<I> {
    /// The channel of these frames; `None` before the first one if none was named.
    pub const fn channel(&self) -> Option<Channel> {
        self.channel
    }

    /// The channel of the first frame of any kind that was read.
    pub const fn first_seen(&self) -> Option<Channel> {
        self.first_seen
    }

    /// Counts of the entries left out so far.
    pub const fn left_out(&self) -> LeftOut {
        self.left_out
    }
}

impl<I: Iterator<Item = Result<Entry, LogError>>> Iterator for Playable<I> {
    type Item = Result<Entry, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let entry = match self.entries.next()? {
                Ok(entry) => entry,
                Err(error) => return Some(Err(error)),
            };
            if !matches!(entry.payload, Payload::Serial(_)) {
                self.first_seen.get_or_insert(entry.channel);
            }
            match entry.payload {
                Payload::Serial(_) => self.left_out.packets += 1,
                _ if self.channel.is_some_and(|channel| channel != entry.channel) => {
                    self.left_out.other_channels += 1;
                }
                Payload::Frame(frame) if frame.fd_flags().is_some() && !self.fd => {
                    self.left_out.fd_frames += 1;
                }
                Payload::Frame(_) => {
                    self.channel = Some(entry.channel);
                    return Some(Ok(entry));
                }
                Payload::Error(_) => self.left_out.error_frames += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, LeftOut, Playable};
    use crate::{Format, LogReader};
    use std::io::Cursor;

    const LOG: &str = "\
(1.000000) can0 20000080#0000000000000000
(1.001000) can1 101##101
(1.002000) can1 102#11 T
(1.003000) can0 103#22
(1.004000) can1 104#33 R
";

    fn played(channel: Option<Channel>) -> (Vec<i64>, LeftOut, Option<Channel>) {
        let reader = LogReader::new("x.log".as_ref(), Cursor::new(LOG), Format::Candump).unwrap();
        let mut frames = Playable::new(reader, channel, false);
        let times = frames.by_ref().map(|entry| entry.unwrap().at.as_nanos() / 1_000_000).collect();
        (times, frames.left_out(), frames.channel())
    }

    #[test]
    fn the_bus_of_the_first_frame_is_played() {
        let (times, left_out, channel) = played(None);
        assert_eq!((times, channel), (vec![1_002, 1_004], Channel::new("can1")));
        assert_eq!(left_out.to_string(), "3: 1 of other channels, 1 CAN FD frames, 1 error frames");
        let (times, left_out, _) = played(Some(Channel::CAN0));
        assert_eq!((times, left_out.total()), (vec![1_003], 4));
        assert_eq!(played(Channel::new("vcan7")).0, [0; 0]);
        let with_fd = LogReader::new("x.log".as_ref(), Cursor::new(LOG), Format::Candump).unwrap();
        assert_eq!(Playable::new(with_fd, None, true).count(), 3);
        assert_eq!(LeftOut::default().to_string(), "0");
    }
}
