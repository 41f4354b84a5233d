//! Converts an identified model into errors of an emulated gyro.

use super::numbers::Numbers;
use super::{Refused, translate};
use controller::correction as seen;
use emulators::device_file::Learned;
use emulators::gyro::terms::Term;
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
                learned.terms.push(truth(&term)?);
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

/// Converts a controller's correction term into a term of true values, which a device file writes in the same way.
fn truth(term: &seen::Term) -> Result<Term, String> {
    is_known(term.driver)?;
    if let seen::Form::Product { second, .. } = term.form {
        is_known(second)?;
    }
    let written = serde_json::to_value(term).and_then(serde_json::from_value);
    written.map_err(|error| error.to_string())
}

/// Whether an emulated gyro has such an input.
fn is_known(driver: seen::Driver) -> Result<(), String> {
    let unknown = match driver {
        seen::Driver::TestedBias => "what bias a controller subtracts",
        seen::Driver::Uptime => "how long a controller has run",
        _ => return Ok(()),
    };
    Err(format!("an emulated gyro does not know {unknown}"))
}
