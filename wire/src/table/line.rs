//! Lines ended by CR, gathered in a bounded buffer.

use super::{CR, LINE_BYTES_MAX};

const LF: u8 = b'\n';

/// What a CR ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended<'a> {
    /// A line of at least one character.
    Line(&'a [u8]),
    /// A line of more than [`LINE_BYTES_MAX`] characters, by its first.
    Overlong(u8),
}

/// A line as far as it has come.
#[derive(Debug, Clone, Default)]
pub(super) struct LineBuffer {
    characters: [u8; LINE_BYTES_MAX],
    /// How many characters came; more than the buffer holds in an overlong line.
    length: usize,
}

impl LineBuffer {
    /// Takes one byte; something once a CR ends what is not empty.
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
