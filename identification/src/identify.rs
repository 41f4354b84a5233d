//! The entry: data and a model in, finding and a better model out.

use crate::dataset::Dataset;
use crate::finding::{Finding, Prediction};
use crate::model::Model;

/// What the caller may choose.
#[derive(Debug, Clone)]
pub struct Options {
    /// Seed of whatever is drawn.
    pub seed: u64,
    /// Most effects to add.
    pub max_effects: usize,
    /// A static set of the same device, from which the noise is taken.
    pub noise_from: Option<Dataset>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, max_effects: 8, noise_from: None }
    }
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Identified {
    /// For `finding.json`.
    pub finding: Finding,
    /// For `model.toml`: the model given with what was found.
    pub model: Model,
}

/// Why a data set cannot be identified.
#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    /// It lacks what the kind needs.
    #[error("{0}")]
    Data(String),
    /// The model does not fit the data.
    #[error("{0}")]
    Model(String),
}

/// How far it is: a share from 0 to 1 and what is being done.
pub type Progress<'a> = &'a mut dyn FnMut(f64, &str);

/// Finds what `model` (by default the plain model of the kind) lacks to explain `dataset`.
///
/// # Errors
///
/// When the data lack what the kind needs, or the model is of another kind.
pub fn identify(
    dataset: &Dataset,
    _model: Option<&Model>,
    _options: &Options,
    _progress: Progress<'_>,
) -> Result<Identified, IdentifyError> {
    Err(IdentifyError::Data(format!("{}: not yet", dataset.name)))
}

/// Applies `model` to `dataset`, and changes nothing.
///
/// # Errors
///
/// When the data lack what the kind or the model needs.
pub fn predict(dataset: &Dataset, _model: &Model) -> Result<Prediction, IdentifyError> {
    Err(IdentifyError::Data(format!("{}: not yet", dataset.name)))
}
