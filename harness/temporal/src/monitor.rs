//! Monitors a formula that must hold at every moment of a run.

use crate::evaluator::{Evaluator, Stretch};
use crate::formula::Formula;
use crate::history::History;
use crate::not_finite::NotFinite;
use crate::question::Question;
use crate::verdict::{NoNumber, Verdict, Violation};
use wire::time::{Span, Timestamp};

/// Judges a formula at every moment during a run.
///
/// ```
/// use temporal::{Formula, Monitor, NotFound, Signal, Signals};
/// use wire::time::Timestamp;
///
/// struct Bus;
/// impl Signals for Bus {
///     fn find(&self, name: &str) -> Result<Signal, NotFound> {
///         let known = ["cells.VoltageMax", "manager.ContactorCommand"];
///         let index = known.iter().position(|known| *known == name);
///         let index = index.ok_or_else(|| NotFound::unknown(name, &known))?;
///         let unit = ["V", ""][index].to_owned();
///         Ok(Signal { index, unit, ..Signal::default() })
///     }
/// }
///
/// let text = "cells.VoltageMax > 4.25 V -> within 100 ms: manager.ContactorCommand == 0";
/// let mut monitor = Monitor::new(Formula::parse(text, &Bus)?);
/// let at = |millis: i64| Timestamp::from_nanos(millis * 1_000_000);
/// monitor.update(at(0), &[(0, 4.1), (1, 1.0)]);
/// monitor.update(at(500), &[(0, 4.3)]);
/// monitor.update(at(650), &[(1, 0.0)]);
/// let verdict = monitor.finish(at(2_000));
/// // From 500 ms to just before 550 ms the answer was more than 100 ms away.
/// let violation = verdict.first_violation.expect("it came after 150 ms");
/// assert_eq!(violation.at, at(500));
/// assert_eq!(violation.known, at(600));
/// # Ok::<(), temporal::Mistake>(())
/// ```
#[derive(Debug, Clone)]
pub struct Monitor {
    formula: Formula,
    evaluator: Evaluator,
    /// From the first reading that is not finite, until a moment is found that it keeps from being judged.
    not_finite: Option<NotFinite>,
    question: Option<Question>,
    verdict: Verdict,
    last: Option<Last>,
}

/// The truth of the previous moments.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Last {
    False,
    Open,
    Other,
}

impl Monitor {
    /// A monitor of `formula`, starting with the first update.
    pub fn new(formula: Formula) -> Self {
        let mut evaluator = Evaluator::new(&formula);
        evaluator.history = Some(History::new(formula.signals.len()));
        let question = Question::of(&formula);
        let (not_finite, verdict) = (None, Verdict::new());
        Self { formula, evaluator, not_finite, question, verdict, last: None }
    }

    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    /// See [`Evaluator::update`].
    pub fn update(&mut self, time: Timestamp, values: &[(usize, f64)]) {
        let is_bad = |(index, value): &(usize, f64)| {
            !value.is_finite() && self.evaluator.value(*index).is_some()
        };
        if self.not_finite.is_none()
            && self.verdict.no_number.is_none()
            && values.iter().any(is_bad)
        {
            self.not_finite = Some(NotFinite::beside(&self.evaluator));
        }
        if let Some(not_finite) = &mut self.not_finite {
            not_finite.update(time, values);
        }
        self.follow_formula(|evaluator| evaluator.update(time, values));
        self.judge();
    }

    /// See [`Evaluator::advance`]. A formula that looks ahead is judged when its horizon is over. Only updates of its
    /// signals advance time; call this when no update may come for long.
    pub fn advance(&mut self, time: Timestamp) {
        self.follow(|evaluator| evaluator.advance(time));
        self.judge();
    }

    /// The verdict so far, on the moments that are final.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// Ends the run at `time`. Everything after it is unknown: a moment whose truth depends on that is open, neither a
    /// violation nor judged.
    pub fn finish(mut self, time: Timestamp) -> Verdict {
        self.follow(|evaluator| evaluator.finish(time));
        self.judge();
        self.verdict.never_asked = self.question.and_then(Question::never_asked);
        self.verdict
    }

    /// The next moments at which `a` of a formula `a -> b` is true and `b`, which looks ahead, is unknown; each such moment
    /// is given once, when all that `b` looks ahead to is over.
    pub fn unanswered(&mut self) -> Option<Stretch> {
        self.question.as_mut()?.unanswered()
    }

    /// Every signal of the formula has a value now: nothing more is [unanswered](Self::unanswered).
    pub fn all_seen(&mut self) {
        self.question.iter_mut().for_each(Question::all_seen);
    }

    /// How far `b` of a formula `a -> b` looks ahead.
    pub fn limit(&self) -> Span {
        self.question.as_ref().map_or(Span::ZERO, Question::limit)
    }

    fn follow(&mut self, mut to: impl FnMut(&mut Evaluator)) {
        self.not_finite.iter_mut().for_each(|not_finite| not_finite.follow(&mut to));
        self.follow_formula(to);
    }

    fn follow_formula(&mut self, mut to: impl FnMut(&mut Evaluator)) {
        to(&mut self.evaluator);
        if let Some(question) = &mut self.question {
            question.follow(to);
        }
    }

    fn judge(&mut self) {
        while let Some(stretch) = self.evaluator.take() {
            match (stretch.truth.holds(), stretch.truth.robustness()) {
                (Some(holds), Some(robustness)) => self.known(stretch, holds, robustness),
                _ => self.unknown(stretch),
            }
            if let Some(not_finite) = &mut self.not_finite {
                not_finite.judged(stretch);
            }
            if let Some(history) = &mut self.evaluator.history {
                history.forget_before(stretch.to.as_nanos());
            }
        }
        let Some((at, not_finite)) =
            self.not_finite.as_mut().and_then(|one| Some((one.first()?, &*one)))
        else {
            return;
        };
        let named = |(index, value): &(usize, f64)| {
            let used = self.formula.signals.iter().find(|used| used.index == *index)?;
            Some((used.name.clone(), *value))
        };
        let readings = not_finite.readings().iter().filter_map(named).collect();
        self.verdict.no_number = Some(NoNumber { at, readings });
        self.not_finite = None;
    }

    fn known(&mut self, stretch: Stretch, holds: bool, robustness: f64) {
        self.verdict.judged += stretch.length();
        if robustness < self.verdict.robustness || self.verdict.worst.is_none() {
            self.verdict.robustness = robustness;
            self.verdict.worst = Some(stretch.from);
        }
        if holds {
            self.last = Some(Last::Other);
            return;
        }
        self.verdict.holds = false;
        self.verdict.violated += stretch.length();
        if self.last != Some(Last::False) {
            self.verdict.violations += 1;
        }
        self.last = Some(Last::False);
        if let Some(history) = self.evaluator.history.take() {
            let known = stretch.from + self.evaluator.horizon();
            let names = self.formula.signals.iter().map(|used| used.name.clone());
            let unit = self.evaluator.unit(stretch.truth);
            let unit = unit.and_then(|unit| self.formula.units.get(unit)).cloned();
            let known = self.evaluator.end().map_or(known, |end| end.min(known));
            self.verdict.first_violation = Some(Violation {
                at: stretch.from,
                known,
                distance: self.evaluator.distance(stretch.truth).unwrap_or(robustness),
                unit: unit.unwrap_or_default(),
                values: names.zip(history.at(stretch.from.as_nanos())).collect(),
                last: history.at(known.as_nanos()).collect(),
            });
        }
    }

    fn unknown(&mut self, stretch: Stretch) {
        // From here on the horizon extends beyond the end.
        let open = self
            .evaluator
            .end()
            .map(|end| (end - self.evaluator.horizon() + Span::from_nanos(1)).max(stretch.from));
        let open = open.filter(|open| *open < stretch.to);
        let until = open.unwrap_or(stretch.to);
        if until > stretch.from {
            self.verdict.unknown += until - stretch.from;
            self.verdict.unknown_last = Some((stretch.from, until));
        }
        if open.is_some() && self.last != Some(Last::Open) {
            self.verdict.open += 1;
        }
        self.last = Some(if open.is_some() { Last::Open } else { Last::Other });
    }
}
