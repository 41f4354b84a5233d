//! Which nodes to query after an event, so that no node is queried in vain.

/// Nodes that an event has reached, which may have an output or a new wake-up time: one bit per node, and the highest
/// for the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Touched(pub(super) u64);

impl Touched {
    pub(super) const PLAN: u64 = 1 << 63;
    pub(super) const ALL: Self = Self(u64::MAX);

    pub(super) fn node(&mut self, place: usize) {
        self.0 |= 1 << place;
    }

    /// Takes those of `mask` and clears them.
    pub(super) fn take(&mut self, mask: u64) -> Self {
        let taken = Self(self.0 & mask);
        self.0 &= !mask;
        taken
    }

    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let place = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (place < 64).then_some(place)
        })
    }
}
