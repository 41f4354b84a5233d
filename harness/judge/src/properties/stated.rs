//! A plan's own properties: formulas over the signals of its rig.

use super::Kind;
use super::verdict::{Missing, NEVER, PropertyVerdict};
use described::Decoded;
use plan::{Reads, Speaker, Stated};
use record::{Violation, figures};
use std::collections::BTreeMap;
use temporal::Monitor;
use wire::time::{Span, Timestamp};

/// Judges one formula, message by message.
#[derive(Debug, Clone)]
pub(super) struct Statement {
    name: String,
    kind: Kind,
    /// `None` if the formula does not fit the rig; such a plan is rejected before a run.
    monitor: Option<Monitor>,
    reads: Reads,
    /// Signals without a value so far, by number, and those that may still be the late or wrong answer to something that
    /// was asked for before they had one.
    awaited: BTreeMap<usize, Awaited>,
    /// When each speaker was first heard, as long as a signal is awaited.
    heard: BTreeMap<usize, Timestamp>,
    /// What was asked for and not answered in time, by a signal that had no value then.
    unanswered: Option<Missing>,
    /// When the last of the others had its first value.
    seen_since: Timestamp,
    violation: Option<Violation>,
}

/// A signal that had no value at first.
#[derive(Debug, Clone)]
struct Awaited {
    name: String,
    speaker: usize,
    /// When its first value came.
    since: Option<Timestamp>,
}

impl Statement {
    pub(super) fn new(stated: &Stated, speakers: &[Speaker]) -> Self {
        // A sometimes-property is judged by its negation, which must not hold throughout.
        let text = match stated.kind {
            Kind::Always => stated.formula.clone(),
            Kind::Sometimes => format!("not ({})", stated.formula),
        };
        let formula = plan::formula(&text, speakers).ok();
        let signals = formula.iter().flat_map(temporal::Formula::signals);
        let of: Vec<usize> = plan::speakers_of(speakers).collect();
        // Of messages that are counted there are none before the first.
        let awaited = signals.filter(|used| !used.counts).map(|used| {
            let (name, speaker) = (used.name.clone(), of[used.index]);
            (used.index, Awaited { name, speaker, since: None })
        });
        let awaited = awaited.collect();
        Self {
            name: stated.name.clone(),
            kind: stated.kind,
            reads: Reads::of(&formula, speakers),
            monitor: formula.map(Monitor::new),
            awaited,
            heard: BTreeMap::new(),
            unanswered: None,
            seen_since: Timestamp::ZERO,
            violation: None,
        }
    }

    /// Takes a message of a speaker.
    pub(super) fn message(&mut self, now: Timestamp, speaker: usize, decoded: &Decoded<'_>) {
        let Some(monitor) = &mut self.monitor else { return };
        if !self.awaited.is_empty() {
            self.heard.entry(speaker).or_insert(now);
        }
        let Some((now, values)) = self.reads.take(now, speaker, decoded) else { return };
        let is_first = |number: &usize| {
            self.awaited.get(number).is_some_and(|awaited| awaited.since.is_none())
        };
        let brings_first =
            !self.awaited.is_empty() && values.iter().any(|(number, _)| is_first(number));
        if brings_first || self.awaited.values().any(|awaited| awaited.since.is_some()) {
            monitor.advance(now);
            let found = first_unanswered(monitor, &self.awaited, &self.heard);
            self.unanswered = self.unanswered.take().or(found);
            for (number, _) in values {
                if let Some(awaited) = self.awaited.get_mut(number) {
                    awaited.since.get_or_insert(now);
                }
            }
            if brings_first {
                self.seen_since = now;
            }
            let limit = monitor.limit();
            self.awaited.retain(|_, one| one.since.is_none_or(|since| now <= since + limit));
            if self.awaited.is_empty() {
                monitor.all_seen();
            }
        }
        monitor.update(now, values);
        if self.violation.is_none() {
            self.violation = violation(self.kind, monitor.verdict());
        }
    }

    /// The first violation of an always-property so far.
    pub(super) fn broken(&self) -> Option<(&str, &Violation)> {
        let is_always = self.kind == Kind::Always;
        self.violation
            .as_ref()
            .filter(|_| is_always)
            .map(|violation| (self.name.as_str(), violation))
    }

    /// The result in a run that ended at `end`.
    pub(super) fn verdict(self, end: Timestamp) -> PropertyVerdict {
        let Self { name, kind, mut monitor, awaited, heard, seen_since, .. } = self;
        let unanswered =
            monitor.as_mut().filter(|_| self.unanswered.is_none()).and_then(|monitor| {
                monitor.advance(end);
                first_unanswered(monitor, &awaited, &heard)
            });
        let unseen: Vec<String> =
            awaited.into_values().filter(|one| one.since.is_none()).map(|one| one.name).collect();
        let unanswered = self.unanswered.or(unanswered).filter(|_| kind == Kind::Always);
        let horizon = monitor.as_ref().map_or(Span::ZERO, |monitor| monitor.formula().horizon());
        let verdict = monitor.map(|monitor| monitor.finish(end));
        let violation = verdict.as_ref().and_then(|verdict| violation(kind, verdict));
        if kind == Kind::Sometimes {
            let held = violation.is_some();
            let is_blind = !held && !unseen.is_empty();
            let what = || format!("{NEVER}: {}", no_value(&unseen));
            let never_judged = is_blind.then(|| Missing { span: (end, end), what: what() });
            return PropertyVerdict { never_judged, ..without_judgement(name, kind, held) };
        }
        let judged = verdict.as_ref().filter(|verdict| verdict.worst.is_some());
        // A moment at which only a signal is missing that never came: what should have been said was not.
        let missed = judged.filter(|_| violation.is_none() && !unseen.is_empty());
        let missed = missed.and_then(|verdict| verdict.unknown_last);
        let never = |what| Some(Missing { span: (end, end), what });
        let never_judged = match missed.filter(|(_, until)| *until > seen_since) {
            Some((from, until)) => {
                let from = from.max(seen_since);
                let what =
                    format!("not judged at {:.3} s: {}", from.as_secs_f64(), no_value(&unseen));
                Some(Missing { span: (from, until), what })
            }
            None if violation.is_some() => None,
            None if judged.is_some() => unanswered,
            None if unseen.is_empty() && horizon == Span::ZERO => {
                never("never judged: it was at no moment true or false".to_owned())
            }
            None if unseen.is_empty() => never(format!(
                "never judged: the run ended at {} s, and the formula looks {} s ahead",
                figures::value(end.as_secs_f64(), 0.0),
                figures::value(horizon.as_secs_f64(), 0.0)
            )),
            None => never(format!("never judged: {}", no_value(&unseen))),
        };
        if never_judged.is_some() {
            // A property that could not have been violated counts as not held.
            return PropertyVerdict { never_judged, ..without_judgement(name, kind, false) };
        }
        PropertyVerdict {
            name,
            kind,
            held: violation.is_none(),
            margin: verdict.as_ref().and_then(margin),
            first_violation: violation,
            never_judged: None,
            never_asked: verdict.and_then(|verdict| verdict.never_asked),
        }
    }
}

const fn without_judgement(name: String, kind: Kind, held: bool) -> PropertyVerdict {
    let (first_violation, never_judged, margin, never_asked) = (None, None, None, None);
    PropertyVerdict { name, kind, held, first_violation, never_judged, margin, never_asked }
}

fn no_value(unseen: &[String]) -> String {
    format!("no value of {}", unseen.join(", "))
}

/// The first moment at which something was asked for within a time, and was not true in that time: a node that had been heard
/// did not say what it was to say, because it had never said it, or what it then said for the first time was something else.
/// A node that was not heard in all that time is still starting up.
fn first_unanswered(
    monitor: &mut Monitor,
    awaited: &BTreeMap<usize, Awaited>,
    heard: &BTreeMap<usize, Timestamp>,
) -> Option<Missing> {
    let limit = monitor.limit();
    let mut found = std::iter::from_fn(|| monitor.unanswered()).filter_map(|stretch| {
        let by = stretch.from + limit;
        let unknown =
            || awaited.values().filter(|one| one.since.is_none_or(|at| at > stretch.from));
        let came_in_time = |one: &Awaited| one.since.is_some_and(|at| at <= by);
        if unknown().all(came_in_time) {
            let first = unknown().filter_map(|one| Some((one.since?, &one.name))).max()?;
            return Some((stretch.from, first.1, Some(first.0)));
        }
        let silent = unknown().filter(|one| !came_in_time(one)).filter_map(|one| {
            let from = stretch.from.max(*heard.get(&one.speaker)?);
            (from < stretch.to).then_some((from, &one.name, None))
        });
        silent.min()
    });
    let first = found.next();
    found.for_each(drop);
    let (from, name, came) = first?;
    let (at_s, by_s) = (from.as_secs_f64(), (from + limit).as_secs_f64());
    let what = match came.map(|came| came.as_secs_f64()) {
        None => format!("no value of {name} until {by_s:.3} s"),
        Some(came_s) => {
            format!("{name} came at {came_s:.3} s, and was not right until {by_s:.3} s")
        }
    };
    let what = format!("not answered at {at_s:.3} s: {what}");
    Some(Missing { span: (from, from + limit), what })
}

/// The first moment at which the formula did not hold, or at which an always-property could not be judged because a
/// reading was NaN or infinite.
fn violation(kind: Kind, verdict: &temporal::Verdict) -> Option<Violation> {
    let no_number = verdict.no_number.as_ref().filter(|_| kind == Kind::Always);
    let of_no_number = no_number.map(|found| {
        let value = |(name, value): &(String, f64)| format!("{name} is {value}");
        let readings: Vec<String> = found.readings.iter().map(value).collect();
        let what = format!("{}: neither true nor false", readings.join(", "));
        Violation { at: found.at, what }
    });
    let all = verdict.first_violation.as_ref().map(told).into_iter().chain(of_no_number);
    all.min_by_key(|violation| violation.at)
}

/// The smallest margin. No number has the worst, as with the built-in properties.
fn margin(verdict: &temporal::Verdict) -> Option<f64> {
    if verdict.no_number.is_some() {
        return Some(-1.0);
    }
    verdict.worst.map(|_| verdict.robustness.clamp(-1.0, 1.0))
}

/// The time of the violation, its extent, and the values of the signals: of one that has another when all is known, both.
fn told(violation: &temporal::Violation) -> Violation {
    let value = |((name, value), last): (&(String, f64), &f64)| {
        let last = Some(*last).filter(|last| !last.is_nan() && last != value);
        let last = last.map(|last| format!(" (at last {})", figures::all_digits(last)));
        let first = match value.is_nan() {
            true => "unknown".to_owned(),
            false => format!("= {}", figures::all_digits(*value)),
        };
        format!("{name} {first}{}", last.unwrap_or_default())
    };
    let values: Vec<String> = violation.values.iter().zip(&violation.last).map(value).collect();
    let after = (violation.known - violation.at).as_secs_f64();
    let known = if after > 0.0 { format!(", certain {after:.3} s later") } else { String::new() };
    // In the unit of the comparison. A yes or no has no distance, nor has a signal beyond every range.
    let by = Some(violation.distance.abs()).filter(|by| *by > 0.0 && by.is_finite());
    let by = by.map(|by| figures::quantity_alone(by, 0.0, &violation.unit));
    let by = by.map_or(String::new(), |by| format!(" by {by}"));
    let what = format!("{}: false{by}{known}", values.join(", "));
    Violation { at: violation.at, what }
}

#[cfg(test)]
mod tests {
    use super::{Span, Timestamp, told};

    #[test]
    fn a_violation_says_how_far_it_went() {
        let what = |distance: f64, later_ms: i64| {
            let values = vec![("cells.Voltage".to_owned(), 4.3), ("relay".to_owned(), f64::NAN)];
            let last = vec![if later_ms > 0 { 4.1 } else { 4.3 }, f64::NAN];
            let known = Timestamp::ZERO + Span::from_millis(later_ms);
            let (at, unit) = (Timestamp::ZERO, "V".to_owned());
            told(&temporal::Violation { at, known, distance, unit, values, last }).what
        };
        assert_eq!(what(-0.05, 0), "cells.Voltage = 4.3, relay unknown: false by 0.05 V");
        // Found by a user: what broke it in the window was not told.
        let none = "cells.Voltage = 4.3 (at last 4.1), relay unknown: false, certain 0.010 s later";
        assert_eq!(what(0.0, 10), none);
        assert_eq!(what(-f64::INFINITY, 10), none);
    }
}
