//! Inner states: those that change at a rate, and those that follow from the others.

use super::formula;
use super::variables::{ParametersOnly, Variables};
use crate::error::Mistake;
use crate::expression::Expression;
use crate::file::StateTable;
use crate::place::Place;
use std::collections::BTreeMap;

/// A state.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Its value at power-on; made of parameters.
    pub(crate) start: Expression,
    pub(crate) law: Law,
}

/// How a state goes on.
#[derive(Debug, Clone)]
pub(crate) enum Law {
    /// Its derivative, in its unit per second.
    Rate(Expression),
    /// Its value, at every moment.
    Value(Expression),
    /// Its value, made of what was one step before: it changes at the ends of steps alone. Else a switch
    /// would be thrown between the stages of a step, and not be remembered.
    Latched(Expression),
}

/// The states by name, and the order in which those with a value follow from one another.
pub(super) fn states(
    tables: &BTreeMap<String, StateTable>,
    variables: &Variables,
) -> Result<(Vec<State>, Vec<usize>), Mistake> {
    let all = Place::file().key("state");
    let mut states = Vec::new();
    for (name, table) in tables {
        let place = all.key(name);
        let start = match &table.start {
            Some(start) => formula(start, &ParametersOnly(variables), &place.key("start"))?,
            None => Expression::constant(0.0),
        };
        let law = match (&table.rate, &table.value) {
            (Some(rate), None) => Law::Rate(formula(rate, variables, &place.key("rate"))?),
            (None, Some(value)) => {
                let value = formula(value, variables, &place.key("value"))?;
                let remembers = value.variables().any(|slot| variables.is_last(slot));
                if remembers { Law::Latched(value) } else { Law::Value(value) }
            }
            _ => {
                let message = format!("the state `{name}` has one of `rate` and `value`");
                let help = "`rate` is its derivative per second, `value` is what it is";
                return Err(Mistake::new(place, message).help(help));
            }
        };
        states.push(State { start, law });
    }
    let names: Vec<&str> = tables.keys().map(String::as_str).collect();
    let order = order(&states, variables).map_err(|circle| {
        let path: Vec<_> = circle.iter().map(|index| format!("`{}`", names[*index])).collect();
        let first = names[circle[0]];
        Mistake::new(all.key(first).key("value"), format!("a circle: {}", path.join(" needs ")))
            .help(format!("write `last({first})` for what it was one step before"))
    })?;
    Ok((states, order))
}

/// The states with a value, each behind those that it needs; or a circle, with its begin at both ends.
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
