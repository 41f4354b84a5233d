//! What can happen to a packet on its way.

/// What happens to a packet.
#[derive(Debug, Clone)]
pub enum Harm {
    /// It does not arrive.
    Drop,
    /// Only so many bytes of it arrive.
    Cut(usize),
    /// This byte of it arrives as another.
    Change(usize, u8),
    /// These bytes arrive in its place.
    Replace(Vec<u8>),
    /// These bytes arrive before it.
    Before(Vec<u8>),
    /// These bytes arrive behind it.
    Behind(Vec<u8>),
}

impl Harm {
    /// What arrives in place of `bytes`, of which there is at least one where one is to change.
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

    /// The packet itself is not there any more.
    pub const fn takes_it(&self) -> bool {
        !matches!(self, Self::Before(_) | Self::Behind(_))
    }
}
