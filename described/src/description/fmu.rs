//! A functional mock-up unit as part of a device: its outputs are states.

use super::STEP_S_MIN;
use super::formula::formula;
use super::parts::seconds;
use super::scope::{Local, ParametersOnly};
use super::variables::Variables;
use crate::error::{Mistake, Read};
use crate::expression::Expression;
use crate::file::{File, FmuTable, Formula, SourceTable, StateTable};
use crate::files::Files;
use crate::fmu::{Fmu, FmuRole, Loaded};
use crate::hint;
use crate::layout::{Layout, Sender};
use crate::place::Place;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use wire::time::Span;

/// A unit with what it reads and writes. Its variables are given by their places.
#[derive(Debug, Clone)]
pub(crate) struct Physics {
    /// Its file, for messages.
    pub(crate) file: String,
    pub(crate) unit: Arc<dyn Fmu>,
    pub(crate) step: Span,
    /// Set at the start.
    pub(crate) parameters: Vec<(usize, Expression)>,
    /// Set before each step: inputs, and parameters that are tunable.
    pub(crate) inputs: Vec<(usize, Expression)>,
    /// Variables and the slots of the states that they are.
    pub(crate) outputs: Vec<(usize, usize)>,
}

fn place() -> Place {
    Place::file().key("fmu")
}

/// Loads the unit of the file, and adds a state for each of its outputs.
pub(super) fn load(said: &mut File, files: &mut dyn Files) -> Read<Option<Loaded>> {
    let Some(table) = &said.fmu else { return Ok(None) };
    let file = table.file.clone();
    let unit = files.fmu(&file).map_err(|error| Mistake::new(place().key("file"), error))?;
    if table.outputs.is_empty() {
        let readable = |role| matches!(role, FmuRole::Output);
        let known = unit.variables().iter().filter(|one| readable(one.role));
        let known: Vec<_> = known.map(|one| format!("`{}`", one.name)).collect();
        let help = format!("outputs = {{ temperature = \"...\" }}: one of {}", known.join(", "));
        return Err(Mistake::new(place().name(), "nothing reads the FMU").help(help));
    }
    for (name, variable) in &table.outputs {
        let at = place().key("outputs").key(name);
        if let Some(section) = said.section_of(name) {
            return Err(Mistake::new(at.name(), format!("there is a {section} `{name}` already")));
        }
        super::parameters::name(name, "state", &at)?;
        let found = find(&*unit, variable, &[FmuRole::Output, FmuRole::Local], &at)?;
        let variable = &unit.variables()[found];
        let state = StateTable {
            start: Some(Formula::Number(0.0)),
            rate: None,
            value: None,
            unit: variable.unit.clone(),
            doc: variable.doc.clone(),
        };
        said.state.insert(name.clone(), state);
    }
    Ok(Some(Loaded { file, unit }))
}

/// The place of the variable with this name, which has one of these roles and is a number.
fn find(unit: &dyn Fmu, name: &str, roles: &[FmuRole], at: &Place) -> Read<usize> {
    let word = |role| match role {
        FmuRole::Input => "an input",
        FmuRole::Output => "an output",
        FmuRole::Parameter => "a parameter",
        FmuRole::Local => "a local variable",
    };
    let (_, wanted) = word(roles[0]).split_once(' ').unwrap_or_default();
    let all = unit.variables();
    let found = all.iter().position(|one| one.name == name);
    let Some(place) = found.filter(|place| roles.contains(&all[*place].role)) else {
        let known = all.iter().filter(|one| roles.contains(&one.role));
        let known: Vec<&str> = known.map(|one| one.name.as_str()).collect();
        let what = match found {
            Some(place) => {
                let is = word(all[place].role);
                format!("`{name}` of the FMU is no {wanted}: it is {is}")
            }
            None => format!("the FMU has no {wanted} `{name}`"),
        };
        return Err(Mistake::new(at.name(), what).help(hint::proposal(name, &known)));
    };
    match &all[place].no_number {
        None => Ok(place),
        Some(why) => Err(Mistake::new(at.name(), format!("`{name}` of the FMU is {why}"))
            .help("numbers and booleans can be used")),
    }
}

/// Reads the rest of the table. `set` are the states that machines assign; `step_s` is that of the device.
pub(super) fn physics(
    table: &FmuTable,
    loaded: Loaded,
    variables: &Variables,
    set: &BTreeSet<&str>,
    step_s: f64,
) -> Read<Physics> {
    let Loaded { file, unit } = loaded;
    let all = Local { scope: variables, index: None, has_parts: false };
    let of_parameters = Local { scope: &ParametersOnly(variables), ..all };
    let (mut parameters, mut inputs, mut outputs) = (Vec::new(), Vec::new(), Vec::new());
    for (name, value) in &table.parameters {
        let at = place().key("parameters").key(name);
        let found = find(&*unit, name, &[FmuRole::Parameter], &at)?;
        let value = formula(value, &of_parameters, &at)?;
        if unit.variables()[found].tunable && value.known().is_none() {
            inputs.push((found, value.clone()));
        }
        parameters.push((found, value));
    }
    for (name, value) in &table.inputs {
        let at = place().key("inputs").key(name);
        let found = find(&*unit, name, &[FmuRole::Input], &at)?;
        inputs.push((found, formula(value, &all, &at)?));
    }
    for (name, variable) in &table.outputs {
        let at = place().key("outputs").key(name);
        if set.contains(name.as_str()) {
            let message = format!("a machine sets `{name}`, which is an output of the FMU");
            return Err(Mistake::new(at.name(), message));
        }
        let found = find(&*unit, variable, &[FmuRole::Output, FmuRole::Local], &at)?;
        if let Some(slot) = variables.inner(name) {
            outputs.push((found, slot));
        }
    }
    let at = if table.step_s.is_some() { place().key("step_s") } else { place().key("file") };
    let step = table.step_s.or_else(|| unit.step_s()).unwrap_or(step_s);
    let step = seconds(step, STEP_S_MIN, &at)?;
    Ok(Physics { file, unit, step, parameters, inputs, outputs })
}

/// Checks that signals that are just an output have its unit, as far as both are known.
pub(super) fn units(
    table: &FmuTable,
    unit: &dyn Fmu,
    layout: &Layout,
    signals: &BTreeMap<String, SourceTable>,
    files: &mut dyn Files,
) -> Read {
    for (name, signal) in signals {
        let Some(Formula::Expression(text)) = &signal.expression else { continue };
        let Some(variable) = table.outputs.get(text.trim()) else { continue };
        let Some(variable) = unit.variables().iter().find(|one| one.name == *variable) else {
            continue;
        };
        let Ok((message, place)) = layout.resolve_among(name, Some(Sender::Device)) else {
            continue;
        };
        let sent = &layout.messages()[message].signals[place].unit;
        if files.differ(&variable.unit, sent) {
            let message = format!("`{name}` is in {sent}, and `{text}` in {}", variable.unit);
            let at = Place::file().key("signal").key(name).key("expression");
            return Err(Mistake::new(at, message)
                .help("write the conversion, `temperature - 273.15` for example"));
        }
    }
    Ok(())
}
