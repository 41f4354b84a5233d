//! Converts identified models of sensors into steps of a described device: steps that turn true values into readings,
//! and steps that correct errors.

use super::Refused;
use described::{Input, Step, Steps};
use identification::compensation;
use identification::dataset::{Dimension, Kind, Role, Unit};
use identification::finding::{Compensation, CompensationInput, CompensationStep};
use identification::model::Model;
use std::f64::consts::PI;

/// Units in the notation of layouts that the contract of measured data does not know, and their size in SI units.
const WRITTEN: [(&str, Unit, f64); 9] = [
    ("degC", Unit::Celsius, 1.0),
    ("\u{b0}C", Unit::Celsius, 1.0),
    ("\u{b0}", Unit::Degree, PI / 180.0),
    ("\u{b0}/s", Unit::DegreePerSecond, PI / 180.0),
    ("dps", Unit::DegreePerSecond, PI / 180.0),
    ("\u{b0}/h", Unit::DegreePerHour, PI / 648e3),
    ("mrad/s", Unit::RadianPerSecond, 1e-3),
    ("mdeg/s", Unit::DegreePerSecond, PI / 180e3),
    ("m/s^2", Unit::MetrePerSecondSquared, 1.0),
];

/// The unit of a field for a signal with this unit; unknown units become plain numbers.
pub fn unit_of(signal: &str) -> Unit {
    let same = |(text, unit, si): &(&str, Unit, f64)| {
        (*text == signal && *si == unit.si()).then_some(*unit)
    };
    Unit::parse(signal).or_else(|| WRITTEN.iter().find_map(same)).unwrap_or(Unit::One)
}

fn si_of(signal: &str) -> (Dimension, f64) {
    let written = WRITTEN.iter().find(|(text, ..)| *text == signal);
    let known = Unit::parse(signal).map(|unit| (unit.dimension(), unit.si()));
    let written = || written.map(|(_, unit, si)| (unit.dimension(), *si));
    known.or_else(written).unwrap_or((Dimension::Number, 1.0))
}

/// The readings of a sensor according to `model`; `unit` is that of the signal. Temperature and heading are inputs with
/// these names; other inputs have the last part of the field's name.
///
/// # Errors
/// When the model is of another quantity, or has an effect that readings cannot show.
pub fn reading(model: &Model, unit: &str) -> Result<Steps, String> {
    let (dimension, si) = si_of(unit);
    if model.kind != Kind::Sensor && dimension != Dimension::AngularRate {
        return Err(format!("the model is of a rate, and the unit of this signal is `{unit}`"));
    }
    let reading = compensation::reading(model, si).map_err(|refused| {
        Refused(refused.into_iter().map(|one| (one.term, one.why)).collect()).to_string()
    })?;
    let named = |field: &str| match model.fields.get(field) {
        Some(Role::Temperature) => "temperature".to_owned(),
        Some(Role::Heading) => "heading".to_owned(),
        _ => last_part(field),
    };
    Ok(steps(&reading.inputs, &reading.steps, "truth", named, reading.delay_s))
}

/// The steps by which a device corrects its own signal.
pub fn correction(compensation: &Compensation) -> Steps {
    steps(&compensation.inputs, &compensation.steps, &compensation.of, last_part, 0.0)
}

/// A node refers to its signals without its own name.
fn last_part(field: &str) -> String {
    field.split_once('.').map_or(field, |(_, name)| name).to_owned()
}

fn steps(
    inputs: &[CompensationInput],
    steps: &[CompensationStep],
    value: &str,
    named: impl Fn(&str) -> String,
    delay_s: f64,
) -> Steps {
    let input = |input: &CompensationInput| {
        let of = match input.name.as_str() {
            _ if input.of == value => Input::Value,
            "late" => Input::Late,
            "t" => Input::Time,
            "dt" => Input::Interval,
            _ => Input::Named(named(&input.of)),
        };
        (input.name.clone(), of)
    };
    let step = |step: &CompensationStep| Step {
        name: step.name.clone(),
        expression: step.expression.clone(),
        first: step.first.clone(),
    };
    Steps {
        inputs: inputs.iter().map(input).collect(),
        steps: steps.iter().map(step).collect(),
        delay_s,
    }
}
