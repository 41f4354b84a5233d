//! `hil` alone: every procedure of the paper.

use super::build_server::SummaryArguments;
use super::failure::Failure;
use super::operator::OperatorArguments;
use super::progress::Screen;
use super::series::{Out, RUNS, Series, prepare_all};
use super::setup::Setup;
use clap::Args;
use harness::hosted::Hosting;
use plan::library::PAPER_PLANS;
use record::outcome::Outcome;
use record::sink::Level;
use std::path::PathBuf;

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
        let plans: Vec<&str> = PAPER_PLANS.into_iter().chain(VARIANTS).collect();
        let prepared = prepare_all(&plans)?;
        let asked = prepared.iter().map(|one| &*one.plan);
        let (answers, person) =
            OperatorArguments::default().collect(&Setup::Simulated, asked, screen)?;
        let series = Series {
            plans: &plans,
            setup: &Setup::Simulated,
            hosting: Hosting::default(),
            seed: self.seed,
            out: Out::Parent(self.out.clone()),
            level: Level::Events,
            answers,
            person,
            summary: self.summary.clone(),
            watched: false,
            json: self.json,
            is_verified: false,
        };
        series.execute(screen)
    }
}

#[cfg(test)]
mod tests {
    use super::{PAPER_PLANS, VARIANTS, prepare_all};

    #[test]
    fn every_procedure_can_be_prepared() {
        let plans: Vec<&str> = PAPER_PLANS.into_iter().chain(VARIANTS).collect();
        assert_eq!(prepare_all(&plans).unwrap().len(), plans.len());
    }
}
