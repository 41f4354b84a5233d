//! Converts shapes with numbers in SI to terms in the units of the data, and back.
//!
//! A place on the axis of a field is in the field's own unit, a difference along it in the unit of differences: a
//! temperature is in `Cel`, the width of a bump over it in `K`.

use super::see::{Field, fixed_or};
use super::{
    Acts, Driver, Form, LATE_SHARE, SEEN, Shape, Term, Wrap, exposure, field, range_of, see,
};
use crate::dataset::Axis;
use crate::finding::Parameter;
use crate::problem::{Block, Channels, DisplayUnit};
use crate::units::{per, si_factor};

/// Parameters that carry the unit of the knots, with the value 1.
pub const KNOT: [&str; 2] = ["knot", "knot_2"];

/// Whether the parameter of that name is a place on the axis of a driver, and not a size.
pub fn is_place(name: &str) -> bool {
    ["origin", "origin_2"].contains(&name) || is_frame(name)
}

/// Whether it states the unit of knots or the observed range.
pub fn is_frame(name: &str) -> bool {
    KNOT.contains(&name) || SEEN.as_flattened().contains(&name)
}

/// Whether a coefficient alone states how much the term does, so that the range of the term is its own.
fn told_by_itself(shape: &Shape) -> bool {
    let set_right = ["reversed", "degrees_for", "radians_for"];
    let is_fault = set_right.iter().any(|start| shape.name.starts_with(start));
    (matches!(shape.form, Form::Constant | Form::Delay) || shape.acts == Acts::Axis) && !is_fault
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

/// Whether the number is a place where the contribution of `shape` jumps.
pub fn is_threshold(shape: &Shape, name: &str) -> bool {
    matches!((shape.form, name), (Form::Step, "at") | (Form::DeadZone, "width"))
}

/// Values of the driver that a threshold of `shape` can lie between, in order.
pub fn levels(shape: &Shape, channels: &Channels) -> Option<Vec<f64>> {
    let values = see(channels, shape.drivers.first()?, &shape.fixed)?;
    let size = |value: f64| if shape.form == Form::DeadZone { value.abs() } else { value };
    let finite = values.iter().copied().filter(|value| value.is_finite());
    let mut found: Vec<f64> = finite.map(size).collect();
    found.sort_by(f64::total_cmp);
    found.dedup();
    Some(found)
}

/// Standard error of a threshold from the rows alone, which only say between which values of its driver it lies.
fn between_rows(shape: &Shape, channels: &Channels, at: f64) -> Option<f64> {
    let levels = levels(shape, channels)?;
    let above = levels.partition_point(|level| *level < at);
    let low = levels.get(above.checked_sub(1)?)?;
    Some((levels.get(above)? - low) / 12.0_f64.sqrt())
}

/// Parameters that are lengths of something.
const LENGTHS: [&str; 3] = ["time_constant", "half_width", "period"];

impl Term {
    /// The term of `shape` with its coefficients and their standard errors, SI, NaN where one was not fitted; `nonlinear`
    /// holds the errors of its other fitted numbers.
    pub fn from_shape(
        shape: &Shape,
        coefficients: &[(f64, f64)],
        nonlinear: &[(String, f64)],
        unit: &DisplayUnit,
        channels: &Channels,
    ) -> Self {
        let written = coefficient_unit(shape, channels, unit);
        let names = coefficient_names(shape);
        let mut parameters: Vec<Parameter> = names
            .iter()
            .zip(coefficients)
            .map(|(name, (value, error))| Parameter {
                standard_error: error.is_finite().then_some(error / written.si),
                range: (told_by_itself(shape) && !channels.of_sensor)
                    .then(|| range_of(shape, channels))
                    .flatten()
                    .map(|range| range.map(|end| end / written.si)),
                ..Parameter::new(name, value / written.si, &written.text)
            })
            .collect();
        for (name, value) in &shape.fixed {
            if names.contains(name) {
                continue;
            }
            let unit = fixed_unit(shape, channels, name);
            let error = nonlinear.iter().find(|(key, _)| key == name).map(|(_, error)| *error);
            let error = match is_threshold(shape, name) {
                true => between_rows(shape, channels, *value)
                    .map(|rows| rows.hypot(error.unwrap_or(0.0))),
                false => error,
            };
            let error = error.map(|error| error / unit.si);
            parameters.push(Parameter {
                standard_error: error.filter(|error| error.is_finite()),
                ..Parameter::new(name, value / unit.si, &unit.text)
            });
        }
        let mut scaled = |knots: &[f64], which: usize| {
            if knots.is_empty() {
                return Vec::new();
            }
            let unit = place_unit(channels, shape, which);
            let knots = knots.iter().map(|knot| knot / unit.si).collect();
            parameters.push(Parameter::new(KNOT[which], 1.0, &unit.text));
            knots
        };
        let (knots, knots_2) = (scaled(&shape.knots, 0), scaled(&shape.knots_2, 1));
        Self {
            name: shape.name.clone(),
            known: shape.known,
            term: shape.acts,
            axis: None,
            quantity: None,
            drivers: shape.drivers.clone(),
            form: shape.form,
            knots,
            knots_2,
            parameters,
        }
    }

    /// Whether it is a term of `block`.
    pub fn applies_to(&self, block: &Block) -> bool {
        let is_here = self.quantity.is_none() || self.quantity == block.apart;
        is_here && Axis::agree(self.axis, block.axis) && exposure(block, self.term).is_some()
    }

    /// Limits of that driver, SI, beyond which the term is constant, if its observed range is set.
    pub fn limits(&self, driver: usize) -> Option<[f64; 2]> {
        let end = |name: &str| {
            let parameter = self.parameter(name)?;
            Some(parameter.value * si_factor(&parameter.unit)?)
        };
        let [from, to] = SEEN.get(driver)?;
        Some(self.form.held([end(from)?, end(to)?]))
    }

    /// Its shape and coefficients, SI. The error names what cannot be read.
    ///
    /// # Errors
    ///
    /// When a parameter is missing or its unit cannot be read.
    pub fn to_shape(&self, channels: &Channels) -> Result<(Shape, Vec<f64>), String> {
        let si = |parameter: &Parameter| {
            let Parameter { name, value, unit, .. } = parameter;
            if LENGTHS.contains(&name.as_str()) && !(*value >= 0.0) {
                return Err(format!(
                    "term `{}`: its `{name}` is {value} {unit}: expected zero or more",
                    self.name
                ));
            }
            let factor = si_factor(unit);
            factor
                .map(|factor| value * factor)
                .ok_or_else(|| format!("term `{}`: unit `{unit}` is not known", self.name))
        };
        let mut shape = Shape {
            name: self.name.clone(),
            known: self.known,
            acts: self.term,
            drivers: self.drivers.clone(),
            form: self.form,
            knots: self.knots.clone(),
            knots_2: self.knots_2.clone(),
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
            if !names.contains(&parameter.name) && !KNOT.contains(&parameter.name.as_str()) {
                shape.set(&parameter.name, si(parameter)?);
            }
        }
        let scale = |which: usize| match self.parameter(KNOT[which]) {
            Some(said) => si(said),
            // Without a stated unit, that of the field.
            None => Ok(place_unit(channels, &shape, which).si),
        };
        let scales = [scale(0)?, scale(1)?];
        for (knots, scale) in [(&mut shape.knots, scales[0]), (&mut shape.knots_2, scales[1])] {
            knots.iter_mut().for_each(|knot| *knot *= scale);
        }
        Ok((shape, coefficients))
    }
}

/// Unit of a driver's differences, as written and in SI.
pub fn difference_unit(channels: &Channels, driver: &Driver) -> DisplayUnit {
    unit(channels, driver, crate::dataset::Unit::difference_text)
}

/// Unit of places on the axis of the `which`th driver of `shape`, as written and in SI. A rate of change and the
/// distance of a play from its input are differences.
pub fn place_unit(channels: &Channels, shape: &Shape, which: usize) -> DisplayUnit {
    let Some(driver) = shape.drivers.get(which) else {
        return DisplayUnit::new(channels.time_unit.text(), 1.0);
    };
    let is_difference = match driver.wrap {
        Wrap::RateOf => true,
        Wrap::BranchOf => fixed_or(&shape.fixed, "through", 0.0) == 0.0,
        _ => false,
    };
    if is_difference {
        difference_unit(channels, driver)
    } else {
        unit(channels, driver, crate::dataset::Unit::text)
    }
}

fn unit(
    channels: &Channels,
    driver: &Driver,
    text: impl Fn(crate::dataset::Unit) -> &'static str,
) -> DisplayUnit {
    let plain = match field(channels, driver) {
        Some(Field::Rotation) => {
            DisplayUnit::new(channels.rotation_unit.text(), channels.rotation_unit.si())
        }
        Some(Field::Channel(channel)) => DisplayUnit::new(text(channel.unit), channel.unit.si()),
        Some(Field::Time) => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Some(Field::Direction) | None => DisplayUnit::one(),
    };
    match driver.wrap {
        Wrap::RateOf => DisplayUnit::new(&per(&plain.text, channels.time_unit.text()), plain.si),
        Wrap::Sign => DisplayUnit::one(),
        _ => plain,
    }
}

/// Unit of a number of `shape` that is not a coefficient.
pub fn fixed_unit(shape: &Shape, channels: &Channels, name: &str) -> DisplayUnit {
    let time = DisplayUnit::new(channels.time_unit.text(), 1.0);
    match name {
        "time_constant" | "delay" => time,
        "stretch" | "through" | LATE_SHARE => DisplayUnit::one(),
        "origin" | "at" | "centre" | "seen_from" | "seen_to" => place_unit(channels, shape, 0),
        "origin_2" | "seen_from_2" | "seen_to_2" => place_unit(channels, shape, 1),
        _ => shape.drivers.first().map_or(time, |driver| difference_unit(channels, driver)),
    }
}

/// Unit of the coefficients of a shape, where a term's own unit is `unit`.
pub fn coefficient_unit(shape: &Shape, channels: &Channels, unit: &DisplayUnit) -> DisplayUnit {
    let drivers: Vec<DisplayUnit> =
        shape.drivers.iter().map(|driver| difference_unit(channels, driver)).collect();
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
        Form::Delay if shape.acts == Acts::Clock => DisplayUnit::one(),
        Form::Delay => DisplayUnit::new(channels.time_unit.text(), 1.0),
        Form::DeadZone | Form::Saturation => DisplayUnit::one(),
        _ => unit.clone(),
    }
}
