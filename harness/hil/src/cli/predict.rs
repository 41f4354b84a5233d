//! `hil predict`: a model applied to other data.

use super::failure::Failure;
use super::findings;
use super::measured::{self, findings_folder, load, model, put, tell};
use super::progress::Screen;
use super::{say, say_json};
use clap::Args;
use identification::identify::predict;
use record::outcome::Outcome;
use serde_json::json;
use std::path::PathBuf;

const FILE: &str = "prediction.json";

/// Applies a model to measured data without changing the model. Writes prediction.json.
///
/// The exit status is that of `hil identify`.
#[derive(Debug, Args)]
pub(super) struct PredictArguments {
    /// A data package (a folder with datapackage.json, or that file), or a run folder.
    #[arg(value_name = "DATASET|RUN")]
    data: PathBuf,
    /// The model.
    #[arg(long, value_name = "MODEL.toml")]
    model: PathBuf,
    /// The folder for the prediction. [default: findings/NAME, with the name of the data set]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON document and nothing else: the prediction as in prediction.json, and its folder.
    #[arg(long)]
    pub(super) json: bool,
}

impl PredictArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let model = model(&self.model)?;
        let dataset = load(&self.data, Some(model.kind), screen)?;
        let folder = findings_folder(self.out.as_deref(), &dataset.name, &[FILE])?;
        tell(&dataset, screen);
        let prediction = predict(&dataset, &model)
            .map_err(|error| Failure::identify(&dataset.name, Some(&self.model), error))?;
        put(&folder, &[(FILE.to_owned(), measured::json(&prediction)?)])?;
        if self.json {
            say_json(&json!({ "prediction": prediction, "folder": folder }))?;
        } else {
            say(&findings::prediction(&prediction))?;
            say(&format!("written: {}\n", folder.display()))?;
        }
        Ok(Outcome::Passed)
    }
}
