//! Finds the smallest case that still breaks a property.

mod change;

use super::case::{Case, CaseResult};
use super::executor::Executor;
use super::space::{DURATION_MIN, plain, whole_ms};
use change::{begin, length_min, recast, rounded_up, set_begin, set_length, set_number, timed};
use plan::faults::{Fault, FaultKind, Lasts, Schedule, Toward, When};
use std::collections::BTreeSet;
use wire::time::Span;

/// Number of bisections towards zero, at most: no number is a tenth above it.
const HALVINGS: usize = 6;
/// A number that is smaller by less than this share is not worth a run.
const LEAST_GAIN: f64 = 0.1;
/// Number of plainer kinds tried in place of one.
const PLAINER_MAX: usize = 3;

/// Result of shrinking.
#[derive(Debug, Clone, PartialEq)]
pub struct Shrunk {
    /// The smallest case.
    pub case: Case,
    /// Its result.
    pub result: CaseResult,
    /// Number of cases carried out on the way.
    pub executions: u64,
    /// Whether shrinking was stopped before its end.
    pub stopped: bool,
}

/// How far a case was shrunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Small {
    /// As far as it goes, or as many tries as were asked for.
    Smallest,
    /// Until the campaign was stopped.
    InPart,
    /// Not at all.
    Not,
}

impl Shrunk {
    /// How far it was shrunk. Without any fault, nothing is left to shrink.
    pub fn small(&self) -> Small {
        match (self.executions, self.stopped) {
            _ if self.case.schedule.is_empty() => Small::Smallest,
            (0, _) => Small::Not,
            (_, true) => Small::InPart,
            (_, false) => Small::Smallest,
        }
    }
}

/// Shrinks `case`, which broke `property` with this `result`, in number, kind, severity, time and direction of its
/// faults, as long as the same property breaks, with at most `executions_max` tries. The seed stays the same. No
/// schedule is carried out twice, and changes of all faults are tried before changes of one.
pub fn shrink(
    executor: &impl Executor,
    case: &Case,
    result: &CaseResult,
    property: &str,
    executions_max: u64,
) -> Shrunk {
    let (case, result) = (case.clone(), result.clone());
    let best = Shrunk { case, result, executions: 0, stopped: false };
    let tried = BTreeSet::from([best.case.schedule.to_toml()]);
    let mut shrinker = Shrinker { executor, property, executions_max, best, tried, again: false };
    loop {
        let before = shrinker.best.case.clone();
        shrinker.fewer();
        shrinker.all();
        for index in 0..shrinker.best.case.schedule.faults.len() {
            shrinker.plainer(index);
            shrinker.shorter(index);
            shrinker.weaker(index);
        }
        if is_settled(&before.schedule, &shrinker.best.case.schedule) || shrinker.is_spent() {
            break;
        }
        shrinker.again = true;
    }
    // Not before: each round would undo it.
    for index in 0..shrinker.best.case.schedule.faults.len() {
        shrinker.rounder(index);
    }
    let mut best = shrinker.best;
    best.stopped |= executor.is_stopped();
    if best.result.stopped {
        best.result = executor.execute(&best.case);
    }
    best
}

/// Whether a round of changes gained so little that another is not worth its runs: the same faults at the same times, no
/// number smaller by more than a tenth.
fn is_settled(before: &Schedule, after: &Schedule) -> bool {
    let is_kept = |before: f64, after: f64| after >= (1.0 - LEAST_GAIN) * before;
    before.faults.len() == after.faults.len()
        && before.faults.iter().zip(&after.faults).all(|(before, after)| {
            let seconds = |fault: &Fault| fault.duration.map_or(f64::INFINITY, Span::as_secs_f64);
            let begins = |fault: &Fault| begin(fault).unwrap_or_default();
            let mut others =
                Fault { what: before.what, duration: before.duration, ..after.clone() };
            set_begin(&mut others, begins(before));
            is_kept(before.what.severity(), after.what.severity())
                && is_kept(seconds(before), seconds(after))
                && is_kept(begins(before).as_secs_f64(), begins(after).as_secs_f64())
                && (&others, before.what.name()) == (before, after.what.name())
        })
}

struct Shrinker<'a, E> {
    executor: &'a E,
    property: &'a str,
    executions_max: u64,
    best: Shrunk,
    /// Schedules already carried out, as text in a plan.
    tried: BTreeSet<String>,
    /// Whether each number has been bisected once.
    again: bool,
}

impl<E: Executor> Shrinker<'_, E> {
    fn is_spent(&self) -> bool {
        let is_stopped = self.best.stopped || self.executor.is_stopped();
        is_stopped || self.best.executions >= self.executions_max
    }

    /// Accepts this schedule if it also breaks the property.
    fn takes(&mut self, faults: Vec<Fault>) -> bool {
        if self.is_spent() || faults == self.best.case.schedule.faults {
            return false;
        }
        let case = Case { seed: self.best.case.seed, schedule: Schedule { faults } };
        if !self.executor.takes(&case) || !self.tried.insert(case.schedule.to_toml()) {
            return false;
        }
        self.best.executions += 1;
        let result = self.executor.execute_until(&case, self.property);
        // Interrupted, and not at a violation.
        self.best.stopped |= result.is_given_up() && !result.stopped;
        if !result.breaks(self.property) {
            return false;
        }
        (self.best.case, self.best.result) = (case, result);
        true
    }

    /// Accepts the change of one fault if the property still breaks.
    fn with(&mut self, index: usize, change: impl FnOnce(&mut Fault)) -> bool {
        let mut faults = self.best.case.schedule.faults.clone();
        change(&mut faults[index]);
        self.takes(faults)
    }

    fn fault(&self, index: usize) -> &Fault {
        &self.best.case.schedule.faults[index]
    }

    /// Leaves out halves, quarters and so on, as in delta debugging (Zeller and Hildebrandt, 2002).
    fn fewer(&mut self) {
        let mut size = self.best.case.schedule.faults.len();
        while size > 0 {
            let mut at = 0;
            while at < self.best.case.schedule.faults.len() {
                let mut faults = self.best.case.schedule.faults.clone();
                faults.drain(at..(at + size).min(faults.len()));
                if !self.takes(faults) {
                    at += size;
                }
            }
            size /= 2;
        }
    }

    /// Changes every fault at once: certain and in both directions, as early, as short and as weak as possible. If a
    /// number does not matter, that mostly holds for all faults.
    fn all(&mut self) {
        let changes: [fn(&mut Fault); 4] = [
            |fault| {
                fault.probability = 1.0;
                fault.toward = Toward::Both;
                fault.what = fault.what.info().typical.with_severity(fault.what.severity());
            },
            |fault| {
                set_begin(fault, Span::ZERO);
                set_number(fault, 1);
            },
            |fault| fault.duration = fault.duration.map(|_| DURATION_MIN),
            |fault| fault.what = fault.what.with_severity(fault.what.severity_range().0),
        ];
        for change in changes {
            let mut faults = self.best.case.schedule.faults.clone();
            faults.iter_mut().for_each(change);
            self.takes(faults);
        }
    }

    /// Prefers what a person would write: certain, both directions, the plainest kind for its target, typical
    /// parameters.
    fn plainer(&mut self, index: usize) {
        self.with(index, |fault| fault.probability = 1.0);
        if self.fault(index).toward != Toward::Both {
            self.with(index, |fault| fault.toward = Toward::Both);
        }
        let (target, now) = (self.fault(index).target, self.fault(index).what);
        let plainer = FaultKind::all()
            .iter()
            .take_while(|info| info.name != now.name())
            .filter(|info| info.reach.targets().contains(&target))
            .take(PLAINER_MAX);
        for info in plainer {
            if self.with(index, |fault| *fault = recast(fault, info.typical)) {
                break;
            }
        }
        let now = self.fault(index).what;
        let typical = now.info().typical.with_severity(now.severity());
        self.with(index, |fault| fault.what = typical);
    }

    /// Moves each number of its time towards its minimum: first all the way, then by bisection.
    fn shorter(&mut self, index: usize) {
        self.bounded(index);
        let is_cut = self.cut(index);
        if !is_cut {
            self.earlier_end(index);
        }
        // The instant that matters may be the last one.
        if self.later_begin(index) || is_cut {
            self.earlier_end(index);
        }
        if let Some(begin) = begin(self.fault(index)) {
            self.halve(index, 0.0, begin.as_secs_f64(), |fault, seconds| {
                set_begin(fault, whole_ms(seconds));
            });
        }
        let number = match &self.fault(index).when {
            When::Step { number, .. } | When::During { number, .. } => *number,
            When::Always | When::At(_) => 1,
        };
        let (mut holds, mut breaks) = (0, number);
        while holds + 1 < breaks {
            let middle = if holds == 0 { 1 } else { holds.midpoint(breaks) };
            if self.with(index, |fault| set_number(fault, middle)) {
                breaks = middle;
            } else {
                holds = middle;
            }
        }
    }

    /// Time of the violation, after which nothing matters.
    fn broken_at(&self) -> Option<Span> {
        let mut broken = self.best.result.violated.iter();
        let broken = broken.find(|violated| violated.property == self.property)?;
        (broken.at_s > 0.0).then(|| whole_ms(broken.at_s).max(DURATION_MIN))
    }

    /// Gives a fault without an end one at the violation. A fault of a whole phase begins with the phase.
    fn bounded(&mut self, index: usize) {
        let fault = self.fault(index);
        if fault.what.info().lasts != Lasts::Scheduled || fault.duration.is_some() {
            return;
        }
        let Some(at) = self.broken_at() else { return };
        self.with(index, |fault| {
            fault.when = timed(&fault.when);
            fault.duration = Some(at);
        });
    }

    /// Ends a fault that outlasts the violation there.
    fn cut(&mut self, index: usize) -> bool {
        let fault = self.fault(index);
        let When::At(begin) = timed(&fault.when) else { return false };
        let (Some(at), Some(lasting)) = (self.broken_at(), fault.lasting()) else { return false };
        begin < at
            && at < begin + lasting
            && self.with(index, |fault| set_length(fault, at - begin))
    }

    /// Keeps the begin and looks for an earlier end.
    fn earlier_end(&mut self, index: usize) -> bool {
        let Some(lasting) = self.fault(index).lasting() else { return false };
        let least = length_min(self.fault(index));
        self.halve(index, least, lasting.as_secs_f64(), |fault, seconds| {
            set_length(fault, whole_ms(seconds));
        })
    }

    /// Keeps the end and looks for a later begin.
    fn later_begin(&mut self, index: usize) -> bool {
        let fault = self.fault(index);
        let Some(lasting) = fault.lasting() else { return false };
        let end = begin(fault).unwrap_or_default() + lasting;
        let least = length_min(fault);
        self.halve(index, least, lasting.as_secs_f64(), |fault, seconds| {
            let length = whole_ms(seconds);
            fault.when = timed(&fault.when);
            set_begin(fault, end - length);
            set_length(fault, length);
        })
    }

    fn weaker(&mut self, index: usize) {
        let what = self.fault(index).what;
        if what.info().lasts == Lasts::Itself {
            return;
        }
        let (least, _) = what.severity_range();
        self.halve(index, least, what.severity(), |fault, size| {
            fault.what = fault.what.with_severity(plain(fault.what, size));
        });
    }

    /// Bisects on a logarithmic scale where `least` is above zero: numbers range over decades. Whether one is smaller.
    fn halve(&mut self, index: usize, least: f64, now: f64, set: impl Fn(&mut Fault, f64)) -> bool {
        if now <= least {
            return false;
        }
        if self.with(index, |fault| set(fault, least)) {
            return true;
        }
        let (mut holds, mut breaks) = (least, now);
        if self.again {
            breaks /= 1.0 + LEAST_GAIN;
            if !self.with(index, |fault| set(fault, breaks)) {
                return false;
            }
        }
        let mut halvings = 0;
        while breaks > (1.0 + LEAST_GAIN) * holds && (least > 0.0 || halvings < HALVINGS) {
            halvings += 1;
            let middle = if holds > 0.0 { (holds * breaks).sqrt() } else { 0.5 * (holds + breaks) };
            if self.with(index, |fault| set(fault, middle)) {
                breaks = middle;
            } else {
                holds = middle;
            }
        }
        breaks < now
    }

    /// Rounds numbers to few digits, as near as possible.
    fn rounder(&mut self, index: usize) {
        for digits in [1, 2, 3] {
            let severity = rounded_up(self.fault(index).what.severity(), digits);
            if self.with(index, |fault| fault.what = fault.what.with_severity(severity)) {
                break;
            }
        }
        for digits in [1, 2, 3] {
            let Some(duration) = self.fault(index).duration else { break };
            let rounded = whole_ms(rounded_up(duration.as_secs_f64(), digits));
            if self.with(index, |fault| fault.duration = Some(rounded)) {
                break;
            }
        }
        for unit_ms in [1_000, 100, 10] {
            let Some(begin) = begin(self.fault(index)) else { break };
            let rounded = Span::from_millis(begin.as_nanos() / 1_000_000 / unit_ms * unit_ms);
            if self.with(index, |fault| set_begin(fault, rounded)) {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests;
