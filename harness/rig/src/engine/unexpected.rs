//! What came on a line that is no good message of its nodes, as far as the plan judges it.

use super::Engine;
use plan::Plan;
use std::collections::BTreeMap;
use wire::time::{Span, Timestamp};

#[derive(Debug, Clone, Default)]
pub(super) struct Unexpected {
    /// By line.
    lines: BTreeMap<String, Counted>,
}

#[derive(Debug, Clone, Default)]
struct Counted {
    quantity: String,
    count: u64,
    /// When a log has frames that no node sends.
    left_out: Vec<Span>,
}

impl Unexpected {
    pub(super) fn of(plan: &Plan) -> Self {
        let quantities = plan.measurements.iter().map(|declared| &declared.quantity);
        let counted = quantities.filter_map(|quantity| {
            let quantity_name = quantity.as_str().to_owned();
            Some((
                quantity.line()?.to_owned(),
                Counted { quantity: quantity_name, ..<_>::default() },
            ))
        });
        Self { lines: counted.collect() }
    }

    /// The quantities, and how much came until then.
    pub(super) fn until(&self, end: Span) -> Vec<(String, f64)> {
        let of = |one: &Counted| {
            let left_out = one.left_out.iter().filter(|at| **at <= end).count() as u64;
            (one.quantity.clone(), (one.count + left_out) as f64)
        };
        self.lines.values().map(of).collect()
    }
}

impl Engine {
    /// Takes that so much came on a line which is no good message of its nodes.
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

    pub(super) fn unexpected_until(&self, now: Timestamp) -> Vec<(String, f64)> {
        self.unexpected.until(now - self.began)
    }
}
