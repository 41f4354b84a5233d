//! Version and serial number of an adapter.

use super::LINE_BYTES_MAX;
use core::fmt;

/// The longest text: the space in a line after its letter.
pub const TEXT_BYTES_MAX: usize = LINE_BYTES_MAX - 1;

/// Printable ASCII of at most [`TEXT_BYTES_MAX`] characters: a version or a serial number. The manual's have four
/// characters (`1013`: hardware 1.0, software 1.3); those of other adapters may have more or fewer.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Text {
    length: u8,
    characters: [u8; TEXT_BYTES_MAX],
}

impl Text {
    /// The text; `None` if it is too long or not printable ASCII.
    pub const fn new(text: &[u8]) -> Option<Self> {
        if text.len() > TEXT_BYTES_MAX {
            return None;
        }
        let mut characters = [0; TEXT_BYTES_MAX];
        let mut place = 0;
        while place < text.len() {
            if !matches!(text[place], b' '..=b'~') {
                return None;
            }
            characters[place] = text[place];
            place += 1;
        }
        Some(Self { length: text.len() as u8, characters })
    }

    /// The characters.
    pub fn as_bytes(&self) -> &[u8] {
        &self.characters[..usize::from(self.length)]
    }

    /// The characters as a string.
    pub fn as_str(&self) -> &str {
        // Cannot fail: the text is printable ASCII.
        core::str::from_utf8(self.as_bytes()).unwrap_or_default()
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Text({:?})", self.as_str())
    }
}
