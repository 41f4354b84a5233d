//! What came on a line and is not a valid message of its nodes, as far as the plan judges it.

use super::Engine;
use plan::Plan;
use plan::quantities::UNEXPECTED_PREFIX;
use std::collections::BTreeMap;
use wire::time::{Span, Timestamp};

#[derive(Debug, Clone, Default)]
pub(super) struct Unexpected {
    /// By line.
    lines: BTreeMap<String, Counted>,
}

#[derive(Debug, Clone, Default)]
struct Counted {
    count: u64,
    /// When a log has frames that no node sends.
    left_out: Vec<Span>,
}

impl Unexpected {
    pub(super) fn of(plan: &Plan) -> Self {
        let lines = plan.measurements.iter().filter_map(|declared| declared.quantity.line());
        Self { lines: lines.map(|line| (line.to_owned(), Counted::default())).collect() }
    }
}

impl Engine {
    /// Counts what came on a line and is not a valid message of its nodes.
    pub fn unexpected(&mut self, line: &str, count: u64) {
        if count > 0
            && self.ending.is_none()
            && let Some(counted) = self.unexpected.lines.get_mut(line)
        {
            counted.count += count;
        }
    }

    /// Takes the times of frames that a log has on these lines and no node sends.
    pub fn left_out(&mut self, frames: &BTreeMap<String, Vec<Span>>) {
        for (line, times) in frames {
            if let Some(counted) = self.unexpected.lines.get_mut(line) {
                counted.left_out.clone_from(times);
            }
        }
    }

    /// The quantities, and how much came until now.
    pub(super) fn unexpected_until(&self, now: Timestamp) -> Vec<(String, f64)> {
        let end = now - self.began;
        let of = |(line, one): (&String, &Counted)| {
            let left_out = one.left_out.iter().filter(|at| **at <= end).count() as u64;
            (format!("{UNEXPECTED_PREFIX}{line}"), (one.count + left_out) as f64)
        };
        self.unexpected.lines.iter().map(of).collect()
    }
}
