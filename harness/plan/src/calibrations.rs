//! Calibrations by name: made by a plan, stored beside it, or shipped.

use crate::library::{Kind, Library, LibraryError};
use crate::{Action, Name, Plan, by_name};
use controller::calibration::Calibration;
use std::collections::{BTreeMap, BTreeSet};

/// Why a calibration cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum CalibrationError {
    /// Its file is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// Its values are implausible.
    #[error("{origin}: not a credible calibration of a gyro")]
    NotCredible {
        /// The file.
        origin: String,
    },
}

/// Loads every calibration that `plan` uses and does not make itself, except those in `made`.
///
/// # Errors
/// When one is missing or invalid.
pub fn load(
    plan: &Plan,
    library: &Library,
    made: &BTreeMap<String, Calibration>,
) -> Result<BTreeMap<String, Calibration>, CalibrationError> {
    by_name::load(plan, (used, saved), made, |name| read(library, name))
}

/// Names of the calibrations that `plan` makes.
pub fn made_by(plan: &Plan) -> BTreeSet<String> {
    by_name::names(plan, saved)
}

fn used(action: &Action) -> Option<&Name> {
    if let Action::UseCalibration(used) = action { used.name() } else { None }
}

fn saved(action: &Action) -> Option<&Name> {
    if let Action::SaveCalibration(saved) = action { Some(&saved.name) } else { None }
}

fn read(library: &Library, name: &str) -> Result<Calibration, CalibrationError> {
    let (origin, calibration): (String, Calibration) = library.read(Kind::Calibration, name)?;
    if calibration.is_usable() {
        Ok(calibration)
    } else {
        Err(CalibrationError::NotCredible { origin })
    }
}

/// The file of a calibration, with a line that states its origin.
pub fn to_toml(calibration: &Calibration, origin: &str) -> String {
    let body = toml::to_string(calibration).unwrap_or_default();
    format!("# {origin}\n{body}")
}

#[cfg(test)]
mod tests {
    use super::{Calibration, to_toml};
    use controller::calibration::{BiasPoint, Factor};

    #[test]
    fn a_calibration_comes_back_from_its_file() {
        let mut calibration = Calibration::default();
        let line = Factor::TemperatureLine { slope_deg_per_celsius: -0.52, intercept_deg: 19.23 };
        for factor in [
            line,
            Factor::Constant(1.01),
            Factor::Direction { cw_error_deg: -1.0, ccw_error_deg: 2.0 },
        ] {
            calibration.factors.push(factor).unwrap();
        }
        calibration.bias_table.push(BiasPoint { celsius: 20.0, bias_deg_per_s: 0.01 }).unwrap();
        let text = to_toml(&calibration, "by hand");
        insta::assert_snapshot!(text, @r#"
        # by hand
        scale = 1.0

        [[factors]]

        [factors.temperature_line]
        slope_deg_per_celsius = -0.52
        intercept_deg = 19.23

        [[factors]]
        constant = 1.01

        [[factors]]

        [factors.direction]
        cw_error_deg = -1.0
        ccw_error_deg = 2.0

        [[bias_table]]
        celsius = 20.0
        bias_deg_per_s = 0.01
        "#);
        assert_eq!(toml::from_str::<Calibration>(&text).unwrap(), calibration);
    }
}
