//! Fits a model to observations.

use super::{Known, Op, StepKind};
use crate::Checked;
use crate::name::Name;
use crate::quantities;
use crate::quantity::{Filter, QuantityName};
use crate::survey::Survey;
use described::Place;
use schemars::JsonSchema;
use serde::Deserialize;
use std::fmt;
use std::num::NonZeroU32;

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

/// The part of a calibration that a fit yields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CalibrationPart {
    /// A constant factor of Eq. 4.
    Constant,
    /// A factor of Eq. 4 per direction.
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

    /// The tag on the abscissa, if any.
    pub fn against(&self) -> Option<&str> {
        match self {
            Self::Line { against } | Self::Table { against, .. } => Some(against),
            Self::Mean | Self::ByDirection => None,
        }
    }
}

impl Fit {
    /// The part of a calibration that it yields; `None` if it is not part of a calibration.
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

impl StepKind for Fit {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = &self.quantity;
        match &self.model {
            Model::Mean => write!(f, "fit a mean to {quantity}"),
            Model::ByDirection => write!(f, "fit a mean for each direction to {quantity}"),
            Model::Line { against } => write!(f, "fit a line to {quantity} over {against}"),
            Model::Table { against, points } => {
                write!(f, "fit a table of {points} points to {quantity} over {against}")
            }
        }
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        Ok(vec![Op::Fit(self.clone())])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, at: &Place) -> Checked {
        survey.filter(&self.quantity, &self.filter, at)?;
        if let Some(tag) = self.model.against() {
            let here = at.key("model").key(self.model.name());
            survey.tag(&self.quantity, tag, &here)?;
        }
        let of = format!("{} of {}", self.model.name(), self.quantity);
        let fit = (of, self.becomes().is_some());
        if survey.fits.insert(self.name.as_str(), fit).is_some() {
            return Err(at.key("name").mistake(format!("fit name `{}` is used twice", self.name)));
        }
        Ok(())
    }
}
