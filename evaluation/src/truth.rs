//! The true causes of the data, their spellings in a finding, and whether a finding names them.
//!
//! A truth is written `term: driver + driver`. In place of drivers, `*` means that the term alone settles the cause (a
//! delay is a delay, whatever field it names), and `=` that no field modulates it: it has no drivers, or only those of
//! the motion itself.

use crate::quantity::Quantity;
use identification::finding::{Effect, Parameter, Rival};

/// Names that a constant error of the motion may carry as its own driver.
const MOTION: &[&str] = &[
    "",
    "constant",
    "distance",
    "drive_distance",
    "steer_angle",
    "wheel_left",
    "wheel_right",
    "speed",
    "rotation",
    "turn",
    "heading_change",
    "odometry_heading",
    "reference_angle",
    "reference_rate",
    "abs(distance)",
    "abs(drive_distance)",
];

/// One cause, in every structurally equivalent spelling.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// Name in the tables.
    pub effect: String,
    /// Its spellings, `term: drivers`.
    pub spellings: Vec<String>,
    /// A parameter with a known value, if the form has one that does not depend on its spelling.
    pub value: Option<TrueValue>,
}

/// A true parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueValue {
    /// In `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Names it may have; if none matches, the only fitted parameter of its dimension counts.
    pub names: &'static [&'static str],
}

impl Truth {
    /// Whether `term` and `drivers` name it.
    pub fn is_named_by(&self, term: &str, drivers: &[String]) -> bool {
        self.spellings.iter().any(|spelling| matches(spelling, term, drivers))
    }

    /// Whether the effect itself names it.
    pub fn is_effect(&self, effect: &Effect) -> bool {
        self.is_named_by(&effect.term, &effect.drivers)
    }

    /// Whether the effect or one of its rivals names it.
    pub fn is_within(&self, effect: &Effect) -> bool {
        let rival = |rival: &Rival| self.is_named_by(&rival.term, &rival.drivers);
        self.is_effect(effect) || effect.rivals.iter().any(rival)
    }

    /// Whether the true value lies within 1.96 standard errors of the fitted one. `None` if the finding has no such
    /// parameter.
    pub fn is_covered_by(&self, parameters: &[Parameter]) -> Option<bool> {
        /// Half of the normal 95 % interval, in standard errors.
        const NORMAL_95: f64 = 1.959_963_984_540_054;
        let truth = self.value.as_ref()?;
        let unit = Quantity::parse(truth.unit)?;
        let fitted: Vec<(&Parameter, f64, f64)> = parameters
            .iter()
            .filter_map(|parameter| {
                let found = Quantity::parse(&parameter.unit)?;
                let error = parameter.standard_error?;
                (found.powers == unit.powers).then_some((parameter, error, found.si))
            })
            .collect();
        let named =
            fitted.iter().find(|(parameter, ..)| truth.names.contains(&parameter.name.as_str()));
        let &(parameter, error, si) = match (named, fitted.as_slice()) {
            (Some(named), _) => named,
            (None, [only]) => only,
            _ => return None,
        };
        Some((parameter.value * si - truth.value * unit.si).abs() <= NORMAL_95 * error * si)
    }
}

fn matches(spelling: &str, term: &str, drivers: &[String]) -> bool {
    let Some((wanted, of)) = spelling.split_once(": ") else { return false };
    if wanted != term {
        return false;
    }
    let mut found: Vec<String> = drivers.iter().map(|driver| driver.replace(' ', "")).collect();
    found.sort_unstable();
    match of {
        "*" => true,
        "=" => found.iter().all(|driver| MOTION.contains(&driver.as_str())),
        _ => {
            let mut wanted: Vec<&str> = of.split(" + ").collect();
            wanted.sort_unstable();
            wanted == found
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth() -> Truth {
        let spellings = ["bias: rate_of(temperature)", "scale: a + b", "drive: =", "delay: *"];
        Truth {
            effect: "shupe".into(),
            spellings: spellings.map(String::from).to_vec(),
            value: Some(TrueValue { value: 0.5, unit: "deg/s/(K/s)", names: &["h"] }),
        }
    }

    fn parameter(name: &str, value: f64, error: Option<f64>, unit: &str) -> Parameter {
        Parameter {
            name: name.into(),
            value,
            standard_error: error,
            unit: unit.into(),
            range: None,
        }
    }

    #[test]
    fn a_cause_is_recognised_by_term_and_drivers() {
        let named = |term: &str, drivers: &[&str]| {
            truth().is_named_by(term, &drivers.iter().map(|&d| d.to_owned()).collect::<Vec<_>>())
        };
        assert!(named("bias", &["rate_of(temperature)"]));
        assert!(named("scale", &["b", "a"]), "the order of drivers says nothing");
        assert!(named("drive", &[]) && named("drive", &["wheel_right", "wheel_left"]));
        assert!(named("delay", &["reference_rate"]));
        assert!(!named("drive", &["time"]));
        assert!(!named("bias", &["temperature"]) && !named("scale", &["rate_of(temperature)"]));
        assert!(!named("scale", &["a"]) && !named("bias", &[]));
    }

    #[test]
    fn coverage_converts_units_and_says_when_it_cannot() {
        let covered = |parameters: &[Parameter]| truth().is_covered_by(parameters);
        assert_eq!(covered(&[parameter("h", 0.55, Some(0.03), "deg/K")]), Some(true));
        assert_eq!(covered(&[parameter("h", 0.55, Some(0.02), "deg/K")]), Some(false));
        let in_radians = parameter("k", 0.5_f64.to_radians(), Some(1e-6), "rad/K");
        assert_eq!(covered(std::slice::from_ref(&in_radians)), Some(true));
        assert_eq!(covered(&[in_radians.clone(), in_radians]), None, "which of the two?");
        assert_eq!(covered(&[parameter("h", 0.5, None, "deg/K")]), None);
        assert_eq!(covered(&[parameter("h", 0.5, Some(1.0), "deg/s/K")]), None);
    }
}
