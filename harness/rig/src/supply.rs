//! The supply of a node: a plan may switch it off for a time, and faults may cut it meanwhile.

use wire::time::Timestamp;

/// Whether a node has its supply.
#[derive(Debug, Clone)]
pub(super) struct Supply {
    /// How many faults and switches cut it at the moment.
    cuts: usize,
    /// When the plan switches it on again.
    pub(super) on_at: Timestamp,
}

impl Default for Supply {
    fn default() -> Self {
        Self { cuts: 0, on_at: Timestamp::MAX }
    }
}

impl Supply {
    pub(super) const fn is_off(&self) -> bool {
        self.cuts > 0
    }

    /// Cuts it once more, or undoes one cut; returns whether that changed anything.
    pub(super) const fn switch(&mut self, on: bool) -> bool {
        let was_off = self.is_off();
        self.cuts = if on { self.cuts.saturating_sub(1) } else { self.cuts + 1 };
        self.is_off() != was_off
    }
}
