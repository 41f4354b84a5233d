//! Compares two runs of a program.

use std::fmt;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// An output of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// Time.
    pub at: Timestamp,
    /// Port.
    pub port: PortId,
    /// Data.
    pub what: Transmit,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at, port, what } = self;
        write!(f, "{} ns, port {}: ", at.as_nanos(), port.0)?;
        match what {
            Transmit::Bytes(bytes) => write!(f, "\"{}\"", bytes.as_slice().escape_ascii()),
            Transmit::Frame(frame) => write!(f, "{frame:x?}"),
        }
    }
}

/// The first difference of two runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// Number of equal events before it.
    pub same: usize,
    /// Output of the first run; `None` if it sent nothing more.
    pub first: Option<Event>,
    /// Output of the second run.
    pub second: Option<Event>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let show = |event: Option<Event>| {
            event.map_or_else(|| "nothing more".to_owned(), |event| event.to_string())
        };
        let (first, second) = (show(self.first), show(self.second));
        write!(f, "after {} events alike, one run: {first}; the other: {second}", self.same)
    }
}

/// The first difference between the outputs of two runs; `None` if they are the same to the nanosecond and the byte.
pub fn compare(first: &[Event], second: &[Event]) -> Option<Difference> {
    let same = first.iter().zip(second).take_while(|(one, other)| one == other).count();
    let (one, other) = (first.get(same).copied(), second.get(same).copied());
    (one.is_some() || other.is_some()).then_some(Difference { same, first: one, second: other })
}

#[cfg(test)]
mod tests {
    use super::{Event, compare};
    use wire::device::{PortId, Transmit};
    use wire::packet::Packet;
    use wire::time::Timestamp;

    fn event(at: i64, byte: u8) -> Event {
        let what = Transmit::Bytes(Packet::from_slice(&[byte]).unwrap());
        Event { at: Timestamp::from_nanos(at), port: PortId(0), what }
    }

    #[test]
    fn the_first_difference_is_told() {
        let run = [event(1, b'a'), event(2, b'b')];
        assert_eq!(compare(&run, &run), None);
        let text = |other: &[Event]| compare(&run, other).unwrap().to_string();
        let late =
            "after 1 events alike, one run: 2 ns, port 0: \"b\"; the other: 3 ns, port 0: \"b\"";
        assert_eq!(text(&[event(1, b'a'), event(3, b'b')]), late);
        assert!(text(&run[..1]).ends_with("the other: nothing more"));
    }
}
