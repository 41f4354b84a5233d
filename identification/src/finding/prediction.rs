//! What a model predicts: the contract of `prediction.json`.

use super::SetAside;
use crate::dataset::Kind;
use serde::{Deserialize, Serialize};

/// What a model predicts on other data: `prediction.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// [`SCHEMA`](super::SCHEMA).
    pub schema: u32,
    /// Name of the data set.
    pub dataset: String,
    /// Its kind.
    pub kind: Kind,
    /// Rows of the data set.
    pub rows: usize,
    /// The predicted quantity.
    pub quantity: String,
    /// Unit of the rows' figures.
    pub unit: String,
    /// Error of the data against the plain model, and against the whole model.
    pub rmse: RmsePair,
    /// Rows of the figures, from 0; absent where every row has one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<usize>,
    /// The model's prediction of the quantity at those rows; empty where it predicts errors alone.
    pub predicted: Vec<f64>,
    /// Observed minus predicted.
    pub residual: Vec<f64>,
    /// Other quantities of the same data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<PredictedQuantity>,
    /// Rows that are wrong by themselves and took no part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set_aside: Vec<SetAside>,
}

/// One predicted quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PredictedQuantity {
    /// Name of the quantity.
    pub quantity: String,
    /// Unit of the figures.
    pub unit: String,
    /// As in [`Prediction`].
    pub rmse: RmsePair,
    /// As in [`Prediction`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub at: Vec<usize>,
    /// As in [`Prediction`]; for a level, what the model adds to it.
    pub predicted: Vec<f64>,
    /// As in [`Prediction`].
    pub residual: Vec<f64>,
}

/// Root-mean-square errors before and after a model is applied.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RmsePair {
    /// With the plain model of the kind, fitted to the same data as the model.
    pub before: f64,
    /// With the given model.
    pub after: f64,
}
