//! Steps that find out what a gyro does that its calibration does not know, and that use what was found.

use super::fit::NO_CALIBRATION;
use super::name::Name;
use super::quantity::QuantityName;
use schemars::JsonSchema;
use serde::Deserialize;

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
    /// The quantities that it reads of nodes.
    pub fn of_nodes(&self) -> impl Iterator<Item = &QuantityName> {
        self.measured.iter().chain(&self.reference).chain(&self.beside)
    }
}

/// What is identified from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Turns of the table.
    Turns,
    /// Laps of the square path.
    Laps,
    /// Logs at rest.
    Series,
    /// A signal of a node beside another that is true.
    Sensor,
}

impl Source {
    /// As written in a plan.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Turns => "turns",
            Self::Laps => "laps",
            Self::Series => "series",
            Self::Sensor => "sensor",
        }
    }

    /// The step that such observations come from; none where they come of themselves.
    pub const fn step(self) -> Option<&'static str> {
        match self {
            Self::Turns => Some("table_turn"),
            Self::Laps => Some("lap"),
            Self::Series => Some("log"),
            Self::Sensor => None,
        }
    }
}

/// The controller corrects by an identified model from now on, on top of the calibration in force: by one
/// that this plan or an earlier one identified, or by `none`. A calibration that is used later takes its
/// place. A model of a sensor has the node that is emulated take its errors off before it sends; on a real node a person
/// is asked to.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct UseModel(pub Name);

impl UseModel {
    /// Its name; absent where it is [`NO_CALIBRATION`].
    pub fn name(&self) -> Option<&Name> {
        (self.0.as_str() != NO_CALIBRATION).then_some(&self.0)
    }
}
