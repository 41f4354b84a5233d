//! `hil` alone: the plans of the working directory; in a clone of the repository every procedure of the paper.

use super::build_server::SummaryArguments;
use super::failure::Failure;
use super::listed::has_steps;
use super::operator::OperatorArguments;
use super::progress::Screen;
use super::series::{Out, RUNS, Series, prepare_all};
use super::setup::Setup;
use clap::Args;
use harness::hosted::Hosting;
use plan::library::{Kind, PAPER_PLANS, names_in};
use record::outcome::Outcome;
use record::sink::Level;
use std::path::{Path, PathBuf};

/// The procedures again, with another gyro and on another bus.
const VARIANTS: [&str; 2] = ["verification-dsp3000", "laps-corrected-serial"];

/// Arguments of `hil` without a command.
#[derive(Debug, Args)]
pub(super) struct PaperArguments {
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the run folders, each PLAN-seedN.
    #[arg(long, value_name = "DIR", default_value = RUNS)]
    out: PathBuf,
    #[command(flatten)]
    summary: SummaryArguments,
    /// Print one JSON document and nothing else: the summaries as in summary.json.
    #[arg(long)]
    pub(super) json: bool,
}

impl PaperArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let own = plans_in(Path::new("."));
        let plans: Vec<&str> = if !own.is_empty() {
            own.iter().map(String::as_str).collect()
        } else if Path::new("test-plans").is_dir() {
            procedures()
        } else {
            return Err(Failure::arguments(
                "this folder has no plans",
                "`hil new NAME` creates a project, `hil --help` shows all commands, and `hil list plans` the plans that ship",
            ));
        };
        let prepared = prepare_all(&plans, &Setup::Simulated)?;
        let asked = prepared.iter().map(|one| &*one.plan);
        let (answers, person) =
            OperatorArguments::default().collect(&Setup::Simulated, asked, screen)?;
        let series = Series {
            plans: &plans,
            setup: &Setup::Simulated,
            hosting: Hosting::default(),
            seed: Some(self.seed),
            out: Out::Parent(self.out.clone()),
            level: Level::Events,
            answers,
            person,
            summary: self.summary.clone(),
            watched: false,
            json: self.json,
            is_verified: false,
            repeat: None,
        };
        series.execute(screen)
    }
}

fn procedures() -> Vec<&'static str> {
    PAPER_PLANS.into_iter().chain(VARIANTS).collect()
}

/// The plans of a project: its files of TOML that have steps, those with mistakes included.
fn plans_in(folder: &Path) -> Vec<String> {
    let files = names_in(folder, Kind::Plan).into_iter().map(|name| name + ".toml");
    let text = |file: &String| std::fs::read(folder.join(file)).unwrap_or_default();
    files.filter(|file| has_steps(&String::from_utf8_lossy(&text(file)))).collect()
}

#[cfg(test)]
mod tests {
    use super::{prepare_all, procedures};
    use crate::cli::setup::Setup;

    #[test]
    fn every_procedure_can_be_prepared() {
        let plans = procedures();
        assert_eq!(prepare_all(&plans, &Setup::Simulated).unwrap().len(), plans.len());
    }
}
