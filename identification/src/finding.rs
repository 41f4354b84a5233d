//! Results of an identification: the contract of `finding.json` and `prediction.json`.

mod prediction;

use crate::dataset::{Axis, Drive, Kind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

pub use prediction::{PredictedQuantity, Prediction, RmsePair};

/// Version of the contract.
pub const SCHEMA: u32 = 1;

/// What was found in a data set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Name of the data set.
    pub dataset: String,
    /// Its kind.
    pub kind: Kind,
    /// How the robot is driven, if that is not by the difference of two wheels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Drive>,
    /// Rows that took part.
    pub rows: usize,
    /// Runs that took part.
    pub runs: usize,
    /// Seed of all random draws.
    pub seed: u64,
    /// The verdict in one word.
    pub verdict: Verdict,
    /// Standard deviation of the residual noise.
    pub noise_floor: Figure,
    /// Error on runs that took no part in the fit.
    pub held_out: HeldOut,
    /// Held-out errors of other quantities (heading beside position, say).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held_out_also: Vec<HeldOut>,
    /// Parameters of the given model, fitted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub base: Vec<Parameter>,
    /// Effects that were added, strongest first.
    pub effects: Vec<Effect>,
    /// The models that were judged, from plain to rich; the finding is the chosen one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<PathModel>,
    /// Structure left in the residual.
    pub left: Vec<Left>,
    /// How firmware removes the errors from the readings of a sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compensation: Option<Compensation>,
    /// The same for the other axes of a sensor with several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub compensation_also: Vec<Compensation>,
    /// The plan that would decide between the rivals.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_experiment: Option<NextExperiment>,
    /// Rows that are wrong by themselves and took no part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set_aside: Vec<SetAside>,
    /// Notes on the data for the reader.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
}

/// Outliers of a quantity: rows whose error is far from that of the rows around them, farther than the tail of the noise
/// explains, and unrelated to every input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SetAside {
    /// What was measured.
    pub quantity: String,
    /// Number of outliers.
    pub rows: usize,
    /// Number of rows that were judged.
    pub of: usize,
    /// Distance from the rows around it, in `unit`, beyond which a row is one.
    pub limit: f64,
    /// The largest such distance.
    pub largest: f64,
    /// Unit of both.
    pub unit: String,
    /// Times of the first ten, as in the data.
    pub times: Vec<f64>,
}

/// Probability above which a constant adds nothing to the other terms (assumption).
const ADDS_NOTHING: f64 = 0.5;

impl Finding {
    /// How firmware removes the errors from the readings of each axis of a sensor.
    pub fn compensations(&self) -> impl Iterator<Item = &Compensation> {
        self.compensation.iter().chain(&self.compensation_also)
    }

    /// The spline or surface beside a constant that contains the constant: these data do not separate the two, which is
    /// all that the constant's probability of 1 means.
    pub fn not_told_apart(&self, constant: &Effect) -> Option<&Effect> {
        let is_constant = constant.form == "constant" && constant.p_value > ADDS_NOTHING;
        self.effects.iter().filter(|_| is_constant).find(|other| {
            ["spline", "surface"].contains(&other.form.as_str())
                && (&other.term, other.axis) == (&constant.term, constant.axis)
        })
    }
}

/// The unit after a number; a plain number has none.
pub fn in_unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A p-value in two digits.
pub fn p_value(p: f64) -> String {
    if p == 0.0 {
        "p < 1e-300".to_owned()
    } else if p < 1e-2 {
        format!("p = {p:.1e}")
    } else {
        format!("p = {p:.2}")
    }
}

/// The verdict in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// An effect was added, the residual is white at [`WHITENESS_LEVEL`](crate::outcome::WHITENESS_LEVEL), and the
    /// held-out error fell.
    Explained,
    /// The given model leaves nothing but noise.
    NothingMissing,
    /// Structure remains.
    StructureLeft,
}

/// A number with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// In `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Error on runs that took no part in the fit, before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOut {
    /// Always `rmse`.
    pub metric: String,
    /// Of what, where there is more than one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// Unit of the figures.
    pub unit: String,
    /// With the model given.
    pub before: f64,
    /// With what was found.
    pub after: f64,
    /// 95 % interval of `after`, from resampling whole runs.
    pub ci95: [f64; 2],
    /// In how many folds.
    pub folds: usize,
}

/// Steps that a firmware does with every reading of a sensor, in order: what the last one comes to is the reading without
/// the errors that were found. Expressions are those of described devices; `NAME_before` is what `NAME` was at the reading
/// before.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compensation {
    /// The field that was measured.
    pub of: String,
    /// Its unit, and that of what comes out.
    pub unit: String,
    /// What the steps read.
    pub inputs: Vec<CompensationInput>,
    /// The steps.
    pub steps: Vec<CompensationStep>,
    /// Errors of the readings as they are, and with the steps, on runs that took no part in the fit of their numbers.
    pub held_out: HeldOut,
    /// Terms that nothing can be done about from readings alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
}

/// A name that stands for what comes from outside.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensationInput {
    /// In expressions.
    pub name: String,
    /// The field, or what it is in words.
    pub of: String,
    /// Its unit.
    pub unit: String,
}

/// One step.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompensationStep {
    /// What it comes to has this name.
    pub name: String,
    /// What it comes to.
    pub expression: String,
    /// At the first reading, where that is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first: Option<String>,
}

/// A term that is not compensated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Its name.
    pub term: String,
    /// Why.
    pub why: String,
}

/// A model on the path from plain to rich.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathModel {
    /// Names of its effects beyond the model given.
    pub effects: Vec<String>,
    /// Held-out error in each metric.
    pub held_out: BTreeMap<String, PathError>,
    /// Whether this model is the finding.
    pub chosen: bool,
}

/// A held-out error of a model on the path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathError {
    /// Root mean square, in `unit`.
    pub value: f64,
    /// Margin above the best model on the path within which the two count as equal: the standard error of their
    /// difference over runs; if the residual is not noise, at least the standard error of the best model itself.
    pub standard_error: f64,
    /// Its unit.
    pub unit: String,
}

/// An effect that was added.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Standard name, or a generated one if no library names the effect.
    pub name: String,
    /// Whether the library names it.
    pub known: bool,
    /// What it acts on.
    pub term: String,
    /// Which axis of the gyro.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Fields, wrapped if the effect depends on a function of one.
    pub drivers: Vec<String>,
    /// Form of the dependence.
    pub form: String,
    /// Knots of a spline or a surface, in the unit of the parameter `knot`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub knots: Vec<f64>,
    /// Knots of a surface over its second driver, in the unit of the parameter `knot_2`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub knots_2: Vec<f64>,
    /// Its numbers.
    pub parameters: Vec<Parameter>,
    /// Probability that noise alone shows as strong a sign of any effect.
    pub p_value: f64,
    /// Held-out error without it.
    pub held_out_before: f64,
    /// Held-out error with it.
    pub held_out_after: f64,
    /// Causes that these data cannot exclude in its place.
    pub rivals: Vec<Rival>,
}

/// A parameter, fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Parameter {
    /// Name within its effect.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// Absent where it was not fitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub standard_error: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Where it can lie by physics, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

impl Effect {
    /// An effect of that name on `term`, in that form, that is certain and gains nothing.
    pub(crate) fn new(name: &str, term: &str, form: &str) -> Self {
        Self {
            name: name.to_owned(),
            known: true,
            term: term.to_owned(),
            axis: None,
            drivers: Vec::new(),
            form: form.to_owned(),
            knots: Vec::new(),
            knots_2: Vec::new(),
            parameters: Vec::new(),
            p_value: 0.0,
            held_out_before: f64::NAN,
            held_out_after: f64::NAN,
            rivals: Vec::new(),
        }
    }
}

impl Parameter {
    /// A number without an error or a range.
    pub(crate) fn new(name: &str, value: f64, unit: &str) -> Self {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        Self { name, value, standard_error: None, unit, range: None }
    }
}

/// Another cause that the data cannot exclude.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rival {
    /// As in [`Effect`].
    pub name: String,
    /// As in [`Effect`].
    pub term: String,
    /// As in [`Effect`].
    pub drivers: Vec<String>,
    /// Probability of this cause, among the effect and its rivals.
    pub probability: f64,
    /// The plan that would decide between them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub separated_by: Option<String>,
}

/// Structure that remains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// Fields over which it shows.
    pub drivers: Vec<String>,
    /// Its shape.
    pub shape: String,
    /// Its share of the residual's variance.
    pub share_of_residual_variance: f64,
}

/// A plan that would decide between rivals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NextExperiment {
    /// Path of the plan, beside the finding.
    pub plan: String,
    /// Names of the effect and the rivals that it separates.
    pub separates: Vec<String>,
    /// Expected gain, in words with a figure.
    pub expected_gain: String,
}
