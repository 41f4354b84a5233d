//! Signals of nodes: their observations, and conditions to wait for.

use plan::{Action, Condition, MessagePlace, Plan, QuantityName, Speaker, Step, resolve, unit};
use std::collections::{BTreeMap, VecDeque};
use wire::time::{Span, Timestamp};

/// Most values of one signal kept for conditions: 16 minutes at 1 kHz.
pub const HISTORY_MAX: usize = 1_000_000;

/// Quantities of a plan by the messages that carry them.
#[derive(Debug, Clone, Default)]
pub(super) struct Signals {
    wanted: BTreeMap<MessagePlace, Vec<String>>,
    /// Time of the last message of each kind, by speaker and message.
    last: BTreeMap<(usize, usize), Timestamp>,
    /// Recent values of signals in conditions, as far back as their windows reach.
    past: BTreeMap<String, Past>,
    /// Units of signals, as written in the layouts.
    units: BTreeMap<String, String>,
}

#[derive(Debug, Clone, Default)]
struct Past {
    values: VecDeque<(Timestamp, f64)>,
    span: Span,
}

impl Signals {
    pub(super) fn of(plan: &Plan, speakers: &[Speaker]) -> Self {
        let mut signals = Self::default();
        let wait = |signals: &mut Self, condition: &Condition| {
            let past = signals.past.entry(condition.quantity().as_str().to_owned()).or_default();
            past.span = past.span.max(condition.window());
            signals.want(condition.quantity(), speakers);
        };
        for step in Step::walk(&plan.steps) {
            match &step.action {
                Action::WaitUntil(condition) => wait(&mut signals, condition),
                Action::Repeat(repeat) => {
                    repeat.until.iter().for_each(|until| wait(&mut signals, until));
                }
                Action::Identify(identify) => {
                    identify.of_nodes().for_each(|quantity| signals.want(quantity, speakers));
                }
                _ => {}
            }
        }
        for declared in &plan.measurements {
            signals.want(&declared.quantity, speakers);
            declared
                .check
                .kind()
                .second_quantity()
                .into_iter()
                .for_each(|(_, name)| signals.want(name, speakers));
        }
        signals
    }

    fn want(&mut self, quantity: &QuantityName, speakers: &[Speaker]) {
        let place = quantity.of_message().and_then(|of| resolve(speakers, of).ok());
        let Some(place) = place else { return };
        let names = self.wanted.entry(place).or_default();
        let name = quantity.as_str();
        self.units.entry(name.to_owned()).or_insert_with(|| unit(speakers, place));
        if names.iter().all(|known| known != name) {
            names.push(name.to_owned());
        }
    }

    /// Takes a message of a speaker; `values` are those of the signals that it carries. Returns the new values by
    /// quantity.
    pub(super) fn take(
        &mut self,
        now: Timestamp,
        (speaker, message): (usize, usize),
        values: &[Option<f64>],
    ) -> Vec<(String, f64)> {
        let mut brought = Vec::new();
        let before = self.last.insert((speaker, message), now);
        let first = MessagePlace { speaker, message, signal: None };
        let beyond = MessagePlace { speaker, message: message + 1, signal: None };
        for (place, names) in self.wanted.range(first..beyond) {
            let value = match place.signal {
                None => before.map(|before| (now - before).as_secs_f64()),
                Some(signal) => values.get(signal).copied().flatten(),
            };
            let Some(value) = value else { continue };
            brought.extend(names.iter().map(|name| (name.clone(), value)));
        }
        for (name, value) in &brought {
            if let Some(past) = self.past.get_mut(name) {
                past.add(now, *value);
            }
        }
        brought
    }

    /// Unit of a signal that the plan needs.
    pub(super) fn unit(&self, quantity: &QuantityName) -> &str {
        self.units.get(quantity.as_str()).map_or("1", String::as_str)
    }

    /// Whether the condition holds at the last value of its signal.
    pub(super) fn holds(&self, condition: &Condition) -> bool {
        let Some(past) = self.past.get(condition.quantity().as_str()) else { return false };
        past.range(condition.window()).is_some_and(|(low, high)| condition.holds(low, high))
    }
}

impl Past {
    fn add(&mut self, now: Timestamp, value: f64) {
        self.values.push_back((now, value));
        // One value from before the window proves that the whole window is known.
        let from = now - self.span;
        while self.values.len() > HISTORY_MAX
            || self.values.get(1).is_some_and(|(second, _)| *second <= from)
        {
            self.values.pop_front();
        }
    }

    /// Smallest and largest value over the last `span`; `None` while the history is shorter.
    fn range(&self, span: Span) -> Option<(f64, f64)> {
        let from = self.values.back()?.0 - span;
        if self.values.front()?.0 > from {
            return None;
        }
        let recent = self.values.iter().rev().take_while(|(at, _)| *at >= from);
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        Some(recent.fold(ends, |(low, high), (_, value)| (low.min(*value), high.max(*value))))
    }
}

#[cfg(test)]
mod tests {
    use super::{Past, Span, Timestamp};

    #[test]
    fn a_window_is_known_once_something_is_older() {
        let mut past = Past { span: Span::from_secs(2), ..Past::default() };
        let at = Timestamp::from_secs_f64;
        past.add(at(0.0), 5.0);
        past.add(at(1.0), 1.0);
        assert_eq!(past.range(Span::from_secs(2)), None);
        assert_eq!(past.range(Span::ZERO), Some((1.0, 1.0)));
        past.add(at(2.5), 3.0);
        assert_eq!(past.range(Span::from_secs(2)), Some((1.0, 3.0)));
        past.add(at(3.5), 2.0);
        assert_eq!(past.range(Span::from_secs(2)), Some((2.0, 3.0)));
        // Only the last value before the longest window is kept.
        assert_eq!(past.values.len(), 3);
    }
}
