//! `hil check`: judges recorded runs again. What that means is in [`harness::run::judge_again`].

use super::EXIT_STATUSES;
use super::failure::Failure;
use super::progress::Screen;
use super::series::tell;
use clap::Args;
use harness::run::{PrepareError, judge_again, load_plan, load_rig, write_documents};
use harness::world::bench::Bench;
use judge::properties::Limits;
use plan::Plan;
use plan::library::{Kind, Library, names};
use record::outcome::{Measurement, Outcome, Summary};
use record::run_folder::RunFolder;
use std::path::{Path, PathBuf};
use views::console;

/// Judges recorded runs again, by their plans as they are now.
///
/// Properties are judged again as far as the record holds what they are judged by; the others keep their verdicts, and are
/// named. Summary, junit.xml and report.html are written anew from a whole record. A record that is cut short is
/// judged as far as it goes; it cannot pass, and replaces no earlier verdict.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct CheckArguments {
    /// Run folders.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Plan to judge by, name or path. [default: the shipped one of the name that the run has]
    #[arg(long, value_name = "PLAN")]
    plan: Option<String>,
    /// Print one JSON document and nothing else: the summaries as in summary.json.
    #[arg(long)]
    pub(super) json: bool,
}

impl CheckArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let mut summaries = Vec::new();
        let mut done = Ok(());
        for run in &self.runs {
            match self.check(run, screen) {
                Ok(summary) => summaries.push(summary),
                Err(failure) => {
                    done = Err(failure);
                    break;
                }
            }
        }
        tell(done, &summaries, self.json)?.map(|()| console::worst(&summaries))
    }

    fn check(&self, run: &Path, screen: &Screen) -> Result<Summary, Failure> {
        let name = run.display().to_string();
        let folder = RunFolder::open(run)?.telling(screen.reading(&name));
        let was = folder.summary_if_any()?;
        let records = folder.records()?;
        let recorded = records.header().clone();
        let plan = match &self.plan {
            Some(name) => load_plan(&Library::beside(name), name)?,
            None => shipped(was.as_ref().map_or(&recorded.plan, |summary| &summary.plan))?,
        };
        let before = was.as_ref().map(|summary| summary.measurements.clone());
        let library = self.plan.as_deref().map_or_else(Library::shipped, Library::beside);
        let rig = load_rig(&library, &plan).map_err(PrepareError::from)?;
        let limits = rig
            .robot
            .map(|devices| Limits::of(&Bench::new(*devices, recorded.seed).controller_config()));
        let judged = judge_again(&plan, limits.as_ref(), was, &recorded, records);
        for one in &judged.kept {
            screen.note(&format!(
                "{}: {} keeps the verdict of the run: {}",
                run.display(),
                one.name,
                one.why
            ));
        }
        if let Some(before) = before
            && self.plan.is_none()
            && !same_bands(&before, &judged.summary.measurements)
        {
            screen.note(&format!(
                "{}: the shipped plan {} declares other measurements or bands than the run was judged \
                 by; --plan takes another",
                run.display(),
                plan.name
            ));
        }
        if let Some(error) = &judged.record_error {
            let kept = if judged.rewrite { "" } else { "; its files are left as they are" };
            screen.note(&format!("{}: {error}; judged as far as it goes{kept}", run.display()));
        }
        if judged.rewrite {
            write_documents(&folder, &judged.summary, &judged.header)?;
        }
        Ok(judged.summary)
    }
}

/// The shipped plan of the name that a run has. The name comes from a file: it is not taken for a path.
fn shipped(name: &str) -> Result<Plan, Failure> {
    if !names(Kind::Plan).iter().any(|shipped| shipped == name) {
        let message = format!("no plan that ships is called \"{}\"", name.escape_debug());
        return Err(Failure::arguments(message, "say where the plan of the run is: --plan FILE"));
    }
    Ok(load_plan(&Library::shipped(), name)?)
}

/// Do both declare the same?
fn same_bands(before: &[Measurement], after: &[Measurement]) -> bool {
    let key = |one: &Measurement| (one.name.clone(), one.lower, one.upper, one.unit.clone());
    before.iter().map(key).eq(after.iter().map(key))
}
