//! Sending of messages on changes: detection of changes, and repetitions after a change.

use super::NEVER;
use crate::layout::{SendKind, SendRule};
use wire::time::{Span, Timestamp};

/// State of a message that is sent on changes.
#[derive(Debug, Clone)]
pub(super) struct Occasion {
    /// Next time at which its values are checked; never if they do not matter.
    pub(super) look: Timestamp,
    /// Next time at which it is sent because of a change.
    pub(super) due: Timestamp,
    /// Remaining repetitions after that.
    again: u32,
    /// Last time at which it was sent, for any reason.
    sent: Option<Timestamp>,
    /// Last checked values: a number on the wire for each relevant signal.
    seen: Vec<Option<u64>>,
}

impl Occasion {
    pub(super) const fn new() -> Self {
        Self { look: NEVER, due: NEVER, again: 0, sent: None, seen: Vec::new() }
    }

    /// Power-on, with these numbers of the signals. The initial values are not a change.
    pub(super) fn start(
        &mut self,
        rule: &SendRule,
        now: Timestamp,
        step: Span,
        seen: Vec<Option<u64>>,
    ) {
        let look = if rule.kind == SendKind::Cyclic { NEVER } else { now + step };
        *self = Self { look, seen, ..Self::new() };
    }

    /// Checks the values, at the ends of the integration steps.
    pub(super) fn look(
        &mut self,
        rule: &SendRule,
        (now, step): (Timestamp, Span),
        numbers: &mut Vec<Option<u64>>,
        is_start: impl Fn(usize, Option<u64>) -> bool,
    ) {
        if self.look <= now {
            let missed = now.since(self.look).as_nanos() / step.as_nanos().max(1) + 1;
            self.look += step * missed;
        }
        let mut changes = numbers.iter().zip(&self.seen).enumerate();
        let is_occasion = changes.any(|(signal, (number, seen))| {
            let is_event = rule.kind != SendKind::OnEvent || !is_start(signal, *number);
            rule.looks_at(signal) && number != seen && is_event
        });
        std::mem::swap(&mut self.seen, numbers);
        if is_occasion {
            let earliest = self.sent.map_or(now, |sent| now.max(sent + rule.min_delay));
            self.due = earliest;
            self.again = rule.fast.map_or(0, |(_, times)| times);
        }
    }

    /// Records that it is sent now, for any reason.
    pub(super) fn sent(&mut self, rule: &SendRule, now: Timestamp) {
        self.sent = Some(now);
        if self.due > now {
            return;
        }
        self.due = match rule.fast {
            Some((period, _)) if self.again > 0 => {
                self.again -= 1;
                now + period.max(rule.min_delay)
            }
            _ => NEVER,
        };
    }
}
