//! Consecutive slots as an array: `cell[3]`, `max(cell)`.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Array {
    /// The slot of the first element.
    pub(crate) slot: u32,
    /// Number of elements; at least one.
    pub(crate) count: u32,
    /// The index of the first element.
    pub(crate) first: u32,
}

impl Array {
    /// The slots, in order of the indices.
    pub(crate) const fn slots(self) -> std::ops::Range<usize> {
        self.slot as usize..(self.slot + self.count) as usize
    }

    /// The index of the last element.
    pub(crate) const fn last(self) -> u32 {
        self.first + self.count - 1
    }

    /// The slot of an index; `None` if there is no such element.
    pub(crate) fn at(self, index: f64) -> Option<usize> {
        let is_one = index >= f64::from(self.first) && index <= f64::from(self.last());
        // Doubles represent whole numbers of 32 bits exactly.
        let whole = is_one.then_some(index as u32).filter(|whole| f64::from(*whole) == index)?;
        Some((self.slot + (whole - self.first)) as usize)
    }

    /// The element; NaN for an invalid index.
    pub(super) fn element(self, index: f64, variables: &[f64]) -> f64 {
        let slot = self.at(index);
        slot.and_then(|slot| variables.get(slot)).copied().unwrap_or(f64::NAN)
    }
}
