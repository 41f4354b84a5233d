//! Internal states: those with a rate, and those computed from others.

use super::arrays::Entry;
use super::formula::formula;
use super::scope::{Local, ParametersOnly};
use super::variables::Variables;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::StateTable;
use crate::place::Place;
use std::collections::BTreeSet;

#[derive(Debug, Clone)]
pub(crate) struct State {
    pub(crate) start: Expression,
    pub(crate) law: Law,
}

#[derive(Debug, Clone)]
pub(crate) enum Law {
    /// Its derivative, in its unit per second.
    Rate(Expression),
    /// Its value at every moment.
    Value(Expression),
    /// Its value as an expression of the previous step: it changes only at the ends of steps. Otherwise a switch would
    /// toggle between the stages of a step and lose its memory.
    Latched(Expression),
    /// Keeps the value assigned by a machine.
    Held,
}

/// Parses the states, and the evaluation order of those with a value. Machines assign some of them.
pub(super) fn states(
    entries: &[Entry<'_, StateTable>],
    set: &BTreeSet<&str>,
    variables: &Variables,
) -> Read<(Vec<State>, Vec<usize>)> {
    let all = Place::file().key("state");
    let mut states = Vec::new();
    for entry in entries {
        let (table, place) = (entry.table, all.key(entry.key));
        let scope = Local { scope: variables, index: entry.index, has_parts: false };
        let of_parameters = Local { scope: &ParametersOnly(variables), ..scope };
        let start = match &table.start {
            Some(start) => formula(start, &of_parameters, &place.key("start"))?,
            None => Expression::constant(0.0),
        };
        let array = entry.key.split('[').next().unwrap_or_default();
        let is_set = set.contains(entry.name.as_str()) || set.contains(array);
        let law = match (&table.rate, &table.value) {
            (Some(rate), None) => Law::Rate(formula(rate, &scope, &place.key("rate"))?),
            (None, Some(value)) => {
                let value = formula(value, &scope, &place.key("value"))?;
                let remembers = value.variables().any(|slot| variables.is_last(slot));
                if remembers { Law::Latched(value) } else { Law::Value(value) }
            }
            (None, None) if is_set => Law::Held,
            _ => {
                let message = format!("the state `{}` has one of `rate` and `value`", entry.name);
                let help = "`rate` is its derivative per second, `value` is what it is";
                return Err(Mistake::new(place, message).help(help));
            }
        };
        states.push(State { start, law });
    }
    let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
    let order = order(&states, variables).map_err(|circle| {
        let path: Vec<_> = circle.iter().map(|index| format!("`{}`", names[*index])).collect();
        let first = names[circle[0]];
        all.key(entries[circle[0]].key)
            .key("value")
            .mistake(format!("a circle: {}", path.join(" needs ")))
            .help(format!("write `last({first})` for what it was one step before"))
    })?;
    Ok((states, order))
}

/// The states with a value, each after those that it depends on; on error a cycle, with the same state at both ends.
fn order(states: &[State], variables: &Variables) -> Result<Vec<usize>, Vec<usize>> {
    let mut order = Vec::new();
    let mut path = Vec::new();
    for index in 0..states.len() {
        visit(index, states, variables, &mut path, &mut order)?;
    }
    Ok(order)
}

fn visit(
    index: usize,
    states: &[State],
    variables: &Variables,
    path: &mut Vec<usize>,
    order: &mut Vec<usize>,
) -> Result<(), Vec<usize>> {
    let (Law::Value(value) | Law::Latched(value)) = &states[index].law else { return Ok(()) };
    if order.contains(&index) {
        return Ok(());
    }
    if let Some(begin) = path.iter().position(|known| *known == index) {
        let mut circle = path[begin..].to_vec();
        circle.push(index);
        return Err(circle);
    }
    path.push(index);
    for needed in value.variables().filter_map(|slot| variables.state_in(slot)) {
        visit(needed, states, variables, path, order)?;
    }
    path.pop();
    order.push(index);
    Ok(())
}
