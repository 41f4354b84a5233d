//! A signal that is read from a sensor of a rate, which errs as an identified model says.

use super::formula;
use super::source::Source;
use super::variables::Variables;
use crate::error::Mistake;
use crate::expression::Expression;
use crate::file::{Formula, SourceTable};
use crate::files::Files;
use crate::place::Place;
use emulators::gyro::terms::SensorErrors;
use std::f64::consts::PI;

/// Units of rates, as layouts write them, in rad/s.
const UNITS: [(&str, f64); 8] = [
    ("rad/s", 1.0),
    ("mrad/s", 1e-3),
    ("deg/s", PI / 180.0),
    ("°/s", PI / 180.0),
    ("dps", PI / 180.0),
    ("mdeg/s", PI / 180e3),
    ("deg/h", PI / 648e3),
    ("°/h", PI / 648e3),
];

/// A sensor of a rate.
#[derive(Debug, Clone)]
pub(crate) struct RateSensor {
    pub(crate) errors: SensorErrors,
    /// What one of the signal's unit is, rad/s.
    pub(crate) unit: f64,
    /// The true rate, in the signal's unit.
    pub(crate) truth: Source,
    /// degC
    pub(crate) temperature: Expression,
    /// deg
    pub(crate) heading: Expression,
}

/// The sensor that a `[signal.NAME]` with a `model` describes: that of `truth`, with the model's file and the signal's
/// unit.
pub(super) fn sensor(
    table: &SourceTable,
    truth: Source,
    (file, unit): (&str, &str),
    variables: &Variables,
    place: &Place,
    files: &mut dyn Files,
) -> Result<RateSensor, Mistake> {
    let Some((_, unit)) = UNITS.into_iter().find(|(known, _)| *known == unit) else {
        let known = UNITS.map(|(known, _)| known).join(", ");
        let message = format!("a model is of a rate, and the unit of this signal is `{unit}`");
        return Err(Mistake::new(place.key("model"), message).help(format!("one of {known}")));
    };
    let errors = files.errors(file).map_err(|error| {
        Mistake::new(place.key("model"), format!("failed to use `{file}`: {error}"))
    })?;
    let seen = |key: &str, given: &Option<Formula>, needed: bool| match given {
        Some(given) => formula(given, variables, &place.key(key)),
        None if needed => {
            let message = format!("the model sees a {key}, and there is none");
            Err(Mistake::new(place.key("model"), message)
                .help(format!("add `{key} = \"...\"` to the signal")))
        }
        None => Ok(Expression::constant(0.0)),
    };
    let temperature = seen("temperature", &table.temperature, errors.see_temperature())?;
    let heading = seen("heading", &table.heading, errors.see_heading())?;
    Ok(RateSensor { errors, unit, truth, temperature, heading })
}
