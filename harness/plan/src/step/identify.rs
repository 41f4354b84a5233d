//! Identifies effects of a gyro or another sensor that its model lacks.

use super::{Known, Needs, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::quantity::QuantityName;
use crate::speakers::OfMessage;
use crate::survey::Survey;
use described::hint::proposal;
use described::{Mistake, Place};
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;

/// What the gyro, or a sensor of a node, does beyond a plain model is identified from what has been observed so far in
/// this run, under the calibration that is in force. The run folder keeps the finding and the model.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Identify {
    /// From which observations.
    pub from: Source,
    /// By which `use_model` takes the model up, here or in a later plan.
    pub name: Name,
    /// Only what was observed during this step or label; all where it is absent.
    #[serde(default)]
    pub over: Option<Name>,
    /// From a sensor: what it says, a signal of a node.
    #[serde(default)]
    pub measured: Option<QuantityName>,
    /// From a sensor: what is true, in the same unit; a signal of any node.
    #[serde(default)]
    pub reference: Option<QuantityName>,
    /// From a sensor: what may be a cause beside. Signals in degC are temperatures, in deg angles by which it turns.
    #[serde(default)]
    pub beside: Vec<QuantityName>,
}

impl Identify {
    /// The quantities of nodes that it reads.
    pub fn of_nodes(&self) -> impl Iterator<Item = &QuantityName> {
        self.measured.iter().chain(&self.reference).chain(&self.beside)
    }
}

wire::words! {
    /// What is identified from.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
    #[serde(rename_all = "snake_case")]
    pub enum Source {
        /// Turns of the table.
        Turns = "turns",
        /// Laps of the square path.
        Laps = "laps",
        /// Logs at rest.
        Series = "series",
        /// A signal of a node beside another that is true.
        Sensor = "sensor",
    }
}

impl Source {
    /// The step that yields these observations; `None` if they do not need one.
    pub const fn step(self) -> Option<&'static str> {
        match self {
            Self::Turns => Some("table_turn"),
            Self::Laps => Some("lap"),
            Self::Series => Some("log"),
            Self::Sensor => None,
        }
    }
}

impl StepKind for Identify {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "identify {} from {}", self.name, self.from.name())?;
        self.over.iter().try_for_each(|over| write!(f, " of {over}"))
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Identify(self.clone())])
    }

    /// Checks that the steps it is based on come before it, and that no two models share a name.
    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        if self.from != Source::Sensor {
            Needs::Robot.check("identify", &survey.subject, at)?;
        }
        self.of_sensor(survey, at)?;
        if let Some(step) = self.from.step()
            && !survey.phases.contains(&step)
        {
            let message =
                format!("no `{step}` before this step, of which {} are", self.from.name());
            return Err(at.key("from").mistake(message));
        }
        if let Some(over) = &self.over
            && !survey.phases.contains(&over.as_str())
        {
            let help = proposal(over.as_str(), &survey.phases());
            let message = format!("no step or label `{over}` before this step");
            return Err(at.key("over").mistake(message).help(help));
        }
        if survey.models.contains(&self.name.as_str()) {
            return Err(at
                .key("name")
                .mistake(format!("model name `{}` is used twice", self.name)));
        }
        survey.models.push(self.name.as_str());
        Ok(())
    }
}

impl Identify {
    /// Checks that a sensor, and nothing else, has a signal and a true value in the same unit.
    fn of_sensor(&self, survey: &Survey<'_>, at: &Place) -> Checked {
        let keys = [("measured", &self.measured), ("reference", &self.reference)];
        if self.from != Source::Sensor {
            let given = keys.iter().find(|(_, given)| given.is_some()).map(|(key, _)| *key);
            let given = given.or((!self.beside.is_empty()).then_some("beside"));
            let Some(key) = given else { return Ok(()) };
            let message = format!("`{key}` has no meaning from {}", self.from.name());
            return Err(at.key(key).mistake(message));
        }
        let mut units = Vec::new();
        for (key, given) in keys {
            let Some(quantity) = given else {
                let message = format!("missing field `{key}`");
                let help = "`measured` is what the sensor says, `reference` what is true: signals of nodes";
                return Err(at.mistake(message).help(help));
            };
            units.push(signal_unit(survey, quantity, &at.key(key))?);
        }
        for (index, quantity) in self.beside.iter().enumerate() {
            signal_unit(survey, quantity, &at.key("beside").index(index))?;
        }
        if self.measured == self.reference {
            let message = "the reference is what is measured itself";
            return Err(at.key("reference").mistake(message).help("name the signal that is true"));
        }
        match &units[..] {
            [Some(measured), Some(reference)] if measured != reference => {
                let message = format!("in {reference}, and what is measured in {measured}");
                Err(at.key("reference").mistake(message))
            }
            _ => Ok(()),
        }
    }
}

/// The unit of a signal of a node.
fn signal_unit(
    survey: &Survey<'_>,
    quantity: &QuantityName,
    at: &Place,
) -> Result<Option<String>, Mistake> {
    survey.subject.quantity(quantity, at)?;
    match quantity.of_message() {
        Some(of @ OfMessage::Signal { .. }) => survey.subject.unit(of, at),
        _ => Err(at.mistake(format!("`{quantity}` is no signal of a node"))),
    }
}
