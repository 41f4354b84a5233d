//! Finds the smallest case that still breaks a property.

use super::case::{Case, CaseResult};
use super::executor::Executor;
use super::space::{DURATION_MIN, whole_ms};
use plan::faults::{Fault, FaultKind, Lasts, Schedule, Toward, When};
use std::collections::BTreeSet;
use wire::time::Span;

/// Number of bisections towards the smallest number that still breaks.
const HALVINGS: usize = 6;
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
    let best = Shrunk { case: case.clone(), result: result.clone(), executions: 0 };
    let tried = BTreeSet::from([case.schedule.to_toml()]);
    let mut shrinker = Shrinker { executor, property, executions_max, best, tried };
    loop {
        let before = shrinker.best.case.clone();
        shrinker.fewer();
        shrinker.all();
        for index in 0..shrinker.best.case.schedule.faults.len() {
            shrinker.plainer(index);
            shrinker.shorter(index);
            shrinker.weaker(index);
            shrinker.rounder(index);
        }
        if is_settled(&before.schedule, &shrinker.best.case.schedule) || shrinker.is_spent() {
            break;
        }
    }
    let mut best = shrinker.best;
    if best.result.stopped {
        best.result = executor.execute(&best.case);
    }
    best
}

/// Whether a round of changes gained so little that another is not worth its runs: the same faults at the same times, no
/// number smaller by more than a tenth.
fn is_settled(before: &Schedule, after: &Schedule) -> bool {
    const LEAST_GAIN: f64 = 0.1;
    let is_kept = |before: f64, after: f64| after >= (1.0 - LEAST_GAIN) * before;
    before.faults.len() == after.faults.len()
        && before.faults.iter().zip(&after.faults).all(|(before, after)| {
            let seconds = |fault: &Fault| fault.duration.map_or(f64::INFINITY, Span::as_secs_f64);
            is_kept(before.what.severity(), after.what.severity())
                && is_kept(seconds(before), seconds(after))
                && Fault { what: before.what, duration: before.duration, ..after.clone() }
                    == *before
                && before.what.name() == after.what.name()
        })
}

struct Shrinker<'a, E> {
    executor: &'a E,
    property: &'a str,
    executions_max: u64,
    best: Shrunk,
    /// Schedules already carried out, as text in a plan.
    tried: BTreeSet<String>,
}

impl<E: Executor> Shrinker<'_, E> {
    fn is_spent(&self) -> bool {
        self.best.executions >= self.executions_max || self.executor.is_stopped()
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

    /// Moves each kind of number towards its minimum: first all the way, then by bisection.
    fn shorter(&mut self, index: usize) {
        if self.fault(index).what.info().lasts == Lasts::Scheduled {
            self.bounded(index);
            let least = DURATION_MIN.as_secs_f64();
            if let Some(duration) = self.fault(index).duration {
                self.halve(index, least, duration.as_secs_f64(), |fault, seconds| {
                    fault.duration = Some(whole_ms(seconds));
                });
            }
            // The instant that matters may be the last one.
            if let (Some(begin), Some(duration)) =
                (begin(self.fault(index)), self.fault(index).duration)
            {
                let end = begin + duration;
                self.halve(index, least, duration.as_secs_f64(), |fault, seconds| {
                    let duration = whole_ms(seconds);
                    set_begin(fault, end - duration);
                    fault.duration = Some(duration);
                });
            }
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

    /// Gives a fault without an end one at the violation, after which nothing matters. A fault of a whole phase begins
    /// with the phase.
    fn bounded(&mut self, index: usize) {
        let broken = &self.best.result.violated;
        let broken = broken.iter().find(|violated| violated.property == self.property);
        let Some(at_s) = broken.map(|violated| violated.at_s) else { return };
        if self.fault(index).duration.is_some() || at_s <= 0.0 {
            return;
        }
        self.with(index, |fault| {
            fault.when = match fault.when.clone() {
                When::Always => When::At(Span::ZERO),
                When::During { phase, number } => When::Step { phase, number, after: Span::ZERO },
                when @ (When::At(_) | When::Step { .. }) => when,
            };
            fault.duration = Some(whole_ms(at_s).max(DURATION_MIN));
        });
    }

    fn weaker(&mut self, index: usize) {
        let what = self.fault(index).what;
        let (least, _) = what.severity_range();
        self.halve(index, least, what.severity(), |fault, size| {
            fault.what = fault.what.with_severity(size);
        });
    }

    /// Bisects on a logarithmic scale where `least` is above zero: numbers range over decades.
    fn halve(&mut self, index: usize, least: f64, now: f64, set: impl Fn(&mut Fault, f64)) {
        if now <= least || self.with(index, |fault| set(fault, least)) {
            return;
        }
        let (mut holds, mut breaks) = (least, now);
        for _ in 0..HALVINGS {
            let middle = if holds > 0.0 { (holds * breaks).sqrt() } else { 0.5 * (holds + breaks) };
            if self.with(index, |fault| set(fault, middle)) {
                breaks = middle;
            } else {
                holds = middle;
            }
        }
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

/// The same fault with another kind, as far as possible.
fn recast(fault: &Fault, what: FaultKind) -> Fault {
    let info = what.info();
    let toward = if info.reach.is_line() { fault.toward } else { Toward::Both };
    let lasting = fault.lasting();
    let what = match (info.lasts, lasting) {
        (Lasts::Itself, Some(lasting)) => what.with_severity(lasting.as_secs_f64()),
        _ => what,
    };
    let duration = if info.lasts == Lasts::Scheduled { lasting } else { None };
    let duration = duration.filter(|duration| *duration > Span::ZERO);
    Fault { what, toward, duration, ..fault.clone() }
}

/// Begin of a fault that begins at a fixed time of the run or of a phase.
const fn begin(fault: &Fault) -> Option<Span> {
    match fault.when {
        When::At(at) | When::Step { after: at, .. } => Some(at),
        When::Always | When::During { .. } => None,
    }
}

fn set_begin(fault: &mut Fault, begin: Span) {
    if let When::At(at) | When::Step { after: at, .. } = &mut fault.when {
        *at = begin;
    }
}

fn set_number(fault: &mut Fault, to: u32) {
    if let When::Step { number, .. } | When::During { number, .. } = &mut fault.when {
        *number = to;
    }
}

/// Rounds to this many digits, away from zero.
fn rounded_up(value: f64, digits: i32) -> f64 {
    if value.is_nan() || value <= 0.0 {
        return value;
    }
    let unit = 10f64.powi(value.log10().floor() as i32 + 1 - digits);
    // A number that is already round stays.
    let rounded = (value / unit - 1e-9).ceil() * unit;
    // Without the rounding error of the product, as a person would write it.
    format!("{rounded:.*e}", 6).parse().unwrap_or(rounded)
}

#[cfg(test)]
mod tests {
    use super::{rounded_up, shrink};
    use crate::toy::{Toy, size, space};
    use crate::{Executor as _, Random, Search as _};

    #[test]
    fn digits_are_few_and_the_value_no_less() {
        for (value, one, two) in [(0.0231, 0.03, 0.024), (97.0, 100.0, 97.0), (5.0, 5.0, 5.0)] {
            assert_eq!(rounded_up(value, 1), one);
            assert_eq!(rounded_up(value, 2), two);
        }
    }

    /// The toy breaks with two faults at a time: two remain, no worse than necessary.
    #[test]
    fn two_faults_are_left_as_weak_and_as_early_as_they_can_be() {
        let (toy, space) = (Toy::default(), space());
        let mut random = Random::new(&space, 5);
        let (mut found, mut tries) = (0, 0);
        while found < 10 {
            tries += 1;
            assert!(tries < 2000);
            let case = random.next();
            let result = toy.execute(&case);
            if !result.breaks("held") {
                continue;
            }
            found += 1;
            let shrunk = shrink(&toy, &case, &result, "held", 500);
            let faults = &shrunk.case.schedule.faults;
            assert_eq!(faults.len(), 2, "{}", shrunk.case.schedule.to_toml());
            assert!(shrunk.result.breaks("held"));
            // Within one digit of the limit at which it breaks.
            assert!(faults.iter().all(|fault| size(fault) < 0.65), "{faults:?}");
            assert!(shrunk.executions <= 500);
            assert_eq!(shrunk, shrink(&toy, &case, &result, "held", 500));
        }
    }
}
