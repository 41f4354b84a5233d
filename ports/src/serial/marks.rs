//! Marks of a terminal in its stream for errors on the line.
//!
//! With `PARMRK` and `INPCK` set (termios(3)), a byte with a framing or parity error arrives as `FF 00 byte`, a break
//! as `FF 00 00`, and a correct byte `FF` as `FF FF`. A byte `00` with an error is indistinguishable from a break and
//! taken for one.

use wire::packet::Packet;

const MARK: u8 = 0xff;
const ZERO: u8 = 0x00;

/// The next element of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// At least one byte. Bytes with an error are included, as from a UART.
    Bytes(Packet),
    /// The next byte arrived with a framing or parity error.
    LineError,
    Break,
}

/// Parses a stream with marks, in runs of any length.
#[derive(Debug, Clone)]
pub struct Marks(State);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// The stream has no marks.
    Absent,
    /// Between bytes.
    Plain,
    /// After `FF`.
    Marked,
    /// After `FF 00`.
    MarkedZero,
    /// After a mark, with its byte outstanding.
    Wrong,
}

impl Default for Marks {
    fn default() -> Self {
        Self::new()
    }
}

impl Marks {
    /// For a stream with marks.
    pub const fn new() -> Self {
        Self(State::Plain)
    }

    /// For a stream without marks: all of it is data.
    pub const fn absent() -> Self {
        Self(State::Absent)
    }

    /// Takes the next event from the front of `stream`; `None` if it ends before.
    pub fn next(&mut self, stream: &mut &[u8]) -> Option<Heard> {
        let mut packet = Packet::new();
        while let Some((&byte, rest)) = stream.split_first() {
            let data = match (self.0, byte) {
                (State::Plain, MARK) => {
                    (self.0, *stream) = (State::Marked, rest);
                    continue;
                }
                (State::Marked, ZERO) => {
                    (self.0, *stream) = (State::MarkedZero, rest);
                    continue;
                }
                // The bytes before it go first.
                (State::MarkedZero, _) if !packet.is_empty() => break,
                (State::MarkedZero, ZERO) => {
                    (self.0, *stream) = (State::Plain, rest);
                    return Some(Heard::Break);
                }
                (State::MarkedZero, _) => {
                    self.0 = State::Wrong;
                    return Some(Heard::LineError);
                }
                // Not a mark: another program has changed the settings. Both bytes are data.
                (State::Marked, data) if data != MARK => {
                    if !packet.push(MARK) {
                        break;
                    }
                    self.0 = State::Plain;
                    continue;
                }
                (_, data) => data,
            };
            if !packet.push(data) {
                break;
            }
            *stream = rest;
            if self.0 != State::Absent {
                self.0 = State::Plain;
            }
        }
        (!packet.is_empty()).then_some(Heard::Bytes(packet))
    }
}

#[cfg(test)]
mod tests {
    use super::{Heard, Marks};
    use proptest::prelude::*;
    use wire::packet::Packet;

    fn all(marks: &mut Marks, mut stream: &[u8]) -> Vec<Heard> {
        let heard = std::iter::from_fn(|| marks.next(&mut stream)).collect();
        assert!(stream.is_empty());
        heard
    }

    fn bytes(bytes: &[u8]) -> Heard {
        Heard::Bytes(Packet::from_slice(bytes).unwrap())
    }

    #[test]
    fn errors_and_breaks_are_told_in_their_place() {
        let stream = b"ab\xff\xffc\xff\x00\x00d\xff\x00ef\xff\x00\xff";
        let heard = all(&mut Marks::new(), stream);
        let expected = [
            bytes(b"ab\xffc"),
            Heard::Break,
            bytes(b"d"),
            Heard::LineError,
            bytes(b"ef"),
            Heard::LineError,
            bytes(b"\xff"),
        ];
        assert_eq!(heard, expected);
    }

    #[test]
    fn without_marks_all_is_data() {
        assert_eq!(
            all(&mut Marks::absent(), b"\xff\x00\x00\xff\xff"),
            [bytes(b"\xff\x00\x00\xff\xff")]
        );
        assert_eq!(all(&mut Marks::new(), b"\xffa\xff\xff"), [bytes(b"\xffa\xff")]);
    }

    /// The stream that a terminal delivers for this data on the line.
    fn marked(line: &[(u8, bool)]) -> Vec<u8> {
        line.iter()
            .flat_map(|(byte, wrong)| match (byte, wrong) {
                (byte, true) => vec![0xff, 0x00, *byte],
                (0xff, false) => vec![0xff, 0xff],
                (byte, false) => vec![*byte],
            })
            .collect()
    }

    proptest! {
        #[test]
        fn wherever_reads_end_the_same_is_heard(
            line in prop::collection::vec((any::<u8>(), prop::bool::weighted(0.1)), 0..300),
            cuts in prop::collection::vec(0..600usize, 0..20),
        ) {
            let stream = marked(&line);
            let (mut marks, mut data, mut errors) = (Marks::new(), Vec::new(), 0);
            let mut cuts: Vec<usize> = cuts.into_iter().filter(|cut| *cut < stream.len()).collect();
            cuts.extend([0, stream.len()]);
            cuts.sort_unstable();
            for pair in cuts.windows(2) {
                for heard in all(&mut marks, &stream[pair[0]..pair[1]]) {
                    match heard {
                        Heard::Bytes(packet) => data.extend_from_slice(packet.as_slice()),
                        Heard::LineError => errors += 1,
                        Heard::Break => { errors += 1; data.push(0) }
                    }
                }
            }
            prop_assert_eq!(data, line.iter().map(|(byte, _)| *byte).collect::<Vec<_>>());
            prop_assert_eq!(errors, line.iter().filter(|(_, wrong)| *wrong).count());
        }

        #[test]
        fn no_stream_makes_it_panic_or_stand_still(stream in prop::collection::vec(prop::sample::select(vec![0u8, 1, 0xff]), 0..300)) {
            all(&mut Marks::new(), &stream);
        }
    }
}
