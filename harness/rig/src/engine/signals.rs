//! Signals of nodes: their observations, and conditions to wait for.

use super::past::Past;
use plan::{Action, Condition, MessagePlace, Plan, QuantityName, Speaker, Step, resolve, unit};
use std::collections::BTreeMap;
use wire::time::Timestamp;

/// Quantities of a plan by the messages that carry them.
#[derive(Debug, Clone, Default)]
pub(super) struct Signals {
    wanted: BTreeMap<MessagePlace, Vec<String>>,
    /// Time of the last message of each kind, by speaker and message.
    last: BTreeMap<(usize, usize), Timestamp>,
    /// Recent values of quantities in conditions, as far back as their windows reach.
    past: BTreeMap<String, Past>,
    /// Units of signals, as written in the layouts.
    units: BTreeMap<String, String>,
}

impl Signals {
    pub(super) fn of(plan: &Plan, speakers: &[Speaker]) -> Self {
        let mut signals = Self::default();
        let wait = |signals: &mut Self, condition: &Condition| {
            let past = signals.past.entry(condition.quantity().as_str().to_owned()).or_default();
            past.reach(condition.window());
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
                .facts()
                .second_quantity
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
        brought.iter().for_each(|(name, value)| self.hear(now, name, Some(*value)));
        brought
    }

    /// Takes a value that conditions may wait for; without one, what was known of it before counts no more.
    pub(super) fn hear(&mut self, now: Timestamp, name: &str, value: Option<f64>) {
        match (self.past.get_mut(name), value) {
            (Some(past), Some(value)) => past.add(now, value),
            (Some(past), None) => past.forget(),
            (None, _) => {}
        }
    }

    /// Unit of a signal that the plan needs.
    pub(super) fn unit(&self, quantity: &QuantityName) -> &str {
        self.units.get(quantity.as_str()).map_or("1", String::as_str)
    }

    /// Whether the condition holds at the last value of its quantity.
    pub(super) fn holds(&self, condition: &Condition) -> bool {
        let Some(past) = self.past.get(condition.quantity().as_str()) else { return false };
        past.range(condition.window()).is_some_and(|(low, high)| condition.holds(low, high))
    }
}
