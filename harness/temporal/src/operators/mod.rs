//! Operators: each computes a stream from its operands' streams, as far as those are known.
//!
//! Time is in whole nanoseconds, each of which is one moment. Windows are closed at both ends.

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

/// The window of an operator, `from` to `to` nanoseconds from the current moment; negative is the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Reach {
    /// `None` is the start of the run.
    pub(crate) from: Option<i64>,
    pub(crate) to: i64,
}

impl Reach {
    /// The moment from which a step that begins at `start` is in the window.
    fn enters(self, start: i64) -> i64 {
        start.saturating_sub(self.to)
    }

    /// The moment from which a step that ends at `end` has left the window.
    fn leaves(self, end: i64) -> Option<i64> {
        self.from.map(|from| end.saturating_sub(from))
    }

    /// The moment until which the result is known if the operands are known until `known`. Moments that the operands
    /// have not reached are never known, even where the distant past would already decide.
    fn known(self, known: i64) -> i64 {
        if known == i64::MAX { known } else { known.saturating_sub(self.to.max(0)) }
    }
}
