//! `until` and `since` in a sliding window that begins at the current moment.

use super::Reach;
use super::join::earlier;
use crate::stream::Stream;
use crate::truth::Truth;

/// Summary of a stretch of time for `held until met` or `held since met`.
#[derive(Debug, Clone, Copy)]
struct Summary {
    /// Whether `held` is true throughout.
    held: Truth,
    /// The operator's truth within this stretch alone.
    met: Truth,
}

/// Joining stretches is associative, so two stacks suffice for a sliding window; each step is pushed twice and joined
/// twice (K. Tangwongsan, M. Hirzel, S. Schneider, "Low-latency sliding-window aggregation in worst-case constant
/// time", 2017, section 2, after a folklore queue).
#[derive(Debug, Clone)]
pub(crate) struct Fold {
    reach: Reach,
    is_past: bool,
    held: Truth,
    met: Truth,
    begun: bool,
    /// The older stretches, the oldest last, each joined with all newer ones in this stack.
    older: Vec<Stretch>,
    /// The newer stretches, the newest last, not joined.
    newer: Vec<Stretch>,
    /// The join of all of `newer`.
    joined: Summary,
}

#[derive(Debug, Clone, Copy)]
struct Stretch {
    summary: Summary,
    /// When the next stretch began.
    end: Option<i64>,
}

const NOTHING: Summary = Summary { held: Truth::TRUE, met: Truth::FALSE };

impl Fold {
    /// `held until met`, where `met` is at most `within` ahead.
    pub(crate) fn until(within: i64) -> Self {
        let reach = Reach { from: Some(0), to: within };
        let mut fold = Self::new(reach, false);
        fold.enter(i64::MIN);
        fold
    }

    /// `held since met`, where `met` is at most `within` ago. The run begins when `met` is first known.
    pub(crate) fn since(within: Option<i64>) -> Self {
        Self::new(Reach { from: within.map(|within| -within), to: 0 }, true)
    }

    fn new(reach: Reach, is_past: bool) -> Self {
        Self {
            reach,
            is_past,
            held: Truth::UNKNOWN,
            met: Truth::UNKNOWN,
            begun: !is_past,
            older: Vec::new(),
            newer: Vec::new(),
            joined: NOTHING,
        }
    }

    pub(crate) fn run(&mut self, held: &mut Stream, met: &mut Stream, out: &mut Stream) {
        let inputs_known = held.known().min(met.known());
        let known = self.reach.known(inputs_known);
        loop {
            let step = earlier(held.next_at(), met.next_at()).filter(|at| *at < inputs_known);
            let enter = step.map(|at| self.reach.enters(at));
            let next = earlier(enter, self.leave());
            let Some(next) = next.filter(|at| *at < known) else { break };
            if let (true, Some(at)) = (enter == Some(next), step) {
                self.held = held.pop_at(at).unwrap_or(self.held);
                self.met = met.pop_at(at).unwrap_or(self.met);
                self.begun |= self.met.is_known();
                if !self.begun {
                    continue;
                }
                self.enter(at);
            }
            while self.leave().is_some_and(|at| at <= next) {
                self.older.pop();
            }
            out.push(next, self.whole().met);
        }
        out.know(known);
    }

    fn enter(&mut self, at: i64) {
        let summary = Summary { held: self.held, met: self.met };
        if self.reach.from.is_some() {
            let newest =
                if self.newer.is_empty() { self.older.first_mut() } else { self.newer.last_mut() };
            if let Some(newest) = newest {
                newest.end = Some(at);
            }
            self.newer.push(Stretch { summary, end: None });
        }
        self.joined = self.join(self.joined, summary);
    }

    /// When the oldest stretch leaves the window, if known. Moves the oldest to where it can be removed.
    fn leave(&mut self) -> Option<i64> {
        if self.older.is_empty() {
            let mut joined = NOTHING;
            while let Some(stretch) = self.newer.pop() {
                joined = self.join(stretch.summary, joined);
                self.older.push(Stretch { summary: joined, end: stretch.end });
            }
            if !self.older.is_empty() {
                self.joined = NOTHING;
            }
        }
        self.older.last()?.end.and_then(|end| self.reach.leaves(end))
    }

    fn whole(&self) -> Summary {
        self.older.last().map_or(self.joined, |oldest| self.join(oldest.summary, self.joined))
    }

    fn join(&self, earlier: Summary, later: Summary) -> Summary {
        let met = if self.is_past {
            later.met.max(earlier.met.min(later.held))
        } else {
            earlier.met.max(earlier.held.min(later.met))
        };
        Summary { held: earlier.held.min(later.held), met }
    }
}
