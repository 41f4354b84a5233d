//! Decoders of both ends.

use super::line::{Ended, LineBuffer};
use super::{Answer, Command, Verb};
use core::str::FromStr;

/// Parses a line without its CR; `None` if it is not a command.
pub fn parse_command(line: &[u8]) -> Option<Command> {
    let (letter, rest) = line.split_first()?;
    let command = match Verb::from_letter(*letter)? {
        Verb::TopRate => return Some(Command::TopRate(unsigned(rest)?)),
        Verb::Ramp => return Some(Command::Ramp(unsigned(rest)?)),
        Verb::Distance => return Some(Command::Distance(number(rest)?)),
        Verb::Go => Command::Go,
        Verb::Stop => Command::Stop,
        Verb::State => Command::State,
    };
    rest.is_empty().then_some(command)
}

/// Parses a line without its CR; `None` if it is not an answer.
pub fn parse_answer(line: &[u8]) -> Option<Answer> {
    match line {
        [b'!'] => Some(Answer::Refused(None)),
        [b'!', first] if first.is_ascii_graphic() => Some(Answer::Refused(Some(*first))),
        [b'=', b'P', position @ .., b' ', b'M', moving @ (b'0' | b'1')] => {
            Some(Answer::State { position_steps: number(position)?, moving: *moving == b'1' })
        }
        [b'=', letter] => match Verb::from_letter(*letter)? {
            Verb::State => None,
            verb => Some(Answer::Done(verb)),
        },
        _ => None,
    }
}

/// An optional sign and decimal digits.
fn number<N: FromStr>(digits: &[u8]) -> Option<N> {
    core::str::from_utf8(digits).ok()?.parse().ok()
}

/// Decimal digits only; the standard parser would accept a `+`.
fn unsigned(digits: &[u8]) -> Option<u32> {
    if digits.first()?.is_ascii_digit() { number(digits) } else { None }
}

/// The table's end: finds commands in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct CommandDecoder {
    line: LineBuffer,
    refused: u64,
}

impl CommandDecoder {
    /// Takes bytes from the line, in runs of any length, and delivers each command or, for an invalid line, the
    /// refusal to send.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(Result<Command, Answer>)) {
        for byte in bytes {
            let command = match self.line.push(*byte) {
                None => continue,
                Some(Ended::Line(line)) => parse_command(line).ok_or_else(|| refusal(line[0])),
                Some(Ended::Overlong(first)) => Err(refusal(first)),
            };
            self.refused += u64::from(command.is_err());
            deliver(command);
        }
    }

    /// Number of lines that were not commands.
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

fn refusal(first: u8) -> Answer {
    Answer::Refused(first.is_ascii_graphic().then_some(first))
}

/// The host's end: finds answers in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct AnswerDecoder {
    line: LineBuffer,
    malformed: u64,
}

impl AnswerDecoder {
    /// Takes bytes from the line, in runs of any length, and delivers each answer. An invalid line is counted.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(Answer)) {
        for byte in bytes {
            let answer = match self.line.push(*byte) {
                None => continue,
                Some(Ended::Line(line)) => parse_answer(line),
                Some(Ended::Overlong(_)) => None,
            };
            match answer {
                Some(answer) => deliver(answer),
                None => self.malformed += 1,
            }
        }
    }

    /// Number of lines that were not answers.
    pub const fn malformed(&self) -> u64 {
        self.malformed
    }
}
