//! Phases of a plan: events that other parts can wait for by name during the run.
//!
//! A phase is a step, by its key or its label, or one round of a repeat or a sweep. Turns, straights and bias tests are
//! counted by the commands to the controller, so a lap contains four turns.

use super::step::Step;
use super::{Name, Plan};
use controller::mission::Command;
use std::collections::BTreeMap;

/// A phase began or ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PhaseEvent {
    /// The phase of this name began.
    Began(String),
    /// The phase with this name ended; if several are active, the one that began last.
    Ended(String),
    /// All steps ended; the run is being torn down.
    PlanEnded,
}

/// The phase that corresponds to a command to the controller, if any.
pub const fn of_command(command: &Command) -> Option<&'static str> {
    match command {
        Command::Turn(_) => Some("turn"),
        Command::Straight(_) => Some("straight"),
        Command::BiasTest(_) => Some("bias_test"),
        _ => None,
    }
}

/// The names of the phase of a step, or of a round of it.
pub fn names(step: &Step) -> impl Iterator<Item = &str> {
    let name = step.action.name();
    let told_by_this_name = step.action.kind().missions().iter().any(|(told, _)| *told == name);
    let own = (!told_by_this_name).then_some(name);
    own.into_iter().chain(step.label.as_ref().map(Name::as_str))
}

impl Plan {
    /// Maximum number of occurrences of each phase; a repeat may end early.
    pub fn phases(&self) -> BTreeMap<&str, u64> {
        let mut counts = BTreeMap::new();
        count(&self.steps, 1, &mut counts);
        counts
    }
}

impl Plan {
    /// The same phases, in order of their first occurrence.
    pub fn phases_in_order(&self) -> Vec<&str> {
        let of_step = |step| {
            let told =
                Step::walk(std::slice::from_ref(step)).flat_map(|one| one.action.kind().missions());
            names(step).chain(told.map(|(name, _)| *name)).collect::<Vec<_>>()
        };
        let mut order = Vec::new();
        for name in Step::walk(&self.steps).flat_map(of_step) {
            if !order.contains(&name) {
                order.push(name);
            }
        }
        order
    }

    /// For each key of steps, the labels of these steps in their order; a step without a label is listed by its key. Keys whose
    /// steps can run more than once are left out.
    pub fn labels(&self) -> BTreeMap<String, Vec<String>> {
        let mut labels: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for step in &self.steps {
            let key = step.action.name();
            let label = step.label.as_ref().map_or(key, Name::as_str);
            labels.entry(key.to_owned()).or_default().push(label.to_owned());
        }
        let counts = self.phases();
        labels.retain(|key, of| counts.get(key.as_str()) == Some(&(of.len() as u64)));
        labels
    }

    /// Turns and straights with their numbers, in order of first occurrence, if all of them come after a bias test;
    /// otherwise empty.
    pub fn motions_after_bias_test(&self) -> Vec<(Name, u32)> {
        let mut order = Vec::new();
        for (name, _) in Step::walk(&self.steps).flat_map(|step| step.action.kind().missions()) {
            if !order.contains(name) {
                order.push(*name);
            }
        }
        let Some((&"bias_test", motions)) = order.split_first() else { return Vec::new() };
        let counts = self.phases();
        let times = |name: &str| u32::try_from(*counts.get(name)?).ok();
        motions.iter().filter_map(|name| Some((Name::new(name)?, times(name)?))).collect()
    }
}

fn count<'a>(steps: &'a [Step], rounds: u64, counts: &mut BTreeMap<&'a str, u64>) {
    for step in steps {
        let rounds = rounds.saturating_mul(step.action.repetitions());
        let mut add = |name: &'a str, times: u64| {
            let sum = counts.entry(name).or_default();
            *sum = sum.saturating_add(rounds.saturating_mul(times));
        };
        names(step).for_each(|name| add(name, 1));
        step.action.kind().missions().iter().for_each(|(name, times)| add(name, *times));
        count(step.action.steps(), rounds, counts);
    }
}

#[cfg(test)]
mod tests {
    use crate::{Name, Plan};

    fn plan(steps: &str) -> Plan {
        let text = format!("name = \"x\"\ntitle = \"x\"\ndevices = \"paper\"\nsteps = [{steps}]");
        toml::from_str(&text).unwrap()
    }

    fn motions(steps: &str) -> Vec<(String, u32)> {
        let named = |(name, times): (Name, u32)| (name.as_str().to_owned(), times);
        plan(steps).motions_after_bias_test().into_iter().map(named).collect()
    }

    #[test]
    fn labels_stand_for_the_keys_of_steps_that_run_once() {
        let (wait, turn) = ("{ wait = { duration_s = 1 }", "{ turn = { angle_deg = 90 } }");
        let labels = plan(&format!(
            "{wait}, label = \"up\" }}, {wait} }}, {turn}, {{ repeat = {{ times = 2, steps = [{turn}] }} }}"
        ))
        .labels();
        assert_eq!(labels.get("wait").unwrap(), &["up", "wait"]);
        assert!(!labels.contains_key("turn"), "{labels:?}");
    }

    #[test]
    fn motions_are_those_that_a_bias_test_comes_before() {
        let test = "{ bias_test = { duration_s = 20 } }";
        let turn = "{ turn = { angle_deg = 90, rate_deg_per_s = 30 } }";
        let lap = "{ lap = { direction = \"cw\", side_m = 4, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } }";
        let of = |name: &str, times| (name.to_owned(), times);
        let both =
            motions(&format!("{test}, {{ repeat = {{ times = 2, steps = [{lap}] }} }}, {turn}"));
        assert_eq!(both, [of("straight", 8), of("turn", 9)]);
        assert_eq!(motions(&format!("{turn}, {test}, {lap}")), []);
        assert_eq!(motions(test), []);
    }
}
