//! `and` and `or`.

use crate::stream::Stream;
use crate::truth::Truth;

/// The minimum or maximum of two streams at every moment.
#[derive(Debug, Clone)]
pub(crate) struct Join {
    is_and: bool,
    left: Truth,
    right: Truth,
}

impl Join {
    pub(crate) fn and() -> Self {
        Self { is_and: true, left: Truth::UNKNOWN, right: Truth::UNKNOWN }
    }

    pub(crate) fn or() -> Self {
        Self { is_and: false, ..Self::and() }
    }

    pub(crate) fn run(&mut self, left: &mut Stream, right: &mut Stream, out: &mut Stream) {
        let known = left.known().min(right.known());
        loop {
            let next = earlier(left.next_at(), right.next_at());
            let Some(next) = next.filter(|at| *at < known) else { break };
            self.left = left.pop_at(next).unwrap_or(self.left);
            self.right = right.pop_at(next).unwrap_or(self.right);
            let (left, right) = (self.left, self.right);
            out.push(next, if self.is_and { left.min(right) } else { left.max(right) });
        }
        out.know(known);
    }
}

/// The earlier of two optional moments.
pub(super) fn earlier(a: Option<i64>, b: Option<i64>) -> Option<i64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
