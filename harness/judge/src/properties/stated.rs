//! A plan's own properties: formulas over the signals of its rig.

use super::Kind;
use super::verdict::{NEVER, PropertyVerdict};
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
    /// Signals without a value so far, by number.
    unseen: BTreeMap<usize, String>,
    /// When the last of the others had its first value.
    seen_since: Timestamp,
    violation: Option<Violation>,
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
        let unseen = signals.map(|used| (used.index, used.name.clone())).collect();
        Self {
            name: stated.name.clone(),
            kind: stated.kind,
            reads: Reads::of(&formula, speakers),
            monitor: formula.map(Monitor::new),
            unseen,
            seen_since: Timestamp::ZERO,
            violation: None,
        }
    }

    /// Takes a message of a speaker.
    pub(super) fn message(&mut self, now: Timestamp, speaker: usize, decoded: &Decoded<'_>) {
        let Some(monitor) = &mut self.monitor else { return };
        let Some(values) = self.reads.take(speaker, decoded) else { return };
        if !self.unseen.is_empty() {
            for (number, _) in values {
                if self.unseen.remove(number).is_some() {
                    self.seen_since = now;
                }
            }
        }
        monitor.update(now, values);
        if self.violation.is_none()
            && let Some(violation) = &monitor.verdict().first_violation
        {
            self.violation = Some(told(violation));
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
        let Self { name, kind, monitor, unseen, seen_since, .. } = self;
        let horizon = monitor.as_ref().map_or(Span::ZERO, |monitor| monitor.formula().horizon());
        let verdict = monitor.map(|monitor| monitor.finish(end));
        let violation = verdict.as_ref().and_then(|verdict| verdict.first_violation.as_ref());
        if kind == Kind::Sometimes {
            let held = violation.is_some();
            let is_blind = !held && !unseen.is_empty();
            let never_judged = is_blind.then(|| format!("{NEVER}: {}", no_value(unseen)));
            let (first_violation, margin) = (None, None);
            return PropertyVerdict { name, kind, held, first_violation, never_judged, margin };
        }
        let judged = verdict.as_ref().filter(|verdict| verdict.worst.is_some());
        // A moment at which only a signal is missing that never came: what should have been said was not.
        let missed = judged.filter(|_| violation.is_none() && !unseen.is_empty());
        let missed = missed.and_then(|verdict| verdict.unknown_last);
        let why = match missed.filter(|(_, until)| *until > seen_since) {
            Some((from, _)) => {
                let at_s = from.max(seen_since).as_secs_f64();
                Some(format!("not judged at {at_s:.3} s: {}", no_value(unseen)))
            }
            None if judged.is_some() => None,
            None if unseen.is_empty() => Some(format!(
                "never judged: the run ended at {} s, and the formula looks {} s ahead",
                figures::value(end.as_secs_f64(), 0.0),
                figures::value(horizon.as_secs_f64(), 0.0)
            )),
            None => Some(format!("never judged: {}", no_value(unseen))),
        };
        if let Some(why) = why {
            // A property that could not have been violated counts as not held.
            let (held, first_violation, margin) = (false, None, None);
            let never_judged = Some(why);
            return PropertyVerdict { name, kind, held, first_violation, never_judged, margin };
        }
        PropertyVerdict {
            name,
            kind,
            held: violation.is_none(),
            first_violation: violation.map(told),
            never_judged: None,
            margin: judged.map(|verdict| verdict.robustness.clamp(-1.0, 1.0)),
        }
    }
}

fn no_value(unseen: BTreeMap<usize, String>) -> String {
    let unseen: Vec<String> = unseen.into_values().collect();
    format!("no value of {}", unseen.join(", "))
}

/// The time of the violation, its extent, and the values of the signals.
fn told(violation: &temporal::Violation) -> Violation {
    let value = |(name, value): &(String, f64)| match value.is_nan() {
        true => format!("{name} unknown"),
        false => format!("{name} = {value}"),
    };
    let values: Vec<String> = violation.values.iter().map(value).collect();
    let after = (violation.known - violation.at).as_secs_f64();
    let known = if after > 0.0 { format!(", certain {after:.3} s later") } else { String::new() };
    // A comparison for equality and a yes or no have no margin, nor has a signal beyond every range.
    let by = Some(violation.distance.abs()).filter(|by| *by > 0.0 && by.is_finite());
    let by =
        by.map_or(String::new(), |by| format!(", margin {} %", figures::value(-100.0 * by, 0.0)));
    let what = format!("{}: false{by}{known}", values.join(", "));
    Violation { at: violation.at, what }
}
