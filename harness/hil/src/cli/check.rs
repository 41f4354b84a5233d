//! `hil check`: judges recorded runs again. [`harness::run::judge_again`] explains what that means.

use super::EXIT_STATUSES;
use super::completions;
use super::failure::Failure;
use super::progress::Screen;
use super::series::tell;
use clap::Args;
use harness::run::{judge_again, load_recorded, write_documents};
use plan::{Rig, Speaker};
use record::outcome::{Outcome, Summary};
use std::path::{Path, PathBuf};
use views::console;

/// Judges recorded runs again, by the recorded plan or by another one (--plan).
///
/// With another plan, its measurements and properties are judged by what the run did: its steps are not carried out.
/// Properties are judged again if the record holds their inputs; the others keep their verdicts and
/// are named. From a complete record, summary.json, junit.xml and report.html are written again. A
/// truncated record is judged as far as it goes; it cannot pass, and does not replace an earlier
/// verdict.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct CheckArguments {
    /// Run folders.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Plan to judge by, name or path. [default: the one that the record holds]
    #[arg(long, value_name = "PLAN", add = completions::plan())]
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
        let (name, folder) = screen.opened(run)?;
        let folder = folder.held()?;
        let was = folder.summary_if_any()?;
        let records = folder.records()?;
        let recorded = records.header().clone();
        let Some((plan, rig)) = load_recorded(&recorded, self.plan.as_deref())? else {
            let message = format!(
                "the record of {name} holds no plan, and none that ships is called \"{}\"",
                recorded.plan.escape_debug()
            );
            let help = "say where the plan of the run is: --plan FILE";
            return Err(Failure::arguments(message, help));
        };
        if self.plan.is_some()
            && let Ok(Some((run, run_rig))) = load_recorded(&recorded, None)
        {
            if run.steps != plan.steps {
                screen.note(&format!(
                    "{}: the steps of {} are not those of the run, and are not carried out again",
                    name, plan.name
                ));
            }
            for node in with_other_messages(&rig, &run_rig) {
                screen.note(&format!(
                    "{name}: the messages of `{node}` have changed since the run: measurements judge what was read then, \
                     properties what is read now"
                ));
            }
        }
        let judged = judge_again(&plan, &rig, was, &recorded, records);
        for one in &judged.kept {
            let mut all = judged.summary.properties.iter();
            let is_kept = all.any(|known| known.name == one.name && known.held.is_some());
            let what = if is_kept { "keeps the verdict of the run" } else { "is not judged" };
            screen.note(&format!("{}: {} {what}: {}", run.display(), one.name, one.why));
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

/// The nodes whose messages are not those of the run.
fn with_other_messages<'a>(now: &'a Rig, run: &'a Rig) -> impl Iterator<Item = &'a str> {
    let is_as_then = |one: &&Speaker| {
        let at = |then: &&Speaker| (&then.node, then.line) == (&one.node, one.line);
        let then = run.speakers.iter().find(at);
        then.is_some_and(|then| then.layout.messages() == one.layout.messages())
    };
    now.speakers.iter().filter(move |one| !is_as_then(one)).map(|one| one.node.as_str())
}
