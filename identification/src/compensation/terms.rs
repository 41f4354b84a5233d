//! What terms add to a reading, as formulas over what firmware knows.

use super::formula::{Formula, call, number};
use super::program::{Input, Program};
use crate::model::{Acts, Driver, Form, SPLINE_REACH, Shape, Wrap, spline_pieces};
use std::f64::consts::TAU;

/// Meaning and units of field names.
pub(super) struct Fields<'a> {
    /// Name of the field of the reference.
    pub(super) reference: &'a str,
    /// Name of the field of time.
    pub(super) time: &'a str,
    /// One of a field's unit, in SI.
    pub(super) si: &'a dyn Fn(&str) -> f64,
    /// What firmware reads of a field.
    pub(super) read: &'a dyn Fn(&str) -> String,
    /// Low-pass length of slopes, in readings.
    pub(super) smoothing: f64,
}

/// Why a term has no formula.
pub(super) type Refused = String;

/// Whether the term depends on the measured quantity.
pub(super) fn sees_reference(shape: &Shape, fields: &Fields<'_>) -> bool {
    shape.acts == Acts::Scale
        || matches!(shape.form, Form::DeadZone | Form::Saturation)
        || shape.drivers.iter().any(|driver| fields.is_reference(driver))
}

impl Fields<'_> {
    fn is_reference(&self, driver: &Driver) -> bool {
        // The other two are names from older models.
        [self.reference, crate::problem::ROTATION, "table_rate"].contains(&driver.field.as_str())
    }
}

/// What the term adds to the reading, SI, by the `estimate` of what is measured.
pub(super) fn adds(
    program: &mut Program,
    (shape, coefficients): (&Shape, &[f64]),
    estimate: &Formula,
    fields: &Fields<'_>,
) -> Result<Formula, Refused> {
    let value = match shape.form {
        Form::Constant => number(coefficient(coefficients, 0)?),
        _ => {
            let x = seen(program, (shape, 0), estimate, fields)?;
            form(program, (shape, coefficients), x, estimate, fields)?
        }
    };
    match shape.acts {
        Acts::Bias | Acts::Axis | Acts::DeadZone | Acts::Saturation => Ok(value),
        Acts::Scale => Ok(value * estimate.clone()),
        other => Err(format!("a sensor has no place for `{other:?}`")),
    }
}

fn coefficient(coefficients: &[f64], place: usize) -> Result<f64, Refused> {
    coefficients.get(place).copied().ok_or_else(|| "a number of it is missing".to_owned())
}

fn fixed(shape: &Shape, name: &str) -> Result<f64, Refused> {
    shape.number(name).ok_or_else(|| format!("its `{name}` is missing"))
}

/// Value of a driver of the shape, SI.
fn seen(
    program: &mut Program,
    (shape, which): (&Shape, usize),
    estimate: &Formula,
    fields: &Fields<'_>,
) -> Result<Formula, Refused> {
    let driver = shape.drivers.get(which).ok_or("it lacks a driver")?;
    let plain = if fields.is_reference(driver) {
        estimate.clone()
    } else if driver.field == fields.time || driver.field == "time" {
        program.input(Input::Time)
    } else {
        let field = (fields.read)(&driver.field);
        let si = (fields.si)(&field);
        program.input(Input::Field(field)) * number(si)
    };
    let value = match driver.wrap {
        Wrap::Plain | Wrap::Harmonic(_) | Wrap::Step | Wrap::Periodic | Wrap::Trend => plain,
        Wrap::Abs => call("abs", [plain]),
        Wrap::Sign => call("sign", [plain]),
        Wrap::RateOf => {
            let level = program.step("level", plain);
            slope(program, &level, fields.smoothing)
        }
        Wrap::LagOf => {
            // Of a heat the square lags, and is the whole of the form.
            let level = program.step("level", plain.power(if shape.is_heat() { 2 } else { 1 }));
            lagged(program, &level, fixed(shape, "time_constant")?)
        }
        Wrap::BranchOf => {
            let level = program.step("level", plain);
            let play = |before: Formula| {
                let half = number(fixed(shape, "half_width").unwrap_or(0.0));
                let ends = [level.clone() - half.clone(), level.clone() + half];
                let [low, high] = ends;
                call("clamp", [before, low, high])
            };
            fixed(shape, "half_width")?;
            let play = program.remembering("play", level.clone(), play);
            let own = 1.0 - shape.number("through").unwrap_or(0.0);
            play - number(own) * level
        }
    };
    Ok(match shape.limits(which) {
        Some([low, high]) => call("clamp", [value, number(low), number(high)]),
        None => value,
    })
}

/// Slope of `level`, low-passed over that many readings.
pub(super) fn slope(program: &mut Program, level: &Formula, smoothing: f64) -> Formula {
    let Formula::Now(name) = level else { return number(0.0) };
    let interval = program.input(Input::Interval);
    let rough = (level.clone() - Formula::Before(*name)) / interval;
    let share = number(1.0 / (1.0 + smoothing));
    program.remembering("slope", number(0.0), |before| {
        if smoothing == 0.0 { rough } else { before.clone() + (rough - before) * share }
    })
}

/// `angle` wrapped to within half a turn of zero.
pub(super) fn within_half(angle: Formula) -> Formula {
    let turns = angle.clone() / number(TAU) + number(0.5);
    angle - number(TAU) * call("floor", [turns])
}

/// `level` through a first-order lag.
pub(super) fn lagged(program: &mut Program, level: &Formula, time_constant: f64) -> Formula {
    let Formula::Now(name) = level else { return level.clone() };
    let interval = program.input(Input::Interval);
    // The input is linear between readings, so its mean counts.
    let mean = (level.clone() + Formula::Before(*name)) * number(0.5);
    let keeps = call("exp", [interval * number(-1.0 / time_constant)]);
    program.remembering("lagged", level.clone(), |before| mean.clone() + (before - mean) * keeps)
}

fn form(
    program: &mut Program,
    (shape, coefficients): (&Shape, &[f64]),
    x: Formula,
    estimate: &Formula,
    fields: &Fields<'_>,
) -> Result<Formula, Refused> {
    let one = || coefficient(coefficients, 0).map(number);
    let two = || Ok::<_, Refused>([0, 1].map(|i| coefficient(coefficients, i).map(number)));
    let origin = number(shape.number("origin").unwrap_or(0.0));
    let get = |name: &str| fixed(shape, name).map(number);
    let waves = |angle: Formula, [even, odd]: [Result<Formula, Refused>; 2]| {
        Ok::<_, Refused>(even? * call("cos", [angle.clone()]) + odd? * call("sin", [angle]))
    };
    Ok(match shape.form {
        Form::Constant => one()?,
        Form::Linear => one()? * (x - origin),
        Form::Quadratic if shape.is_heat() => one()? * x,
        Form::Quadratic => one()? * (x - origin).power(2),
        Form::Cubic => one()? * (x - origin).power(3),
        Form::Exponential => {
            one()? * call("exp", [x * number(-1.0 / fixed(shape, "time_constant")?)])
        }
        Form::Harmonic => {
            let order = match shape.drivers.first().map(|driver| driver.wrap) {
                Some(Wrap::Harmonic(order)) => f64::from(order),
                _ => 1.0,
            };
            waves(x * number(order), two()?)?
        }
        Form::Periodic => waves(x * number(TAU / fixed(shape, "period")?), two()?)?,
        Form::Step => one()? * call("at_least", [x, get("at")?]),
        Form::Hinge => one()? * call("max", [number(0.0), x - get("at")?]),
        Form::Bump => {
            let from = (x - get("centre")?) / get("width")?;
            one()? * call("exp", [number(-0.5) * from.power(2)])
        }
        Form::Tanh => one()? * call("tanh", [(x - get("centre")?) / get("width")?]),
        Form::Spline => spline(program, shape, coefficients, x),
        Form::Product => {
            let y = seen(program, (shape, 1), estimate, fields)?;
            let origin_2 = number(shape.number("origin_2").unwrap_or(0.0));
            one()? * (x - origin) * (y - origin_2)
        }
        Form::DeadZone => {
            let inside = call("at_least", [get("width")?, call("abs", [x.clone()])]);
            one()? * inside * (number(0.0) - x)
        }
        Form::Saturation => {
            let limit = fixed(shape, "limit")?;
            let lower = shape.number("lower_limit").unwrap_or(-limit);
            let clipped = call("clamp", [x.clone(), number(lower), number(limit)]);
            one()? * (clipped - x)
        }
        Form::Delay => return Err("it is no sum of terms".to_owned()),
        Form::Surface => return Err("a surface over two inputs has no short formula".to_owned()),
    })
}

/// A natural cubic spline as a straight line plus a bend at each knot, in a coordinate from 0 to 1.
fn spline(program: &mut Program, shape: &Shape, values: &[f64], x: Formula) -> Formula {
    let (knots, length) = match (shape.knots.first(), shape.knots.last()) {
        (Some(first), Some(last)) if last > first => (&shape.knots, last - first),
        _ => return number(values.first().copied().unwrap_or(0.0)),
    };
    let places: Vec<f64> = knots.iter().map(|knot| (knot - knots[0]) / length).collect();
    let (slope, bends) = spline_pieces(&places, values);
    let place = (x - number(knots[0])) / number(length);
    let ends = [number(-SPLINE_REACH), number(1.0 + SPLINE_REACH)];
    let [low, high] = ends;
    let place = program.step("place", call("clamp", [place, low, high]));
    let line = number(values[0]) + number(slope) * place.clone();
    bends.iter().zip(&places).fold(line, |sum, (bend, at)| {
        let beyond = call("max", [number(0.0), place.clone() - number(*at)]);
        sum + number(*bend) * beyond.power(3)
    })
}
