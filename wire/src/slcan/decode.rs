//! Decoders of both ends.

use super::line::{LineBuffer, Terminator};
use super::{Answer, Command, LineError, parse_answer, parse_command};

/// Counts of the lines of one direction. Each line counts in exactly one field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineCounters {
    /// Lines understood; from an adapter, BEL counts as one.
    pub understood: u64,
    /// [`LineError::Malformed`].
    pub malformed: u64,
    /// [`LineError::Overlong`].
    pub overlong: u64,
    /// [`LineError::Unsupported`].
    pub unsupported: u64,
}

impl LineCounters {
    fn count<T>(&mut self, line: Result<T, LineError>) {
        let counter = match line {
            Ok(_) => &mut self.understood,
            Err(LineError::Malformed) => &mut self.malformed,
            Err(LineError::Overlong) => &mut self.overlong,
            Err(LineError::Unsupported) => &mut self.unsupported,
        };
        *counter = counter.saturating_add(1);
    }
}

/// The adapter's end: finds commands in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct CommandDecoder {
    line: LineBuffer,
    counters: LineCounters,
}

impl CommandDecoder {
    /// Takes bytes from the line, in runs of any length, and delivers each command or the reason why a line is
    /// invalid. An empty line is malformed as a command, and counts as understood: hosts send it to flush what was before. A BEL ends a line; a lone BEL, which no host sends, is ignored.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(Result<Command, LineError>)) {
        for byte in bytes {
            let line = match self.line.push(*byte) {
                None | Some((Ok([]), Terminator::Bell)) => continue,
                Some((line, _)) => line,
            };
            let command = line.and_then(parse_command);
            match line {
                Ok([]) => self.counters.count(Ok(())),
                _ => self.counters.count(command),
            }
            deliver(command);
        }
    }

    /// The counters.
    pub const fn counters(&self) -> LineCounters {
        self.counters
    }
}

/// The host's end: finds answers in a stream of bytes.
#[derive(Debug, Clone, Default)]
pub struct AnswerDecoder {
    line: LineBuffer,
    counters: LineCounters,
}

impl AnswerDecoder {
    /// Takes bytes from the line, in runs of any length, and delivers each answer. An invalid line is counted. A BEL
    /// is an answer by itself and ends any partial line before it, as in the Linux driver.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(Answer)) {
        for byte in bytes {
            let Some((line, terminator)) = self.line.push(*byte) else { continue };
            let bell = terminator == Terminator::Bell;
            if !(bell && line == Ok(&[])) {
                let answer = line.and_then(parse_answer);
                self.counters.count(answer);
                if let Ok(answer) = answer {
                    deliver(answer);
                }
            }
            if bell {
                self.counters.count(Ok(Answer::Refused));
                deliver(Answer::Refused);
            }
        }
    }

    /// The counters.
    pub const fn counters(&self) -> LineCounters {
        self.counters
    }
}
