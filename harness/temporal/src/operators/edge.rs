//! `rises`.

use crate::stream::Stream;
use crate::truth::Truth;

/// True at the single nanosecond at which its operand is true and was false just before.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    last: Truth,
    /// When the nanosecond of the last edge ends.
    over: Option<i64>,
}

impl Edge {
    pub(crate) fn new() -> Self {
        Self { last: Truth::UNKNOWN, over: None }
    }

    pub(crate) fn run(&mut self, input: &mut Stream, out: &mut Stream) {
        while let Some(step) = input.pop() {
            if let Some(over) = self.over.filter(|over| *over < step.at) {
                out.push(over, steady(self.last));
            }
            out.push(step.at, step.truth.min(-self.last));
            self.last = step.truth;
            self.over = Some(step.at.saturating_add(1));
        }
        if let Some(over) = self.over.filter(|over| *over < input.known()) {
            out.push(over, steady(self.last));
            self.over = None;
        }
        out.know(input.known());
    }
}

/// The truth of "true now and false before" while the operand does not change.
fn steady(truth: Truth) -> Truth {
    truth.min(-truth)
}
