//! Converts an identified model into errors of an emulated gyro.

use super::numbers::Numbers;
use super::{Refused, translate};
use controller::correction as seen;
use emulators::device_file::Learned;
use emulators::gyro::terms::{Acts, Driver, Form, Point, Term};
use identification::model::{self, Model, Wrap};
use std::f64::consts::TAU;
use wire::units::AngularRate;

/// A dead zone or a saturation that removes less than this share of the rate is a different effect. Assumption.
const GAIN_MIN: f64 = 0.5;

/// The errors of an emulated gyro according to `model`.
///
/// # Errors
/// All terms that an emulated gyro cannot represent.
pub fn learned(model: &Model) -> Result<Learned, Refused> {
    let mut learned = Learned::default();
    let mut refused = Vec::new();
    for term in &model.terms {
        if let Err(why) = add(model, term, &mut learned) {
            refused.push((term.name.clone(), why));
        }
    }
    if refused.is_empty() { Ok(learned) } else { Err(Refused(refused)) }
}

fn add(model: &Model, term: &model::Term, learned: &mut Learned) -> Result<(), String> {
    let numbers = Numbers(term);
    let deg_per_s = |value| AngularRate::from_rad_per_s(value).deg_per_s();
    let (name, value) = match term.term {
        model::Acts::Bias | model::Acts::Scale => {
            let acts = match term.term {
                model::Acts::Bias => seen::Acts::Bias,
                _ => seen::Acts::Scale,
            };
            for term in translate(model, term, acts)? {
                learned.terms.push(truth(term)?);
            }
            return Ok(());
        }
        model::Acts::Delay if term.drivers.iter().any(|driver| driver.wrap == Wrap::LagOf) => {
            ("bandwidth_hz", 1.0 / (TAU * numbers.get("time_constant")?))
        }
        model::Acts::Delay => ("latency_s", numbers.get("delay")?),
        model::Acts::DeadZone | model::Acts::Saturation
            if numbers.has("gain") && numbers.get("gain")? < GAIN_MIN =>
        {
            return Err("it holds back only a part, which an emulated gyro does not".to_owned());
        }
        model::Acts::Saturation if ends_differ(&numbers)? => {
            return Err("its range ends differ, and an emulated gyro has one for both".to_owned());
        }
        model::Acts::DeadZone => ("dead_zone_deg_per_s", deg_per_s(numbers.get("width")?)),
        model::Acts::Saturation => ("range_deg_per_s", deg_per_s(numbers.get("limit")?)),
        other => return Err(format!("an emulated gyro learns nothing of `{other:?}`")),
    };
    learned.parameters.insert(name.to_owned(), value);
    Ok(())
}

/// Ends of a range that differ by more than this share of it cannot belong to a symmetric range with a bias.
/// Assumption.
const ENDS_MAX: f64 = 0.05;

fn ends_differ(numbers: &Numbers<'_>) -> Result<bool, String> {
    if !numbers.has("lower_limit") {
        return Ok(false);
    }
    let (upper, lower) = (numbers.get("limit")?, numbers.get("lower_limit")?);
    Ok((upper + lower).abs() > ENDS_MAX * (upper - lower).abs())
}

/// Converts a controller's correction term into a term of true values.
fn truth(term: seen::Term) -> Result<Term, String> {
    Ok(Term {
        acts: match term.acts {
            seen::Acts::Bias => Acts::Bias,
            seen::Acts::Scale => Acts::Scale,
        },
        driver: driver(term.driver)?,
        within: term.within,
        within_2: term.within_2,
        form: match term.form {
            seen::Form::Constant { value } => Form::Constant { value },
            seen::Form::Linear { slope, origin } => Form::Linear { slope, origin },
            seen::Form::Quadratic { coefficient, origin } => {
                Form::Quadratic { coefficient, origin }
            }
            seen::Form::Cubic { coefficient, origin } => Form::Cubic { coefficient, origin },
            seen::Form::Exponential { amplitude, time_constant } => {
                Form::Exponential { amplitude, time_constant }
            }
            seen::Form::Harmonic { order, cos, sin } => Form::Harmonic { order, cos, sin },
            seen::Form::Periodic { cos, sin, period } => Form::Periodic { cos, sin, period },
            seen::Form::Step { size, at } => Form::Step { size, at },
            seen::Form::Hinge { slope, at } => Form::Hinge { slope, at },
            seen::Form::Bump { height, centre, width } => Form::Bump { height, centre, width },
            seen::Form::Tanh { height, centre, width } => Form::Tanh { height, centre, width },
            seen::Form::Table { points } => Form::Table {
                points: points.iter().map(|&seen::Point { x, value }| Point { x, value }).collect(),
            },
            seen::Form::Product { coefficient, origin, second, origin_2 } => {
                Form::Product { coefficient, origin, second: driver(second)?, origin_2 }
            }
        },
    })
}

fn driver(driver: seen::Driver) -> Result<Driver, String> {
    Ok(match driver {
        seen::Driver::None => Driver::None,
        seen::Driver::Temperature => Driver::Temperature,
        seen::Driver::TemperatureRate => Driver::TemperatureRate,
        seen::Driver::TemperatureLag { time_constant_s } => {
            Driver::TemperatureLag { time_constant_s }
        }
        seen::Driver::TemperatureBranch { half_width_kelvin } => {
            Driver::TemperatureBranch { half_width_kelvin }
        }
        seen::Driver::Rate => Driver::Rate,
        seen::Driver::AbsRate => Driver::AbsRate,
        seen::Driver::Direction => Driver::Direction,
        seen::Driver::Heading => Driver::Heading,
        seen::Driver::Time => Driver::Time,
        seen::Driver::TestedBias => {
            return Err(
                "an emulated gyro does not know what bias a controller subtracts".to_owned()
            );
        }
        seen::Driver::Uptime => {
            return Err("an emulated gyro does not know how long a controller has run".to_owned());
        }
    })
}
