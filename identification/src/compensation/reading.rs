//! A model of a sensor as steps that compute readings from the truth, for an emulated sensor.

use super::formula::number;
use super::program::{Input, Program};
use super::terms::{Fields, adds, lagged};
use crate::corrections::factor;
use crate::dataset::{Dataset, Role};
use crate::finding::{CompensationInput, CompensationStep, LeftOut};
use crate::model::{Acts, Form, LATE_SHARE, Model, Shape, Wrap};
use crate::problem::Channels;

/// How a sensor reads: steps over the truth, in its own unit. As in the model, all errors but a delay and a constant scale
/// depend on the current truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Inputs of the steps: the truth as `x`, and other inputs of the model by field.
    pub inputs: Vec<CompensationInput>,
    /// The steps, as of a [`Compensation`](crate::finding::Compensation).
    pub steps: Vec<CompensationStep>,
    /// Age of the truth that `late` stands for, s.
    pub delay_s: f64,
}

/// How a sensor reads according to `model`; `si` is one of its unit in SI. Temperatures come in degC, headings in deg,
/// and other fields in SI.
///
/// # Errors
///
/// The terms that cannot be turned into readings.
pub fn reading(model: &Model, si: f64) -> Result<Reading, Vec<LeftOut>> {
    let named = |role: Role, otherwise: &'static str| {
        let found = model.fields.iter().find(|(_, known)| **known == role);
        found.map_or(otherwise, |(name, _)| name)
    };
    let heading = named(Role::Heading, "heading");
    let degree = crate::dataset::Unit::Degree.si();
    let si_of = |field: &str| if field == heading { degree } else { 1.0 };
    let reference =
        match model.fields.iter().find(|(_, role)| {
            matches!(role, Role::Reference | Role::ReferenceRate | Role::TableRate)
        }) {
            Some((name, _)) => name,
            None => crate::problem::ROTATION,
        };
    let time = named(Role::Time, "time");
    let fields = Fields { reference, time, si: &si_of, read: &str::to_owned, smoothing: 0.0 };
    let (mut refused, mut delay_s, mut lag) = (Vec::new(), 0.0, None);
    let mut share = 1.0;
    let mut shapes = Vec::new();
    let nothing = nothing(model);
    for term in &model.terms {
        let refuse = |why: &str| LeftOut { term: term.name.clone(), why: why.to_owned() };
        let (shape, values) = match term.to_shape(&nothing) {
            Ok(read) => read,
            Err(why) => {
                refused.push(refuse(&why));
                continue;
            }
        };
        let value = values.first().copied().unwrap_or(0.0);
        if shape.form == Form::Delay {
            share = shape.number(LATE_SHARE).unwrap_or(share);
        }
        match (shape.acts, shape.form) {
            (Acts::Delay, Form::Delay) if is_lag(&shape) && value > 0.0 => lag = Some(value),
            (Acts::Delay, Form::Delay) if value >= 0.0 => delay_s += value,
            (Acts::Delay, Form::Delay) => refused.push(refuse("nothing reads what is to come")),
            _ => shapes.push((shape, values)),
        }
    }
    let mut program = Program::default();
    let truth = program.input(Input::Reading) * number(si);
    let late = if delay_s > 0.0 { Input::Late } else { Input::Reading };
    let mut sum = program.input(late) * number(si);
    if let Some(constant) = lag {
        let level = program.step("truth", sum);
        sum = lagged(&mut program, &level, constant);
    }
    if share != 1.0 {
        // The scale error is late as well, and stands below as one of the current truth.
        sum = truth.clone() + number(share) * (sum - truth.clone());
    }
    for (shape, values) in &shapes {
        match adds(&mut program, (shape, values), &truth, &fields) {
            Ok(error) => sum = sum + error,
            Err(why) => refused.push(LeftOut { term: shape.name.clone(), why }),
        }
    }
    if !refused.is_empty() {
        return Err(refused);
    }
    program
        .step("reading", sum / number(si / factor(&model.corrections, |field| field != reference)));
    let (inputs, steps) = program.written("truth", |_| String::new());
    Ok(Reading { inputs, steps, delay_s })
}

fn is_lag(shape: &Shape) -> bool {
    shape.drivers.first().is_some_and(|driver| driver.wrap == Wrap::LagOf)
}

/// Channels without data: the terms carry their units as text.
fn nothing(model: &Model) -> Channels {
    Channels::new(&Dataset::new("", model.kind, Vec::new(), Vec::new()))
}
