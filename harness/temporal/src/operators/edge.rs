//! `rises`.

use crate::stream::Stream;
use crate::truth::Truth;

/// True at the single nanosecond at which its operand is true and was not just before: false, or never known so far.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    now: Truth,
    /// The last truth that was known.
    before: Truth,
    /// When the nanosecond of the last edge ends.
    over: Option<i64>,
}

impl Edge {
    pub(crate) fn new() -> Self {
        Self { now: Truth::UNKNOWN, before: Truth::FALSE, over: None }
    }

    pub(crate) fn run(&mut self, input: &mut Stream, out: &mut Stream) {
        while let Some(step) = input.pop() {
            if let Some(over) = self.over.filter(|over| *over < step.at) {
                out.push(over, self.truth());
            }
            self.now = step.truth;
            out.push(step.at, self.truth());
            if self.now.is_known() {
                self.before = self.now;
            }
            self.over = Some(step.at.saturating_add(1));
        }
        if let Some(over) = self.over.filter(|over| *over < input.known()) {
            out.push(over, self.truth());
            self.over = None;
        }
        out.know(input.known());
    }

    fn truth(&self) -> Truth {
        self.now.min(-self.before)
    }
}
