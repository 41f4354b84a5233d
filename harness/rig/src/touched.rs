//! Who is asked after an event, so that nobody is asked for nothing.

/// Who has been reached by an event and may have something to say, or want to be woken at another time: a bit a node, and
/// the highest for the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Touched(pub(super) u64);

impl Touched {
    pub(super) const PLAN: u64 = 1 << 63;
    pub(super) const ALL: Self = Self(u64::MAX);

    pub(super) fn node(&mut self, place: usize) {
        self.0 |= 1 << place;
    }

    /// Those of them that are of `mask`, which are touched no more.
    pub(super) fn take(&mut self, mask: u64) -> Self {
        let taken = Self(self.0 & mask);
        self.0 &= !mask;
        taken
    }

    /// The places of the nodes.
    pub(super) fn places(self) -> impl Iterator<Item = usize> {
        let mut left = self.0;
        std::iter::from_fn(move || {
            let place = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (place < 64).then_some(place)
        })
    }
}
