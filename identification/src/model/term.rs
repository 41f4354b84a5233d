//! Terms with their numbers in the units of the data, from shapes with numbers in SI, and back.

use super::see::Field;
use super::{Acts, Driver, Form, Shape, Term, Wrap, field};
use crate::finding::Parameter;
use crate::problem::{Channels, DisplayUnit};
use crate::units::{per, si_factor};

/// A fitted coefficient, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// Its value.
    pub value: f64,
    /// Its standard error; NaN where it was not fitted.
    pub error: f64,
}

/// Unit of a driver's differences, as written and in SI.
fn driver_unit(channels: &Channels, driver: &Driver) -> DisplayUnit {
    let plain = match field(channels, driver) {
        Some(Field::Rotation) => {
            DisplayUnit::new(channels.rotation_unit.text(), channels.rotation_unit.si())
        }
        Some(Field::Channel(channel)) => {
            DisplayUnit::new(channel.unit.difference_text(), channel.unit.si())
        }
        Some(Field::Time) => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Some(Field::Direction) | None => DisplayUnit::new("1", 1.0),
    };
    match driver.wrap {
        Wrap::RateOf => DisplayUnit::new(&per(&plain.text, channels.time_unit.text()), plain.si),
        Wrap::Sign => DisplayUnit::new("1", 1.0),
        _ => plain,
    }
}

/// Unit of a number of `shape` that is not a coefficient.
fn fixed_unit(shape: &Shape, channels: &Channels, name: &str) -> DisplayUnit {
    let time = DisplayUnit::new(channels.time_unit.text(), 1.0);
    match name {
        "time_constant" | "delay" => time,
        "stretch" | "through" => DisplayUnit::new("1", 1.0),
        "origin_2" => shape.drivers.get(1).map_or(time, |driver| driver_unit(channels, driver)),
        _ => shape.drivers.first().map_or(time, |driver| driver_unit(channels, driver)),
    }
}

/// Names of the coefficients of a shape.
fn coefficient_names(shape: &Shape) -> Vec<String> {
    let one = |name: &str| vec![name.to_owned()];
    match shape.form {
        Form::Constant => one("value"),
        Form::Linear => one(match shape.drivers.first().map(|driver| driver.wrap) {
            Some(Wrap::RateOf) if shape.name == "shupe" => "h",
            _ => "slope",
        }),
        Form::Quadratic | Form::Cubic | Form::Product => one("coefficient"),
        Form::Exponential => one("amplitude"),
        Form::Harmonic | Form::Periodic => vec!["cos".to_owned(), "sin".to_owned()],
        Form::Step => one("size"),
        Form::Hinge => one("slope"),
        Form::Bump | Form::Tanh => one("height"),
        Form::Spline | Form::Surface => (1..=shape.width()).map(|i| format!("value_{i}")).collect(),
        Form::Delay => one(match (shape.acts, shape.drivers.first().map(|driver| driver.wrap)) {
            (Acts::Clock, _) => "stretch",
            (_, Some(Wrap::LagOf)) => "time_constant",
            _ => "delay",
        }),
        Form::DeadZone | Form::Saturation => one("gain"),
    }
}

/// Unit of the coefficients of a shape, where a term's own unit is `unit`.
fn coefficient_unit(shape: &Shape, channels: &Channels, unit: &DisplayUnit) -> DisplayUnit {
    let drivers: Vec<DisplayUnit> =
        shape.drivers.iter().map(|driver| driver_unit(channels, driver)).collect();
    let over = |power: i32| {
        let Some(driver) = drivers.first() else {
            return unit.clone();
        };
        let text = match (power, driver.text.contains('/')) {
            (_, _) if driver.text == "1" => "1".to_owned(),
            (1, _) => driver.text.clone(),
            (_, true) => format!("({})^{power}", driver.text),
            (_, false) => format!("{}^{power}", driver.text),
        };
        let written = if text.starts_with('(') {
            format!("{}/{text}", unit.text)
        } else {
            per(&unit.text, &text)
        };
        DisplayUnit::new(&written, unit.si / driver.si.powi(power))
    };
    match shape.form {
        Form::Linear | Form::Hinge => over(1),
        Form::Quadratic => over(2),
        Form::Cubic => over(3),
        Form::Product => {
            let first = over(1);
            drivers.get(1).map_or(first.clone(), |second| {
                DisplayUnit::new(&per(&first.text, &second.text), first.si / second.si)
            })
        }
        Form::Delay if shape.acts == Acts::Clock => DisplayUnit::new("1", 1.0),
        Form::Delay => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Form::DeadZone | Form::Saturation => DisplayUnit::new("1", 1.0),
        _ => unit.clone(),
    }
}

impl Term {
    /// The term of `shape` with its coefficients; `nonlinear` gives the errors of its fitted other numbers.
    pub fn from_shape(
        shape: &Shape,
        coefficients: &[Fitted],
        nonlinear: &[(String, f64)],
        unit: &DisplayUnit,
        channels: &Channels,
    ) -> Self {
        let written = coefficient_unit(shape, channels, unit);
        let names = coefficient_names(shape);
        let mut parameters: Vec<Parameter> = names
            .iter()
            .zip(coefficients)
            .map(|(name, fitted)| Parameter {
                name: name.clone(),
                value: fitted.value / written.si,
                standard_error: fitted.error.is_finite().then_some(fitted.error / written.si),
                unit: written.text.clone(),
            })
            .collect();
        for (name, value) in &shape.fixed {
            if names.contains(name) {
                continue;
            }
            let unit = fixed_unit(shape, channels, name);
            let error =
                nonlinear.iter().find(|(key, _)| key == name).map(|(_, error)| error / unit.si);
            parameters.push(Parameter {
                name: name.clone(),
                value: value / unit.si,
                standard_error: error.filter(|error| error.is_finite()),
                unit: unit.text,
            });
        }
        let scaled = |knots: &[f64], which: usize| {
            let si =
                shape.drivers.get(which).map_or(1.0, |driver| driver_unit(channels, driver).si);
            knots.iter().map(|knot| knot / si).collect()
        };
        Self {
            name: shape.name.clone(),
            known: shape.known,
            term: shape.acts,
            axis: None,
            quantity: None,
            drivers: shape.drivers.clone(),
            form: shape.form,
            knots: scaled(&shape.knots, 0),
            knots_2: scaled(&shape.knots_2, 1),
            parameters,
        }
    }

    /// Its shape and coefficients, SI. The error names what cannot be read.
    ///
    /// # Errors
    ///
    /// When a parameter is missing or its unit cannot be read.
    pub fn to_shape(&self, channels: &Channels) -> Result<(Shape, Vec<f64>), String> {
        let si = |parameter: &Parameter| {
            si_factor(&parameter.unit).map(|factor| parameter.value * factor).ok_or_else(|| {
                format!("term `{}`: unit `{}` is not known", self.name, parameter.unit)
            })
        };
        let knots = |knots: &[f64], which: usize| {
            let si = self.drivers.get(which).map_or(1.0, |driver| driver_unit(channels, driver).si);
            knots.iter().map(|knot| knot * si).collect()
        };
        let mut shape = Shape {
            name: self.name.clone(),
            known: self.known,
            acts: self.term,
            drivers: self.drivers.clone(),
            form: self.form,
            knots: knots(&self.knots, 0),
            knots_2: knots(&self.knots_2, 1),
            fixed: Vec::new(),
        };
        let names = coefficient_names(&shape);
        let mut coefficients = Vec::with_capacity(names.len());
        for name in &names {
            let parameter = self
                .parameter(name)
                .ok_or_else(|| format!("term `{}` lacks its parameter `{name}`", self.name))?;
            let value = si(parameter)?;
            coefficients.push(value);
            if self.form == Form::Delay {
                shape.set(name, value);
            }
        }
        for parameter in &self.parameters {
            if !names.contains(&parameter.name) {
                shape.set(&parameter.name, si(parameter)?);
            }
        }
        Ok((shape, coefficients))
    }
}
