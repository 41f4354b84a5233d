//! Steps that make a calibration from what was observed, keep it and use it.

use super::name::Name;
use super::quantities;
use super::quantity::{Filter, QuantityName};
use schemars::JsonSchema;
use serde::Deserialize;
use std::num::NonZeroU32;

/// The name of no calibration at all: what is read is taken as it is.
pub const NO_CALIBRATION: &str = "none";

/// A model is fitted to what has been observed so far in this run.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// By which `save_calibration` takes it up.
    pub name: Name,
    /// What is modelled.
    pub quantity: QuantityName,
    /// Which observations are used; all where it is absent.
    #[serde(rename = "where", default)]
    pub filter: Filter,
    /// Which model.
    pub model: Model,
}

/// What is fitted.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Model {
    /// One mean. Of `table.error` it becomes a constant factor.
    Mean,
    /// One mean for each direction. Of `table.error` it becomes the factors of Eqs 1 and 2.
    ByDirection,
    /// A least-squares line. Of `table.error` over `temperature` it becomes Eqs 5 and 6.
    Line {
        /// The tag that is the abscissa.
        against: String,
    },
    /// Means in equal intervals. Of `bias.mean` over `temperature` it becomes the table of bias against
    /// temperature.
    Table {
        /// The tag that is the abscissa.
        against: String,
        /// How many intervals; those without an observation are left out.
        points: NonZeroU32,
    },
}

/// What a fit becomes in a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationPart {
    /// A constant factor of Eq. 4.
    Constant,
    /// A factor of Eq. 4 for each direction.
    Direction,
    /// The factor of Eq. 6.
    TemperatureLine,
    /// The table of bias against temperature.
    BiasTable,
}

impl Model {
    /// The key that names this kind of model.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::ByDirection => "by_direction",
            Self::Line { .. } => "line",
            Self::Table { .. } => "table",
        }
    }

    /// The tag that is the abscissa, where there is one.
    pub fn against(&self) -> Option<&str> {
        match self {
            Self::Line { against } | Self::Table { against, .. } => Some(against),
            Self::Mean | Self::ByDirection => None,
        }
    }
}

impl Fit {
    /// What it becomes in a calibration; `None` where a calibration has no place for it.
    pub fn becomes(&self) -> Option<CalibrationPart> {
        let temperature = |tag: &str| tag == "temperature";
        let of_turns = self.quantity.as_str() == quantities::TABLE_ERROR.name;
        let of_bias = self.quantity.as_str() == quantities::BIAS_MEAN.name;
        match &self.model {
            Model::Mean if of_turns => Some(CalibrationPart::Constant),
            Model::ByDirection if of_turns => Some(CalibrationPart::Direction),
            Model::Line { against } if of_turns && temperature(against) => {
                Some(CalibrationPart::TemperatureLine)
            }
            Model::Table { against, .. } if of_bias && temperature(against) => {
                Some(CalibrationPart::BiasTable)
            }
            _ => None,
        }
    }
}

/// Fits become a calibration, which the run folder keeps and later steps and plans can use.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SaveCalibration {
    /// Its name.
    pub name: Name,
    /// Fits that were made earlier in the plan, in the order in which their factors are applied.
    pub from: Vec<Name>,
}

/// A calibration is used from now on: one that this plan saved, one that an earlier plan saved, or `none`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct UseCalibration(pub Name);

impl UseCalibration {
    /// Its name; absent where it is [`NO_CALIBRATION`].
    pub fn name(&self) -> Option<&Name> {
        (self.0.as_str() != NO_CALIBRATION).then_some(&self.0)
    }
}
