//! The line protocol of a stepper-driven rotary table.
//!
//! A documented subset in the style of the ASCII indexers of the 1990s (assumption: the paper does not name its
//! table's controller): a line is a letter, an optional signed decimal number and CR; the answer is a line as well.
//!
//! | line | meaning | answer |
//! |---|---|---|
//! | `V2400` | top step rate, steps/s | `=V` |
//! | `A1200` | ramp, steps/s^2 | `=A` |
//! | `D-28800` | distance of the next move, steps; ccw is positive | `=D` |
//! | `G` | go | `=G`; `!G` while moving |
//! | `S` | stop with the ramp | `=S` |
//! | `?` | state | `=P<steps> M0` at rest, `=P<steps> M1` moving |
//! | anything else | | `!` and the line's first letter |
//!
//! Rates have no sign, a distance may have one (`+` or `-`). A number that does not fit 32 bits is *anything else*, as
//! is a line longer than [`LINE_BYTES_MAX`]. If the first character is not printable ASCII the refusal is `!` alone.
//! An LF and an empty line are ignored, so that a terminal with CR LF line ends works.
//!
//! The table itself checks whether a value makes sense (a rate of zero, for example), and answers with
//! [`Answer::Refused`] if not.
//!
//! [`CommandDecoder`] is the table's end, [`AnswerDecoder`] the host's. Every CR ends a line, whatever precedes it:
//! after garbage without one, the first line is lost, and the second is understood.

mod decode;
mod line;

pub use decode::{AnswerDecoder, CommandDecoder, parse_answer, parse_command};

use crate::packet::{BYTES_MAX, Packet};
use crate::serial::SerialSettings;
use core::fmt::{self, Write as _};
use serde::{Deserialize, Serialize};

/// The line's settings (assumption: the usual ones of such indexers).
pub const SETTINGS: SerialSettings = SerialSettings::new_8n1(9_600);

/// The longest line, CR not counted: `=P-2147483648 M0`.
pub const LINE_BYTES_MAX: usize = 16;

/// The first line that starts after any garbage and a CR is understood; it ends within this many bytes after that CR.
pub const RESYNC_BYTES_MAX: usize = LINE_BYTES_MAX + 1;

const _: () = assert!(LINE_BYTES_MAX < BYTES_MAX, "a line and its CR fit a packet");

const CR: u8 = b'\r';

crate::tabled! {
    /// The commands, without their numbers.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Verb {
        /// `V`
        TopRate = b'V',
        /// `A`
        Ramp = b'A',
        /// `D`
        Distance = b'D',
        /// `G`
        Go = b'G',
        /// `S`
        Stop = b'S',
        /// `?`
        State = b'?',
    }
    /// The character of the verb.
    pub fn letter() -> u8
}

impl Verb {
    /// The verb of this character.
    pub fn from_letter(letter: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|verb| verb.letter() == letter)
    }
}

/// Commands of a host to the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Command {
    /// Top step rate, in steps/s.
    TopRate(u32),
    /// Ramp, in steps/s^2.
    Ramp(u32),
    /// Length of the next move, in steps; counter-clockwise is positive.
    Distance(i32),
    /// Start the move.
    Go,
    /// Stop with the ramp.
    Stop,
    /// Send [`Answer::State`].
    State,
}

impl Command {
    /// The verb of the command.
    pub const fn verb(self) -> Verb {
        match self {
            Self::TopRate(_) => Verb::TopRate,
            Self::Ramp(_) => Verb::Ramp,
            Self::Distance(_) => Verb::Distance,
            Self::Go => Verb::Go,
            Self::Stop => Verb::Stop,
            Self::State => Verb::State,
        }
    }

    /// The command's line, CR included.
    pub fn encode(self) -> Packet {
        encode_line(&self)
    }
}

impl fmt::Display for Command {
    /// The line without its CR.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = char::from(self.verb().letter());
        match self {
            Self::TopRate(number) | Self::Ramp(number) => write!(f, "{letter}{number}"),
            Self::Distance(number) => write!(f, "{letter}{number}"),
            Self::Go | Self::Stop | Self::State => write!(f, "{letter}"),
        }
    }
}

/// Answers of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// The command was carried out or started. Never [`Verb::State`], whose answer is the state.
    Done(Verb),
    /// The line was not understood or cannot be carried out at the moment; with its first character if that is
    /// printable ASCII.
    Refused(Option<u8>),
    /// State of the table.
    State {
        /// Steps sent to the motor since power-up; counter-clockwise is positive.
        position_steps: i32,
        /// A move is in progress.
        moving: bool,
    },
}

impl Answer {
    /// Refuses `verb`.
    pub const fn refused(verb: Verb) -> Self {
        Self::Refused(Some(verb.letter()))
    }

    /// The answer's line, CR included.
    pub fn encode(self) -> Packet {
        encode_line(&self)
    }
}

impl fmt::Display for Answer {
    /// The line without its CR.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Done(verb) => write!(f, "={}", char::from(verb.letter())),
            Self::Refused(Some(first)) if first.is_ascii_graphic() => {
                write!(f, "!{}", char::from(first))
            }
            Self::Refused(_) => f.write_str("!"),
            Self::State { position_steps, moving } => {
                write!(f, "=P{position_steps} M{}", u8::from(moving))
            }
        }
    }
}

fn encode_line(line: &impl fmt::Display) -> Packet {
    let mut packet = Packet::new();
    // Cannot fail: no line is longer than LINE_BYTES_MAX, and a packet holds one with its CR.
    let written = write!(packet, "{line}").is_ok() && packet.push(CR);
    debug_assert!(written, "a line and its CR fit a packet");
    packet
}

#[cfg(test)]
mod tests;
