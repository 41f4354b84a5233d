//! Evaluates a formula over time as its signals become known.

use crate::formula::{Condition, Formula, Used};
use crate::history::History;
use crate::network::Network;
use crate::truth::Truth;
use wire::time::{Span, Timestamp};

/// Upper limit of time, 146 years, so that no sum of times overflows.
const TIME_MAX: i64 = i64::MAX / 2;

/// Evaluates a formula while its signals change and gives its truth at every moment as soon as that is final.
///
/// A signal keeps its value until the next update. Of several values at one moment the last counts. The evaluator
/// stores the changes within the formula's horizon and windows.
#[derive(Debug, Clone)]
pub struct Evaluator {
    network: Network,
    /// Per signal, sorted by number: the caller's number and the slot.
    slots: Vec<(usize, usize)>,
    values: Vec<f64>,
    /// All verdicts before this moment have been given; `values` hold from it on.
    now: i64,
    start: Option<i64>,
    /// End of the last stretch taken; `truth` holds from there.
    taken: i64,
    truth: Truth,
    /// The last moment of the run.
    end: Option<i64>,
    pub(crate) history: Option<History>,
    horizon: i64,
}

/// A stretch of consecutive moments at which a formula has the same truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// The first moment.
    pub from: Timestamp,
    /// The moment after the last.
    pub to: Timestamp,
    pub truth: Truth,
}

impl Stretch {
    /// Its length. A single moment lasts one nanosecond.
    pub fn length(self) -> Span {
        self.to - self.from
    }

    /// The rest of it from `to` on.
    pub(crate) fn behind(self, to: Timestamp) -> Option<Self> {
        (to < self.to).then_some(Self { from: to, ..self })
    }
}

impl Evaluator {
    /// An evaluator of `formula`, starting with the first update. No signal has a value yet.
    pub fn new(formula: &Formula) -> Self {
        Self::of(&formula.condition, formula)
    }

    /// An evaluator of a condition over the signals of `formula`.
    pub(crate) fn of(condition: &Condition, formula: &Formula) -> Self {
        let mut slots: Vec<_> =
            formula.signals.iter().enumerate().map(|(slot, used)| (used.index, slot)).collect();
        slots.sort_unstable();
        Self {
            network: Network::new(condition),
            values: formula.signals.iter().map(Used::before).collect(),
            slots,
            now: 0,
            start: None,
            taken: 0,
            truth: Truth::UNKNOWN,
            end: None,
            history: None,
            horizon: condition.horizon(),
        }
    }

    /// Sets new values of signals at `time`, all at once: pairs of the caller's number and the value. NaN means no
    /// value. Signals that the formula does not read are ignored. A time before the last one counts as the last one.
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

    /// Advances to `time`; nothing has changed since the last update.
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

    /// Ends the run at `time`; no signal has a value after it.
    pub fn finish(&mut self, time: Timestamp) {
        if self.end.is_some() {
            return;
        }
        self.advance(time);
        self.run(self.now + 1);
        self.end = Some(self.now);
        self.now += 1;
        self.network.end(self.now);
        self.values.fill(f64::NAN);
        self.run(i64::MAX);
    }

    /// The next moments whose truth is final, in order. Consecutive stretches may have the same truth.
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

    /// The last moment of the run, once it has ended.
    pub fn end(&self) -> Option<Timestamp> {
        self.end.map(Timestamp::from_nanos)
    }

    /// The delay after which the truth of a moment is final.
    pub fn horizon(&self) -> Span {
        Span::from_nanos(self.horizon)
    }

    /// The distance of the deciding comparison from changing, in its unit.
    pub(crate) fn distance(&self, truth: Truth) -> Option<f64> {
        self.network.distance(truth)
    }

    /// That unit, by its index among those of the formula.
    pub(crate) fn unit(&self, truth: Truth) -> Option<usize> {
        self.network.unit(truth)
    }

    pub(crate) fn reads(&self, values: &[(usize, f64)]) -> bool {
        values.iter().any(|(index, _)| self.slot(*index).is_some())
    }

    /// The present value of a signal by the caller's number, NaN before the first; `None` if the formula does not read it.
    pub(crate) fn value(&self, index: usize) -> Option<f64> {
        self.slot(index).map(|slot| self.values[slot])
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
