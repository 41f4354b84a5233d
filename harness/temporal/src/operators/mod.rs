//! Operators: each makes a stream of its operands' streams, as far as those are known.
//!
//! Time is in whole nanoseconds, and every moment is one of them. A window is closed at both ends.

mod edge;
mod fold;
mod join;
mod until;
mod window;

pub(crate) use edge::Edge;
pub(crate) use fold::Fold;
pub(crate) use join::Join;
pub(crate) use until::Until;
pub(crate) use window::Window;

/// The moments from `from` to `to` nanoseconds away that an operator looks at; negative is the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reach {
    /// `None` is the start of the run.
    pub(crate) from: Option<i64>,
    pub(crate) to: i64,
}

impl Reach {
    /// From when on a step that begins at `start` is within reach.
    fn enters(self, start: i64) -> i64 {
        start.saturating_sub(self.to)
    }

    /// From when on a step that ends at `end` is out of reach.
    fn leaves(self, end: i64) -> Option<i64> {
        self.from.map(|from| end.saturating_sub(from))
    }

    /// Until when the result is known, if the operands are known until `known`. Nothing is said of moments
    /// that the operands have not seen, though the distant past may already tell.
    fn known(self, known: i64) -> i64 {
        if known == i64::MAX { known } else { known.saturating_sub(self.to.max(0)) }
    }
}
