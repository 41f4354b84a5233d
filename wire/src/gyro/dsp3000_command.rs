//! The commands of the KVH DSP-3000's 100 Hz ASCII interface: one letter each.
//!
//! Public drivers send them in three ways: bare (`libdsp3000`, EPFL, 2006), repeated, because one may be lost (the ROS
//! package `kvh`: `ZZZ`), and ended by LF and NUL (MRPT). Here a letter acts by itself and line ends do nothing, so
//! that all of them work; we send the letter and LF. The manual's maintenance mode is not covered.

use super::OutputMode;
use crate::packet::Packet;
use serde::{Deserialize, Serialize};

/// Commands of a host to the gyro.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Command {
    /// Set the output mode (`R`, `A`, `P`).
    Output(OutputMode),
    /// Reset the integrated angle to zero (`Z`).
    Zero,
}

impl Command {
    /// All commands.
    pub const ALL: [Self; 4] = [
        Self::Output(OutputMode::Rate),
        Self::Output(OutputMode::Increment),
        Self::Output(OutputMode::Integrated),
        Self::Zero,
    ];

    const fn letter(self) -> u8 {
        match self {
            Self::Output(OutputMode::Rate) => b'R',
            Self::Output(OutputMode::Increment) => b'A',
            Self::Output(OutputMode::Integrated) => b'P',
            Self::Zero => b'Z',
        }
    }

    /// The bytes of the command: its letter and LF.
    pub fn encode(self) -> Packet {
        Packet::from_slice(&[self.letter(), b'\n']).unwrap_or_default()
    }
}

/// Bytes to commands, at the gyro's end.
#[derive(Debug, Clone, Default)]
pub struct CommandDecoder {
    bytes_discarded: u64,
}

impl CommandDecoder {
    /// Takes bytes in pieces of any length and passes each command to `deliver`.
    pub fn feed(&mut self, bytes: &[u8], mut deliver: impl FnMut(Command)) {
        for &byte in bytes {
            match Command::ALL.into_iter().find(|command| command.letter() == byte) {
                Some(command) => deliver(command),
                None if matches!(byte, b'\r' | b'\n' | b'\0') => {}
                None => self.bytes_discarded = self.bytes_discarded.saturating_add(1),
            }
        }
    }

    /// Bytes that were neither a command nor a line end; saturates.
    pub const fn bytes_discarded(&self) -> u64 {
        self.bytes_discarded
    }
}

#[cfg(test)]
mod tests {
    use super::{Command, CommandDecoder};
    use crate::gyro::OutputMode;
    use std::vec::Vec;

    fn commands(bytes: &[u8]) -> (Vec<Command>, u64) {
        let mut decoder = CommandDecoder::default();
        let mut found = Vec::new();
        decoder.feed(bytes, |command| found.push(command));
        (found, decoder.bytes_discarded())
    }

    #[test]
    fn what_is_sent_is_received() {
        for command in Command::ALL {
            assert_eq!(commands(command.encode().as_slice()), (Vec::from([command]), 0));
        }
        assert_eq!(Command::Zero.encode().as_slice(), b"Z\n");
    }

    #[test]
    fn the_habits_of_public_drivers_are_understood() {
        let integrated = Command::Output(OutputMode::Integrated);
        assert_eq!(commands(b"P\n\0Z\n\0"), (Vec::from([integrated, Command::Zero]), 0));
        assert_eq!(commands(b"ZZZ"), (Vec::from([Command::Zero; 3]), 0));
    }

    #[test]
    fn anything_else_is_counted() {
        let rate = Command::Output(OutputMode::Rate);
        assert_eq!(commands(b"r\xffR?"), (Vec::from([rate]), 3));
    }
}
