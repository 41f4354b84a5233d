//! `rises`.

use crate::stream::Stream;
use crate::truth::Truth;

/// True at the single nanosecond at which its operand is true and was not just before: false, or never known so far.
#[derive(Debug, Clone)]
pub(crate) struct Edge {
    now: Truth,
    since: i64,
    /// The last truth that was known.
    before: Truth,
    /// When the nanosecond of the last edge ends.
    over: Option<i64>,
    /// From here on the run is over: an unknown operand may have changed, as it does not by a reading of NaN.
    open_from: Option<i64>,
}

impl Edge {
    pub(crate) fn new() -> Self {
        let (now, before) = (Truth::UNKNOWN, Truth::FALSE);
        Self { now, since: i64::MIN, before, over: None, open_from: None }
    }

    /// The run ends before `end`.
    pub(crate) const fn end(&mut self, end: i64) {
        self.open_from = Some(end);
    }

    pub(crate) fn run(&mut self, input: &mut Stream, out: &mut Stream) {
        while let Some(step) = input.pop() {
            if let Some(over) = self.over.filter(|over| *over < step.at) {
                out.push(over, self.truth_at(over));
            }
            (self.now, self.since) = (step.truth, step.at);
            out.push(step.at, self.truth_at(step.at));
            if self.now.is_known() {
                self.before = self.now;
            }
            self.over = Some(step.at.saturating_add(1));
        }
        if let Some(over) = self.over.filter(|over| *over < input.known()) {
            out.push(over, self.truth_at(over));
            self.over = None;
        }
        let is_within = |from: &i64| self.since < *from && *from < input.known();
        if let Some(from) = self.open_from.filter(is_within)
            && !self.now.is_known()
        {
            self.since = from;
            out.push(from, Truth::UNKNOWN);
        }
        out.know(input.known());
    }

    fn truth_at(&self, at: i64) -> Truth {
        let is_open = !self.now.is_known() && self.open_from.is_some_and(|from| at >= from);
        if is_open { Truth::UNKNOWN } else { self.now.min(-self.before) }
    }
}
