//! State machines: their transitions and assignments.

use super::formula::formula;
use super::parts::{PERIOD_S_MIN, question, seconds};
use super::scope::Local;
use super::states::{Law, State};
use super::variables::{MachineNames, Variables};
use crate::error::{Mistake, Read};
use crate::expression::{Expression, Meaning, Scope};
use crate::file::{Formula, MachineTable, TransitionTable};
use crate::hint;
use crate::place::Place;
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;
use wire::time::Span;

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    /// The index of its initial state.
    pub(crate) start: usize,
    /// In the order of the file.
    pub(crate) transitions: Vec<Transition>,
    /// Assignments on entering a state: one list per state.
    pub(crate) enter: Vec<Vec<Setting>>,
}

/// A transition to a state. All of its conditions must hold.
#[derive(Debug, Clone)]
pub(crate) struct Transition {
    /// Whether it leads from each state.
    pub(crate) from: Vec<bool>,
    pub(crate) to: usize,
    pub(crate) when: Option<Expression>,
    /// The message that triggers it.
    pub(crate) on: Option<usize>,
    /// Minimum time in the state.
    pub(crate) after: Option<Span>,
    pub(crate) set: Vec<Setting>,
}

#[derive(Debug, Clone)]
pub(crate) struct Setting {
    pub(crate) slot: usize,
    pub(crate) value: Expression,
}

/// The tables in the order of the file.
pub(super) fn in_order(
    tables: &BTreeMap<String, Spanned<MachineTable>>,
) -> Vec<(&str, &MachineTable)> {
    let mut order: Vec<_> = tables.iter().collect();
    order.sort_by_key(|(_, table)| table.span().start);
    order.into_iter().map(|(name, table)| (name.as_str(), table.get_ref())).collect()
}

/// The names of the state variables that machines assign; checks that each exists.
pub(super) fn set<'a>(
    tables: &[(&'a str, &'a MachineTable)],
    variables: &Variables,
) -> Read<BTreeSet<&'a str>> {
    let mut names = BTreeSet::new();
    for (machine, table) in tables {
        let place = Place::file().key("machine").key(machine);
        let on_the_way = table.transitions.iter().enumerate();
        let on_the_way = on_the_way
            .map(|(index, one)| (place.key("transitions").index(index).key("set"), &one.set));
        let entering = table.enter.iter();
        let entering = entering.map(|(state, set)| (place.key("enter").key(state), set));
        for (place, set) in on_the_way.chain(entering) {
            let known = variables.state_names();
            if let Some(name) = set.keys().find(|name| !known.contains(name)) {
                let text = format!("no state variable `{name}`");
                let mistake = Mistake::new(place.key(name).name(), text);
                return Err(mistake.help(hint::proposal(name, &known)));
            }
            names.extend(set.keys().map(String::as_str));
        }
    }
    Ok(names)
}

/// The names of the machines and of their states.
pub(super) fn names(tables: &[(&str, &MachineTable)]) -> Read<Vec<MachineNames>> {
    for (name, table) in tables {
        let place = Place::file().key("machine").key(name).key("states");
        if table.states.is_empty() {
            return Err(Mistake::new(place, format!("`{name}` has no states")));
        }
        let again = |(place, state): &(usize, &String)| table.states[..*place].contains(state);
        if let Some((index, state)) = table.states.iter().enumerate().find(again) {
            return Err(place.index(index).mistake(format!("there is a state `{state}` already")));
        }
    }
    let named = tables.iter().map(|(name, table)| MachineNames {
        name: (*name).to_owned(),
        states: table.states.clone(),
    });
    Ok(named.collect())
}

/// Parses the machines, in the order of the file.
pub(super) fn machines(
    tables: &[(&str, &MachineTable)],
    states: &[State],
    variables: &Variables,
) -> Read<Vec<Machine>> {
    let all = Place::file().key("machine");
    let machine = |(name, table): &(&str, &MachineTable)| {
        let reader = Reader { name, table, place: all.key(name), states, variables };
        reader.machine()
    };
    tables.iter().map(machine).collect()
}

struct Reader<'a> {
    name: &'a str,
    table: &'a MachineTable,
    place: Place,
    states: &'a [State],
    variables: &'a Variables,
}

impl Reader<'_> {
    fn machine(&self) -> Read<Machine> {
        let start = self.state(&self.table.start, &self.place.key("start"))?;
        let all = self.place.key("transitions");
        let each = self.table.transitions.iter().enumerate();
        let transitions = each.map(|(index, table)| self.transition(table, &all.index(index)));
        let transitions = transitions.collect::<Result<Vec<_>, _>>()?;
        self.reached(start, &transitions)?;
        let mut enter: Vec<Vec<Setting>> = vec![Vec::new(); self.table.states.len()];
        for (state, set) in &self.table.enter {
            let place = self.place.key("enter").key(state);
            enter[self.state(state, &place.name())?] = self.settings(set, &place)?;
        }
        Ok(Machine { start, transitions, enter })
    }

    fn state(&self, name: &str, place: &Place) -> Read<usize> {
        self.table.states.iter().position(|known| known == name).ok_or_else(|| {
            let text = format!("`{}` has no state `{name}`", self.name);
            Mistake::new(place.clone(), text).help(hint::proposal(name, &self.table.states))
        })
    }

    fn transition(&self, table: &TransitionTable, place: &Place) -> Read<Transition> {
        let to = self.state(&table.to, &place.key("to"))?;
        let from = match &table.from {
            None => (0..self.table.states.len()).map(|state| state != to).collect(),
            Some(given) => {
                let place = place.key("from");
                let mut from = vec![false; self.table.states.len()];
                for name in given.as_slice() {
                    from[self.state(name, &place)?] = true;
                }
                from
            }
        };
        if !from.contains(&true) {
            let place = place.key(if table.from.is_some() { "from" } else { "to" });
            return Err(Mistake::new(place, "the transition leads from no state")
                .help("without `from` it leads from any other state"));
        }
        if table.when.is_none() && table.on.is_none() && table.after_s.is_none() {
            return Err(Mistake::new(place.clone(), "nothing makes this transition")
                .help("add `when` (a condition), `on` (a message that is heard) or `after_s`"));
        }
        let scope = Local { scope: self.variables, index: None, has_parts: false };
        let when = table.when.as_ref().map(|when| formula(when, &scope, &place.key("when")));
        let when = when.transpose()?;
        if when.as_ref().and_then(Expression::known) == Some(0.0) {
            return Err(Mistake::new(place.key("when"), "the condition never holds"));
        }
        let layout = &self.variables.layout;
        let on = table.on.as_ref().map(|name| question(name, layout, &place.key("on")));
        let after = table.after_s.map(|s| seconds(s, PERIOD_S_MIN, &place.key("after_s")));
        let set = self.settings(&table.set, &place.key("set"))?;
        Ok(Transition { from, to, when, on: on.transpose()?, after: after.transpose()?, set })
    }

    /// Checks that every state is reachable from the initial one.
    fn reached(&self, start: usize, transitions: &[Transition]) -> Read {
        let mut reached = vec![false; self.table.states.len()];
        reached[start] = true;
        let leads_on = |one: &Transition, reached: &[bool]| {
            !reached[one.to] && one.from.iter().zip(reached).any(|(from, is)| *from && *is)
        };
        while let Some(next) = transitions.iter().find(|one| leads_on(one, &reached)) {
            reached[next.to] = true;
        }
        match reached.iter().position(|is| !is) {
            None => Ok(()),
            Some(state) => {
                let text = format!(
                    "no transitions lead from `{}` to `{}`",
                    self.table.start, self.table.states[state]
                );
                Err(Mistake::new(self.place.key("states").index(state), text)
                    .help("add a transition to it, or leave the state out"))
            }
        }
    }

    fn settings(&self, set: &BTreeMap<String, Formula>, place: &Place) -> Read<Vec<Setting>> {
        let mut settings = Vec::new();
        for (name, value) in set {
            let place = place.key(name);
            let (slots, first) = match self.variables.variable(name) {
                Ok(Meaning::Slot(slot)) => (slot..slot + 1, None),
                Ok(Meaning::Array(array)) => (array.slots(), Some(array.first)),
                // All of them are states, as `set` has checked.
                _ => (0..0, None),
            };
            for (index, slot) in (0..).zip(slots) {
                let known = self.variables.state_in(slot).map(|state| &self.states[state].law);
                if let Some(Law::Value(_) | Law::Latched(_)) = known {
                    let text = format!("`{name}` is always its `value`");
                    return Err(Mistake::new(place.name(), text)
                        .help("what is set has a `rate`, or a `start` alone"));
                }
                let index = first.map(|first| first + index);
                let scope = Local { scope: self.variables, index, has_parts: false };
                settings.push(Setting { slot, value: formula(value, &scope, &place)? });
            }
        }
        Ok(settings)
    }
}
