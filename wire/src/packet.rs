//! A bounded run of serial bytes, sent in one piece.

/// Maximum length. A sentence of NMEA 0183 has up to 82 bytes; no exchange of a codec here is longer.
pub const BYTES_MAX: usize = 128;

/// Up to [`BYTES_MAX`] bytes; excess input is refused, never cut.
#[derive(Clone, Copy)]
pub struct Packet {
    length: u8,
    bytes: [u8; BYTES_MAX],
}

impl Packet {
    /// No bytes.
    #[inline]
    pub const fn new() -> Self {
        Self { length: 0, bytes: [0; BYTES_MAX] }
    }

    /// The bytes of `slice`; `None` if there are more than [`BYTES_MAX`].
    #[inline]
    pub fn from_slice(slice: &[u8]) -> Option<Self> {
        let mut packet = Self::new();
        packet.extend(slice).then_some(packet)
    }

    /// Adds one byte; `false`, and nothing added, if the packet is full.
    pub fn push(&mut self, byte: u8) -> bool {
        self.extend(&[byte])
    }

    /// Adds all of `slice`; `false`, and nothing added, if it does not fit.
    #[inline]
    pub fn extend(&mut self, slice: &[u8]) -> bool {
        let start = usize::from(self.length);
        match self.bytes.get_mut(start..start + slice.len()) {
            Some(room) => {
                room.copy_from_slice(slice);
                self.length += slice.len() as u8;
                true
            }
            None => false,
        }
    }

    /// Holds `bytes` in place of what it held.
    #[inline]
    pub const fn set<const N: usize>(&mut self, bytes: &[u8; N]) {
        const { assert!(N <= BYTES_MAX) };
        self.length = N as u8;
        self.bytes.split_at_mut(N).0.copy_from_slice(bytes);
    }

    /// The bytes.
    #[inline]
    pub fn as_slice(&self) -> &[u8] {
        &self.bytes[..usize::from(self.length)]
    }

    /// True if there are no bytes.
    pub const fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Number of bytes.
    pub const fn len(&self) -> usize {
        self.length as usize
    }
}

impl Default for Packet {
    fn default() -> Self {
        Self::new()
    }
}

impl core::fmt::Debug for Packet {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Packet(\"{}\")", self.as_slice().escape_ascii())
    }
}

impl PartialEq for Packet {
    fn eq(&self, other: &Self) -> bool {
        self.as_slice() == other.as_slice()
    }
}

impl Eq for Packet {}

impl core::fmt::Write for Packet {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        if self.extend(text.as_bytes()) { Ok(()) } else { Err(core::fmt::Error) }
    }
}

#[cfg(test)]
mod tests {
    use super::{BYTES_MAX, Packet};

    #[test]
    fn what_does_not_fit_is_refused_whole() {
        let mut packet = Packet::from_slice(&[7; BYTES_MAX - 1]).unwrap();
        assert!(!packet.extend(&[1, 2]));
        assert_eq!(packet.len(), BYTES_MAX - 1);
        assert!(packet.push(1));
        assert!(!packet.push(2));
        assert!(Packet::from_slice(&[0; BYTES_MAX + 1]).is_none());
    }
}
