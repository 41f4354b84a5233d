//! Lines ended by CR, collected in a bounded buffer.

use super::{CR, LINE_BYTES_MAX};

const LF: u8 = b'\n';

/// A line ended by CR.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended<'a> {
    /// A line of at least one character.
    Line(&'a [u8]),
    /// A line of more than [`LINE_BYTES_MAX`] characters, with its first.
    Overlong(u8),
}

#[derive(Debug, Clone, Default)]
pub(super) struct LineBuffer {
    characters: [u8; LINE_BYTES_MAX],
    /// Number of received characters; more than the buffer holds for an overlong line.
    length: usize,
}

impl LineBuffer {
    /// Takes one byte; returns a line when a CR ends one that is not empty.
    pub(super) fn push(&mut self, byte: u8) -> Option<Ended<'_>> {
        match byte {
            CR => {
                let length = core::mem::take(&mut self.length);
                match self.characters.get(..length) {
                    Some([]) => None,
                    Some(line) => Some(Ended::Line(line)),
                    None => Some(Ended::Overlong(self.characters[0])),
                }
            }
            LF => None,
            character => {
                if let Some(place) = self.characters.get_mut(self.length) {
                    *place = character;
                }
                self.length = self.length.saturating_add(1);
                None
            }
        }
    }
}
