//! The ends of a line by their place on it.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EndId(pub u8);

impl EndId {
    /// A node that a fault put on the bus.
    pub(crate) const STRANGER: Self = Self(u8::MAX);

    pub fn of(place: usize) -> Self {
        Self(u8::try_from(place).unwrap_or(u8::MAX))
    }

    pub const fn place(self) -> usize {
        self.0 as usize
    }
}
