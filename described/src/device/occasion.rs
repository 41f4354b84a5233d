//! When a message is sent that is not only cyclic: what it looks at, and what is still to be sent after a change.

use super::NEVER;
use crate::layout::{SendKind, SendRule};
use wire::time::{Span, Timestamp};

/// What a message that is sent on changes remembers.
#[derive(Debug, Clone)]
pub(super) struct Occasion {
    /// When its values are looked at next; never where they are of no interest.
    pub(super) look: Timestamp,
    /// When it is sent next because of a change.
    pub(super) due: Timestamp,
    /// How often it is sent again after that.
    again: u32,
    /// When it was sent last, for whatever reason.
    sent: Option<Timestamp>,
    /// What was seen last: a number on the wire for each signal that counts.
    seen: Vec<Option<u64>>,
}

impl Occasion {
    pub(super) const fn new() -> Self {
        Self { look: NEVER, due: NEVER, again: 0, sent: None, seen: Vec::new() }
    }

    /// Power on, with these numbers of the signals. What they are at first is no change.
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

    /// The values are looked at, at the ends of the steps of the integration.
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

    /// It is sent now, for whatever reason.
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
