//! `eventually`, `always`, `once`, `historically`: maximum or minimum over a sliding window.

use super::Reach;
use super::join::earlier;
use crate::stream::Stream;
use crate::truth::Truth;
use std::collections::VecDeque;

/// The maximum over the window. With inverted operands and result it is the minimum.
///
/// A queue keeps the candidates for the maximum, as in D. Lemire, "Streaming maximum-minimum filter using no more than
/// three comparisons per element" (2006): a step followed by a greater one is no candidate. Every step enters and
/// leaves once.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    reach: Reach,
    is_least: bool,
    /// In decreasing order; the newest is always the last.
    candidates: VecDeque<Candidate>,
    begun: bool,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    truth: Truth,
    /// When the next step began.
    end: Option<i64>,
}

impl Window {
    /// `is_least` for "every moment", otherwise "some moment". With `clips` the run begins when the operand is first
    /// known: earlier moments do not exist. Without it they are unknown.
    pub(crate) fn new(reach: Reach, is_least: bool, clips: bool) -> Self {
        let mut candidates = VecDeque::new();
        if !clips {
            candidates.push_back(Candidate { truth: Truth::UNKNOWN, end: None });
        }
        Self { reach, is_least, candidates, begun: !clips }
    }

    pub(crate) fn run(&mut self, input: &mut Stream, out: &mut Stream) {
        let known = self.reach.known(input.known());
        if let (false, Some(begin)) = (self.begun, input.next_at()) {
            self.begun = true;
            if self.reach.enters(begin) > begin {
                out.push(begin, self.greatest());
            }
        }
        loop {
            let enter = input.next_at().map(|at| self.reach.enters(at));
            let next = earlier(enter, self.leave());
            let Some(next) = next.filter(|at| *at < known) else { break };
            if enter == Some(next)
                && let Some(step) = input.pop()
            {
                self.enter(step.at, if self.is_least { -step.truth } else { step.truth });
            }
            while self.leave().is_some_and(|at| at <= next) {
                self.candidates.pop_front();
            }
            out.push(next, self.greatest());
        }
        out.know(known);
    }

    fn enter(&mut self, at: i64, truth: Truth) {
        if self.reach.from.is_none() && self.candidates.front().is_some_and(|c| c.truth >= truth) {
            return;
        }
        if let Some(newest) = self.candidates.back_mut() {
            newest.end = Some(at);
        }
        while self.candidates.back().is_some_and(|c| c.truth <= truth) {
            self.candidates.pop_back();
        }
        self.candidates.push_back(Candidate { truth, end: None });
    }

    /// When the maximum leaves the window, if known.
    fn leave(&self) -> Option<i64> {
        self.candidates.front()?.end.and_then(|end| self.reach.leaves(end))
    }

    fn greatest(&self) -> Truth {
        let greatest = self.candidates.front().map_or(Truth::FALSE, |candidate| candidate.truth);
        if self.is_least { -greatest } else { greatest }
    }
}
