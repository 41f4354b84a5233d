//! Identified models: loading by name, and conversion for controllers and emulated gyros.
//!
//! An identified model refers to fields by name, in the units of a data set. A controller corrects terms of its own
//! inputs, in SI units, and an emulated gyro adds terms of the true values. Terms that cannot be converted are
//! rejected, each with the reason, rather than left out.
//!
//! A model describes readings under the calibration that was in force when its data were recorded: its scale terms
//! apply on top of that calibration's factors.

mod driver;
mod form;
mod learned;
mod numbers;
mod sensor;
#[cfg(test)]
mod tests;

pub use learned::learned;
pub use sensor::{correction, reading, unit_of};

use crate::library::{Kind, Library, LibraryError};
use crate::{Action, Name, Plan, by_name};
use controller::calibration::Calibration;
use controller::correction::{Acts, Corrections, Driver, Form, TERMS_MAX, Term};
use identification::finding::{Finding, SCHEMA};
use identification::model::{self, Model};
use numbers::Numbers;
use std::collections::{BTreeMap, BTreeSet};

/// Why a model cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ModelError {
    /// Its file is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// It has another version of the contract.
    #[error("{origin}: schema {found}, expected {SCHEMA}")]
    Schema {
        /// The file.
        origin: String,
        /// The version in the file.
        found: u32,
    },
    /// Some of its terms cannot be converted.
    #[error("{origin}: {refused}")]
    Refused {
        /// The file.
        origin: String,
        /// The terms, with the reasons.
        refused: Refused,
    },
}

/// Terms that cannot be converted, each with its name and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refused(pub Vec<(String, String)>);

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, (name, why)) in self.0.iter().enumerate() {
            let stop = if index == 0 { "" } else { "; " };
            write!(f, "{stop}term `{name}` cannot be carried: {why}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Refused {}

/// Loads every model that `plan` uses and does not identify itself, except those in `made`.
///
/// # Errors
/// When one is missing or invalid, or a controller cannot apply it.
pub fn load(
    plan: &Plan,
    library: &Library,
    made: &BTreeMap<String, Model>,
) -> Result<BTreeMap<String, Model>, ModelError> {
    by_name::load(plan, (used, identified), made, |name| {
        let (origin, model) = read(library, name)?;
        if model.kind != identification::dataset::Kind::Sensor {
            corrections(&model).map_err(|refused| ModelError::Refused { origin, refused })?;
        }
        Ok(model)
    })
}

/// Names of the models that `plan` identifies.
pub fn made_by(plan: &Plan) -> BTreeSet<String> {
    by_name::names(plan, identified)
}

fn used(action: &Action) -> Option<&Name> {
    if let Action::UseModel(used) = action { used.name() } else { None }
}

fn identified(action: &Action) -> Option<&Name> {
    if let Action::Identify(identify) = action { Some(&identify.name) } else { None }
}

/// A model without terms.
pub const fn empty() -> Model {
    Model {
        schema: SCHEMA,
        kind: identification::dataset::Kind::Turns,
        dataset: None,
        fields: BTreeMap::new(),
        counts_per_rad_per_s: None,
        closing_lever_m: None,
        corrections: Vec::new(),
        compensation: None,
        compensation_also: Vec::new(),
        terms: Vec::new(),
        plain: Vec::new(),
    }
}

/// The file of a model, with a line that states its origin.
pub fn to_toml(model: &Model, origin: &str) -> String {
    format!("# {origin}\n{}", model.to_toml())
}

/// The file of a finding.
pub fn to_json(finding: &Finding) -> String {
    serde_json::to_string_pretty(finding).unwrap_or_default() + "\n"
}

/// Reads the model with this name or path.
///
/// # Errors
/// When it is missing or invalid.
pub fn read(library: &Library, name: &str) -> Result<(String, Model), ModelError> {
    let (origin, model): (String, Model) = library.read(Kind::Model, name)?;
    if model.schema == SCHEMA {
        Ok((origin, model))
    } else {
        Err(ModelError::Schema { origin, found: model.schema })
    }
}

/// The calibration in force, with its terms replaced by those of the model.
///
/// # Errors
/// All terms that a controller cannot correct.
pub fn calibration(model: &Model, in_force: &Calibration) -> Result<Calibration, Refused> {
    Ok(Calibration { corrections: corrections(model)?, ..in_force.clone() })
}

/// The corrections of a controller.
///
/// # Errors
/// All terms that a controller cannot correct.
pub fn corrections(model: &Model) -> Result<Corrections, Refused> {
    let mut corrections = Corrections::new();
    let mut refused = Vec::new();
    for fault in model.corrections.iter().filter(|fault| fault.is_effect()) {
        let why = format!("it is mended where `{}` is wired or read", fault.field);
        refused.push((format!("{:?}", fault.fault), why));
    }
    for term in &model.terms {
        let push = |term| {
            corrections
                .push(term)
                .map_err(|_| format!("a controller takes {TERMS_MAX} terms at most"))
        };
        let carried = acts(term)
            .and_then(|acts| translate(model, term, acts))
            .and_then(|terms| terms.into_iter().try_for_each(push));
        if let Err(why) = carried {
            refused.push((term.name.clone(), why));
        }
    }
    if refused.is_empty() { Ok(corrections) } else { Err(Refused(refused)) }
}

/// The quantity that a term acts on, if a controller can correct it.
fn acts(term: &model::Term) -> Result<Acts, String> {
    let why = match term.term {
        model::Acts::Bias => return Ok(Acts::Bias),
        model::Acts::Scale => return Ok(Acts::Scale),
        model::Acts::Delay => {
            "what comes late cannot be had earlier: a delay is not correctable online"
        }
        model::Acts::Clock => {
            "a clock that runs wrong is met by integrating over the host's time, not by a term"
        }
        model::Acts::DeadZone => "what a dead zone holds back is not in the readings",
        model::Acts::Saturation => "what was clipped is not in the readings",
        model::Acts::Quantisation | model::Acts::Noise => {
            "noise is only known afterwards: there is nothing to subtract"
        }
        model::Acts::Axis => "a reading of one axis does not tell the rotation about another",
        model::Acts::Reference => "it is an error of the reference, not of the gyro",
        model::Acts::Drive | model::Acts::Turn | model::Acts::Curvature | model::Acts::Slip => {
            "it is of the drive, and a calibration of a gyro has no place for it"
        }
    };
    Err(why.to_owned())
}

/// Converts a term of bias or scale to SI units. If a temperature passes through a play operator, the result is two
/// terms: one of the temperature, and one of the difference between the play's output and it.
fn translate(model: &Model, term: &model::Term, acts: Acts) -> Result<Vec<Term>, String> {
    let numbers = Numbers(term);
    let mut drivers = term.drivers.iter();
    let first = drivers.next().map(|driver| driver::of(model, driver, &numbers)).transpose()?;
    let second = drivers.next().map(|driver| driver::of(model, driver, &numbers)).transpose()?;
    if drivers.next().is_some() {
        return Err("it has more than two drivers".to_owned());
    }
    let form = form::of(term, first, second, &numbers)?;
    let driver = match form {
        Form::Constant { .. } => None,
        _ => first,
    };
    let driver = driver.unwrap_or_default();
    let through = numbers.or_zero("through")?;
    // Time goes on beyond every record, and with it what ages.
    let within =
        |which| term.limits(which).filter(|_| [first, second][which] != Some(Driver::Time));
    let [within, within_2] = [0, 1].map(within);
    let translated = match (driver, form) {
        (_, form) if through == 0.0 => vec![Term { acts, driver, form, within, within_2 }],
        (Driver::TemperatureBranch { .. }, Form::Linear { slope, origin }) => vec![
            // The play itself limits the difference.
            Term {
                acts,
                driver,
                form: Form::Linear { slope, origin: 0.0 },
                within: None,
                within_2: None,
            },
            Term {
                acts,
                driver: Driver::Temperature,
                form: Form::Linear { slope: slope * through, origin: origin / through },
                within,
                within_2: None,
            },
        ],
        _ => return Err("what goes through a play is carried where it is linear".to_owned()),
    };
    if translated.iter().all(Term::is_usable) {
        Ok(translated)
    } else {
        Err("its numbers are not usable: one is not finite, divides by nothing or does not rise"
            .to_owned())
    }
}
