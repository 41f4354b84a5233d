//! The status of a diagnostic trouble code (ISO 14229-1, D.2).

use wire::time::{Span, Timestamp};

const TEST_FAILED: u8 = 0x01;
const FAILED_THIS_CYCLE: u8 = 0x02;
const PENDING: u8 = 0x04;
const CONFIRMED: u8 = 0x08;
const NOT_COMPLETED_SINCE_CLEAR: u8 = 0x10;
const FAILED_SINCE_CLEAR: u8 = 0x20;
const NOT_COMPLETED_THIS_CYCLE: u8 = 0x40;
pub(crate) const WARNING: u8 = 0x80;

#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    status: u8,
    failing_since: Option<Timestamp>,
}

impl Monitor {
    pub(crate) const fn new() -> Self {
        let status = NOT_COMPLETED_SINCE_CLEAR | NOT_COMPLETED_THIS_CYCLE;
        Self { status, failing_since: None }
    }

    pub(crate) const fn status(&self) -> u8 {
        self.status
    }

    /// Tests the condition. One failure confirms the code.
    pub(crate) fn test(&mut self, now: Timestamp, fails: bool, debounce: Span, warning: bool) {
        if !fails {
            self.failing_since = None;
            self.status &= !(TEST_FAILED | NOT_COMPLETED_SINCE_CLEAR | NOT_COMPLETED_THIS_CYCLE);
            return;
        }
        let since = *self.failing_since.get_or_insert(now);
        if now.since(since) >= debounce {
            self.status &= !(NOT_COMPLETED_SINCE_CLEAR | NOT_COMPLETED_THIS_CYCLE);
            self.status |=
                TEST_FAILED | FAILED_THIS_CYCLE | PENDING | CONFIRMED | FAILED_SINCE_CLEAR;
            self.status |= if warning { WARNING } else { 0 };
        }
    }

    /// A new operation cycle begins: power-on or reset. A code that did not fail in the last one is no longer pending.
    pub(crate) const fn next_cycle(&mut self) {
        if self.status & (FAILED_THIS_CYCLE | NOT_COMPLETED_THIS_CYCLE) == 0 {
            self.status &= !PENDING;
        }
        self.status = self.status & !(FAILED_THIS_CYCLE | TEST_FAILED) | NOT_COMPLETED_THIS_CYCLE;
        self.failing_since = None;
    }

    pub(crate) const fn clear(&mut self) {
        *self = Self::new();
    }
}
