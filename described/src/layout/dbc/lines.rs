//! Line numbers of positions in a text.

use std::ops::Range;

/// The ends of all lines, found once: counting from the beginning for each of thousands of notes would be quadratic.
pub(super) struct Lines(Vec<usize>);

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(end, _)| end).collect())
    }

    /// The line on which the range starts, from 1.
    pub(super) fn number(&self, at: &Range<usize>) -> usize {
        self.0.partition_point(|end| *end < at.start) + 1
    }
}
