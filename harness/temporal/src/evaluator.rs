//! A formula over time, as it becomes known.

use crate::formula::Formula;
use crate::history::History;
use crate::network::Network;
use crate::truth::Truth;
use wire::time::{Span, Timestamp};

/// Beyond it nothing happens, and no sum of times overflows: 146 years.
const TIME_MAX: i64 = i64::MAX / 2;

/// Evaluates a formula while its signals change: what it is at every moment, as soon as that is final.
///
/// A signal keeps its value until the next update. Of several values at one moment the last counts. Its
/// memory is what changed within the formula's horizon and windows.
#[derive(Debug, Clone)]
pub struct Evaluator {
    network: Network,
    /// The caller's number and the slot of each signal, by number.
    slots: Vec<(usize, usize)>,
    values: Vec<f64>,
    /// All verdicts before this moment are given; `values` hold from it on.
    now: i64,
    start: Option<i64>,
    /// What was taken last: until when, and what it is from there.
    taken: i64,
    truth: Truth,
    /// The last moment of the run.
    end: Option<i64>,
    pub(crate) history: Option<History>,
    horizon: i64,
}

/// Moments, one behind the other, at which a formula is the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The first of them.
    pub from: Timestamp,
    /// The one behind the last of them.
    pub to: Timestamp,
    /// What the formula is.
    pub truth: Truth,
}

impl Stretch {
    /// How long it is. A single moment is one nanosecond.
    pub fn length(self) -> Span {
        self.to - self.from
    }
}

impl Evaluator {
    /// Evaluates `formula` from the first update on. No signal has a value yet.
    pub fn new(formula: &Formula) -> Self {
        let mut slots: Vec<_> =
            formula.signals.iter().enumerate().map(|(slot, used)| (used.index, slot)).collect();
        slots.sort_unstable();
        Self {
            network: Network::new(&formula.condition),
            values: vec![f64::NAN; slots.len()],
            slots,
            now: 0,
            start: None,
            taken: 0,
            truth: Truth::UNKNOWN,
            end: None,
            history: None,
            horizon: formula.horizon().as_nanos(),
        }
    }

    /// Signals have new values at `time`, all at once: the caller's number of each, and its value, where not
    /// a number is no value. Signals that the formula does not read are passed over. A time before the last
    /// one counts as the last one.
    pub fn update(&mut self, time: Timestamp, values: &[(usize, f64)]) {
        if self.end.is_some() || !self.reads(values) {
            return;
        }
        self.advance(time);
        for (index, value) in values {
            if let Some(slot) = self.slot(*index) {
                self.values[slot] = *value;
            }
        }
    }

    /// It is `time`, and nothing has changed since the last update.
    pub fn advance(&mut self, time: Timestamp) {
        if self.end.is_some() {
            return;
        }
        let time = time.as_nanos().clamp(-TIME_MAX, TIME_MAX);
        if self.start.is_none() {
            (self.start, self.now, self.taken) = (Some(time), time, time);
            self.network.start(time);
        }
        if time > self.now {
            self.run(time);
            self.now = time;
        }
    }

    /// The run ends at `time`, and no signal has a value thereafter.
    pub fn finish(&mut self, time: Timestamp) {
        if self.end.is_some() {
            return;
        }
        self.advance(time);
        self.run(self.now + 1);
        self.end = Some(self.now);
        self.now += 1;
        self.values.fill(f64::NAN);
        self.run(i64::MAX);
    }

    /// The next moments whose truth is final, in their order. Stretches in a row may have the same truth.
    pub fn take(&mut self) -> Option<Stretch> {
        let start = self.start?;
        let end = self.end.map_or(self.now, |end| end + 1);
        loop {
            let root = self.network.root();
            let known = root.known().min(end);
            let next = root.next_at().filter(|at| *at < known);
            let (from, truth) = (self.taken, self.truth);
            if let Some(step) = next.and_then(|_| root.pop()) {
                self.taken = self.taken.max(step.at);
                self.truth = step.truth;
            } else {
                self.taken = self.taken.max(known);
            }
            if self.taken > from && from >= start {
                let (from, to) = (Timestamp::from_nanos(from), Timestamp::from_nanos(self.taken));
                return Some(Stretch { from, to, truth });
            }
            next?;
        }
    }

    /// The last moment of the run, once it is over.
    pub fn end(&self) -> Option<Timestamp> {
        self.end.map(Timestamp::from_nanos)
    }

    /// How long after a moment its truth is final.
    pub fn horizon(&self) -> Span {
        Span::from_nanos(self.horizon)
    }

    /// How far the comparison that decides is from changing, in its unit.
    pub(crate) fn distance(&self, truth: Truth) -> Option<f64> {
        self.network.distance(truth)
    }

    /// Whether the formula reads any of these signals.
    pub(crate) fn reads(&self, values: &[(usize, f64)]) -> bool {
        values.iter().any(|(index, _)| self.slot(*index).is_some())
    }

    fn slot(&self, index: usize) -> Option<usize> {
        let found = self.slots.binary_search_by_key(&index, |(index, _)| *index).ok()?;
        Some(self.slots[found].1)
    }

    fn run(&mut self, to: i64) {
        if let (Some(history), None) = (&mut self.history, self.end) {
            history.push(self.now, &self.values);
        }
        self.network.run(&self.values, self.now, to);
    }
}
