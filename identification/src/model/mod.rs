//! Models as composable terms: what `model.toml` holds.
//!
//! The measured rate is `(1 + sum of scale terms) x true rate + sum of bias terms`; a delay shifts it in time. For a
//! drive, the turned angle is `(1 + turn) x nominal + curvature x distance`, the distance `(1 + drive) x nominal`.

mod beside;
mod driver;
mod range;
mod relations;
mod see;
mod shape;
mod spline;
mod term;
#[cfg(test)]
mod tests;

pub use crate::corrections::{Correction, Fault};
use crate::dataset::{Axis, Kind, Role};
use crate::finding::{Compensation, Parameter};
pub use crate::problem::Acts;
use crate::problem::Known;
pub use beside::{ONE_WHEEL, UNEQUAL_WHEELS, WHEEL_SIZE, beside};
pub use driver::{Driver, Wrap};
pub use range::{is_physical, range_of};
pub use relations::{Timing, delay_all, is_delay, is_said_by};
use schemars::JsonSchema;
pub use see::{Field, field, narrowest_play, see};
use serde::{Deserialize, Serialize};
pub use shape::{LATE_SHARE, SEEN, Shape, exposure};
pub use spline::{
    REACH as SPLINE_REACH, cardinal as spline_columns, pieces as spline_pieces, quantile_knots,
};
use std::collections::BTreeMap;
pub(crate) use term::place_unit;
pub use term::{KNOT, is_frame, is_place, is_threshold, levels};

/// How a term depends on its drivers; beside each, its parameters. `origin` is where a driver counts as zero.
///
/// Places on the axis of a driver (`origin`, `at`, `centre`, knots) are in the unit of the field, `Cel` for a
/// temperature; differences (`width`, `period`, `half_width`) and what is per unit of it are in `K`. A place that is
/// written in `K` is read as the same number of degrees Celsius.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// `value`.
    Constant,
    /// `slope (x - origin)`.
    Linear,
    /// `coefficient (x - origin)^2`.
    Quadratic,
    /// `coefficient (x - origin)^3`.
    Cubic,
    /// `amplitude exp(-x / time_constant)`.
    Exponential,
    /// `cos` and `sin` of the harmonic that the driver names.
    Harmonic,
    /// `cos` and `sin` of `2 pi x / period`.
    Periodic,
    /// `size` from `at` on.
    Step,
    /// `slope max(0, x - at)`.
    Hinge,
    /// `height exp(-((x - centre) / width)^2 / 2)`.
    Bump,
    /// `height tanh((x - centre) / width)`.
    Tanh,
    /// A natural cubic spline through `knots` and the parameters `value_1`, `value_2` ...
    Spline,
    /// Bilinear between the values at `knots` x `knots_2`.
    Surface,
    /// `coefficient (x - origin) (y - origin_2)`.
    Product,
    /// The rate comes late by `delay`.
    Delay,
    /// Rates within `width` of zero read zero.
    DeadZone,
    /// Rates beyond `limit` are clipped, and those below `lower_limit`: `-limit` where it is not said.
    Saturation,
}

/// One term. `lag_of` brings the parameter `time_constant`, `branch_of` brings `half_width`. `seen_from` and `seen_to`
/// (`seen_from_2` and `seen_to_2` for the second driver) are the range of the driver in the data. The term follows its
/// driver for a tenth of that range beyond each end, and is constant from there; a square, a cube or a product is constant
/// from the ends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Term {
    /// Standard name.
    pub name: String,
    /// Whether the library names it.
    #[serde(default = "yes")]
    pub known: bool,
    /// What it acts on.
    pub term: Acts,
    /// Which axis of the gyro.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Which observed quantity alone it is of, where several know such a term.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// What it sees.
    #[serde(default)]
    pub drivers: Vec<Driver>,
    /// How it depends on that.
    pub form: Form,
    /// Knots of a spline or a surface, in the unit of its parameter `knot` ([`KNOT`]); where there is none, of the
    /// field.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub knots: Vec<f64>,
    /// Knots of a surface over its second driver, in the unit of its parameter `knot_2`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub knots_2: Vec<f64>,
    /// Its numbers, each with its unit.
    #[serde(default)]
    pub parameters: Vec<Parameter>,
}

fn yes() -> bool {
    true
}

impl Term {
    /// The parameter of that name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }
}

/// A model: terms, and which role each field that they name had.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Version of the contract.
    pub schema: u32,
    /// What data it is a model of.
    pub kind: Kind,
    /// The data that it was fitted to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dataset: Option<String>,
    /// Roles of the fields that the terms name, so that it can be applied where they are called otherwise.
    #[serde(default)]
    pub fields: BTreeMap<String, Role>,
    /// Counts per rad/s of a gyro that tells counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts_per_rad_per_s: Option<f64>,
    /// Half a side of the square that the laps were, m, where their ends lie as a square's do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closing_lever_m: Option<f64>,
    /// What the package states wrongly, which is set right before the terms apply.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<Correction>,
    /// How a firmware takes its terms off a reading, of a sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compensation: Option<Compensation>,
    /// The same of the other axes of a sensor with several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compensation_also: Vec<Compensation>,
    /// Its terms.
    #[serde(rename = "terms", default)]
    pub terms: Vec<Term>,
    /// The model from which the identification started, fitted to the same data by itself: what errors before are
    /// measured against.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub plain: Vec<Term>,
}

impl Model {
    /// As `model.toml`.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// From the text of a `model.toml`.
    ///
    /// # Errors
    ///
    /// The error in the text and its position.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    pub(crate) const fn known(&self) -> Known {
        Known { counts_per_unit: self.counts_per_rad_per_s, closing_lever_m: self.closing_lever_m }
    }
}
