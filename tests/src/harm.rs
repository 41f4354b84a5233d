//! Damage to a packet in transit.

/// Kind of damage.
#[derive(Debug, Clone)]
pub enum Harm {
    /// The packet does not arrive.
    Drop,
    /// Only this number of its bytes arrives.
    Cut(usize),
    /// The byte at this index arrives changed.
    Change(usize, u8),
    /// These bytes arrive instead.
    Replace(Vec<u8>),
    /// These bytes arrive before it.
    Before(Vec<u8>),
    /// These bytes arrive after it.
    Behind(Vec<u8>),
}

impl Harm {
    /// Returns what arrives in place of `bytes`; for a change, `bytes` must not be empty.
    pub fn done_to(&self, bytes: &[u8]) -> Vec<u8> {
        match self {
            Self::Drop => Vec::new(),
            Self::Cut(length) => bytes[..length % bytes.len()].to_vec(),
            Self::Change(index, change) => {
                let mut bytes = bytes.to_vec();
                let index = index % bytes.len();
                bytes[index] ^= (*change).max(1);
                bytes
            }
            Self::Replace(other) => other.clone(),
            Self::Before(other) => [other, bytes].concat(),
            Self::Behind(other) => [bytes, other].concat(),
        }
    }

    /// Whether the packet itself is lost.
    pub const fn takes_it(&self) -> bool {
        !matches!(self, Self::Before(_) | Self::Behind(_))
    }
}
