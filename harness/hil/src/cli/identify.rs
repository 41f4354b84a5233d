//! `hil identify`: what a model lacks to explain measured data.

use super::failure::Failure;
use super::findings;
use super::measured::{self, findings_folder, load, model, put, tell};
use super::progress::Screen;
use super::{say, say_json};
use clap::Args;
use identification::identify::{Identified, Options, identify};
use record::outcome::Outcome;
use serde_json::json;
use std::path::PathBuf;
use views::report::identification as report;

/// Maximum number of effects; beyond this no data set is informative.
const EFFECTS_MAX: u64 = 64;

/// What is always written.
const FILES: [&str; 3] = ["finding.json", "model.toml", "report.html"];

/// Shown below the help: any verdict is a result.
const EXIT_STATUSES: &str = "\
Exit status:
  0  there is a finding, whatever its verdict
  2  bad input: arguments, a data package, a model, or data that do not fit the model
  3  the findings cannot be written";

/// Finds which effects a model lacks to explain measured data, and which experiment would decide
/// between candidates.
///
/// Writes finding.json, model.toml, report.html and, where causes are in doubt, the plan that would decide. The same
/// data, seed and version give the same bytes.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct IdentifyArguments {
    /// A data package (a folder with datapackage.json, or that file), or a run folder.
    #[arg(value_name = "DATASET|RUN")]
    data: PathBuf,
    /// The model to begin with. [default: the plain model of the kind of data]
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// The folder for what is found. [default: findings/NAME, with the name of the data set]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Seed of all random numbers.
    #[arg(long, value_name = "N", default_value_t = Options::default().seed)]
    seed: u64,
    /// The most effects to add.
    #[arg(long, value_name = "N", default_value_t = Options::default().max_effects as u64,
          value_parser = clap::value_parser!(u64).range(0..=EFFECTS_MAX))]
    max_effects: u64,
    /// Data of the same device at rest, from which its noise is taken.
    #[arg(long, value_name = "DATASET|RUN")]
    noise_from: Option<PathBuf>,
    /// Print one JSON document and nothing else: the finding as in finding.json, and its folder.
    #[arg(long)]
    pub(super) json: bool,
}

impl IdentifyArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let model = self.model.as_deref().map(model).transpose()?;
        let dataset = load(&self.data, model.as_ref().map(|model| model.kind), screen)?;
        let noise_from =
            self.noise_from.as_deref().map(|path| load(path, None, screen)).transpose()?;
        let folder = findings_folder(self.out.as_deref(), &dataset.name, &FILES)?;
        tell(&dataset, screen);
        noise_from.iter().for_each(|noise| tell(noise, screen));
        // At most `EFFECTS_MAX`.
        let max_effects = self.max_effects as usize;
        let options = Options { seed: self.seed, max_effects, noise_from };
        let progress = screen.share(&dataset.name);
        let mut show = |share: f64, doing: &str| progress.show(share, doing);
        let found = identify(&dataset, model.as_ref(), &options, &mut show);
        progress.finish();
        let found = found
            .map_err(|error| Failure::identify(&dataset.name, self.model.as_deref(), error))?;
        put(&folder, &files(&found)?)?;
        if self.json {
            say_json(&json!({ "finding": found.finding, "folder": folder }))?;
        } else {
            say(&findings::summary(&found.finding))?;
            say(&format!("written: {}\n", folder.display()))?;
        }
        Ok(Outcome::Passed)
    }
}

fn files(found: &Identified) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let model = toml::to_string_pretty(&found.model).map_err(Failure::findings)?;
    let page = report::page(&found.finding, &found.model, &found.diagnostics);
    let contents = [measured::json(&found.finding)?, model.into_bytes(), page.into_bytes()];
    let mut files: Vec<(String, Vec<u8>)> =
        FILES.map(str::to_owned).into_iter().zip(contents).collect();
    if let Some(experiment) = &found.experiment {
        files.push((experiment.file(), experiment.plan_toml.clone().into_bytes()));
    }
    Ok(files)
}
