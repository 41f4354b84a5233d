//! The outputs of a recorded run beside those of its rerun, and the first difference.

use record::{Record, RecordKind};
use std::collections::VecDeque;
use wire::can::Id;
use wire::time::{Span, Timestamp};

/// On a bus of the run a frame waits for those of others; here the device is alone. Assumption: longer than a burst of
/// ten frames at 125 kbit/s takes.
pub(super) const BUS_APART_MAX: Span = Span::from_millis(20);
/// An output that the other side has not sent after this long is a difference.
const AWAITED: Span = Span::from_secs(1);

/// What a record knows of the moments of its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Virtual time: the nanosecond of every output.
    Virtual,
    /// Real time: when an output was heard, in the pieces in which it came, after a start that took its time. Only contents
    /// and order can be compared.
    Real,
}

/// The first difference: `None` for a side that sent nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The record's.
    pub recorded: Option<Record>,
    pub now: Option<Record>,
}

impl Difference {
    /// What was sent, on one side or both.
    pub(super) fn sides(&self) -> impl Iterator<Item = &Record> {
        self.recorded.iter().chain(&self.now)
    }
}

/// Outputs, or reports, that the other side has not produced yet.
#[derive(Debug)]
pub(super) struct Pairs {
    clock: Clock,
    pub(super) recorded: VecDeque<Record>,
    pub(super) now: VecDeque<Record>,
    /// Time between the first output and its copy: by so much one side has more at the end of a run in real time.
    apart: Option<Span>,
}

impl Pairs {
    pub(super) const fn new(clock: Clock) -> Self {
        Self { clock, recorded: VecDeque::new(), now: VecDeque::new(), apart: None }
    }

    /// The first difference that is certain at `at`; `is_over` when neither side will send any more.
    pub(super) fn difference(&mut self, at: Timestamp, is_over: bool) -> Option<Difference> {
        loop {
            if self.clock == Clock::Real {
                self.match_bytes();
            }
            let (recorded, now) = (self.recorded.front(), self.now.front());
            match (recorded, now) {
                (Some(recorded), Some(now)) if is_same(recorded, now, self.clock) => {
                    let apart = recorded.at.max(now.at) - recorded.at.min(now.at);
                    self.apart.get_or_insert(apart);
                    self.recorded.pop_front();
                    self.now.pop_front();
                }
                (None, None) => return None,
                (Some(one), None) | (None, Some(one)) if !self.is_late(one, at, is_over) => {
                    return None;
                }
                (recorded, now) => {
                    return Some(Difference { recorded: recorded.cloned(), now: now.cloned() });
                }
            }
        }
    }

    /// Whether the other side should have sent this one by `at`.
    fn is_late(&self, record: &Record, at: Timestamp, is_over: bool) -> bool {
        match self.clock {
            Clock::Virtual => at - record.at > AWAITED,
            // Its pace is known at the end.
            Clock::Real => is_over && at - record.at > AWAITED + self.apart.unwrap_or(Span::ZERO),
        }
    }

    /// Takes away the bytes that both sides have sent, in whatever pieces; what is left of each stays.
    fn match_bytes(&mut self) {
        while let (Some(recorded), Some(now)) = (self.recorded.front_mut(), self.now.front_mut()) {
            let (device, apart) =
                (recorded.device, recorded.at.max(now.at) - recorded.at.min(now.at));
            let (RecordKind::Bytes(one), RecordKind::Bytes(other)) =
                (&mut recorded.kind, &mut now.kind)
            else {
                return;
            };
            let both = one.len().min(other.len());
            if device != now.device || one[..both] != other[..both] {
                return;
            }
            self.apart.get_or_insert(apart);
            one.drain(..both);
            other.drain(..both);
            let (is_used, is_said) = (one.is_empty(), other.is_empty());
            if is_used {
                self.recorded.pop_front();
            }
            if is_said {
                self.now.pop_front();
            }
        }
    }
}

/// The identifier of a frame; `None` for bytes.
pub(super) const fn identifier(record: &Record) -> Option<Id> {
    match &record.kind {
        RecordKind::Frame(frame) => Some(frame.id()),
        _ => None,
    }
}

fn is_same(recorded: &Record, now: &Record, clock: Clock) -> bool {
    let apart = recorded.at.max(now.at) - recorded.at.min(now.at);
    let in_time = match (clock, &now.kind) {
        (Clock::Real, _) => true,
        (Clock::Virtual, RecordKind::Frame(_)) => apart <= BUS_APART_MAX,
        (Clock::Virtual, _) => apart == Span::ZERO,
    };
    in_time && recorded.device == now.device && recorded.kind == now.kind
}

#[cfg(test)]
mod tests {
    use super::{Clock, Pairs, Record, RecordKind, Span, Timestamp};
    use record::Device;

    fn at(ms: i64) -> Timestamp {
        Timestamp::ZERO + Span::from_millis(ms)
    }

    fn said(ms: i64, bytes: &[u8]) -> Record {
        Record { at: at(ms), device: Device::Controller, kind: RecordKind::Bytes(bytes.to_vec()) }
    }

    /// Both sides; the recorded one began 60 ms later and was heard in other pieces.
    fn pairs(clock: Clock, last: &[u8]) -> Pairs {
        let mut pairs = Pairs::new(clock);
        pairs.recorded.extend([said(60, b"ab"), said(61, b"cde"), said(5_060, last)]);
        pairs.now.extend([said(0, b"abc"), said(0, b"de"), said(5_000, b"fg"), said(9_980, b"hi")]);
        pairs
    }

    #[test]
    fn a_run_in_real_time_is_compared_by_what_was_said() {
        let over = at(10_000);
        assert_eq!(pairs(Clock::Real, b"fg").difference(over, true), None);
        let difference = pairs(Clock::Real, b"fx").difference(over, true).unwrap();
        assert_eq!(difference.recorded, Some(said(5_060, b"fx")));
        assert_eq!(difference.now, Some(said(5_000, b"fg")));
        let virtual_time = pairs(Clock::Virtual, b"fg").difference(over, true).unwrap();
        assert_eq!(virtual_time.recorded, Some(said(60, b"ab")));
    }

    #[test]
    fn one_that_says_nothing_or_no_more_is_told_in_real_time() {
        let mut silent = Pairs::new(Clock::Real);
        silent.recorded.extend([said(60, b"ab")]);
        assert_eq!(silent.difference(at(5_000), false), None, "it may start slowly");
        assert_eq!(silent.difference(at(5_000), true).unwrap().now, None);
        let mut stopped = Pairs::new(Clock::Real);
        stopped.recorded.extend([said(60, b"ab"), said(1_060, b"cd")]);
        stopped.now.extend([said(0, b"ab")]);
        assert_eq!(stopped.difference(at(2_000), true), None);
        let difference = stopped.difference(at(5_000), true).unwrap();
        assert_eq!((difference.recorded, difference.now), (Some(said(1_060, b"cd")), None));
    }
}
