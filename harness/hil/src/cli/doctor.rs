//! `hil doctor`: what this machine and a bench have, what they lack, and the command that fixes it.

use super::completions;
use super::failure::Failure;
use clap::Args;
use record::outcome::Outcome;

const STATUSES: &str = "\
Exit status:
  0  everything that the bench and the plans need is there
  3  something that they need is missing";

/// Checks this machine and a bench: what is there, what is missing, and the command that fixes it.
///
/// Without a bench it checks only the programs that the plans test; with one, also the ports of the
/// plans' roles and lines. It changes nothing.
#[derive(Debug, Args)]
#[command(after_help = STATUSES)]
pub(super) struct DoctorArguments {
    /// Plans to check for: names (see `hil list plans`) or paths.
    #[arg(value_name = "PLAN", add = completions::plan())]
    plans: Vec<String>,
    /// Bench to check: a name (see `hil list benches`) or a path.
    #[arg(long, value_name = "FILE")]
    bench: Option<String>,
    /// Print everything as JSON: outcome, findings, and the facts behind them.
    #[arg(long)]
    pub(super) json: bool,
}

impl DoctorArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        use crate::doctor::{Facts, Needs, examine, outcome, show};
        use views::console::Style;
        let needs = Needs::read(self.bench.as_deref(), &self.plans);
        let facts = Facts::gather(&needs);
        let findings = examine(&facts, &needs);
        super::say(&if self.json {
            show::json(&facts, &findings).map_err(|error| Failure::output(error.into()))?
        } else {
            show::text(&findings, Style::of_stdout())
        })?;
        Ok(outcome(&findings))
    }
}
