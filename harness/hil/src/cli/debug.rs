//! `hil debug`: repeats a recorded run, and stops where the user asks.

mod asked;
mod session;

use super::completions;
use super::export_whole::ears;
use super::failure::Failure;
use super::progress::Screen;
use super::say;
use super::series::tell;
use super::setup::Controller;
use clap::Args;
use exchange::moment::Moment;
use exchange::tables::Ears;
use harness::operator::Answers;
use harness::run::{Prepared, prepare_recorded, simulate, summarise};
use record::RecordKind;
use record::header::Header;
use record::outcome::Outcome;
use session::Session;
use std::cell::Cell;
use std::io::{self, IsTerminal};
use std::path::PathBuf;
use wire::time::Timestamp;

/// Clock of a repeatable run.
const VIRTUAL: &str = "virtual";

/// Repeats a recorded run in virtual time, stops at a given time, shows the state, and steps from
/// there.
///
/// It reads commands from standard input, one per line: `step [N]` advances by N records and prints
/// them with their messages, `next` advances to the next begin or end of a plan step, `to SECONDS`
/// to a time, `find TEXT` to the next record whose line contains the text; `show` prints the state,
/// `end` continues to the end and judges, `quit` leaves. An empty line is `step`.
///
/// It can use another controller or plan. When the run first deviates from the recorded one, it
/// says so. Records are printed as in `hil show`.
#[derive(Debug, Args)]
pub(super) struct DebugArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Where to stop first (s).
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    at: f64,
    /// Use this plan instead of the recorded one: a name or path.
    #[arg(long, value_name = "PLAN", add = completions::plan())]
    plan: Option<String>,
    /// The controller: in-process, process, or a command line with {gyro} and {base} for the ports
    #[arg(long, value_name = "in-process|process|COMMAND")]
    controller: Option<Controller>,
}

impl DebugArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let at = asked::moment(self.at).map_err(|why| Failure::arguments(why, asked::MOMENT))?;
        let (name, folder) = screen.opened(&self.run)?;
        if let Some(summary) = folder.summary_if_any()?
            && summary.clock != VIRTUAL
        {
            let message = format!("{name} was run in {} time, which no run repeats", summary.clock);
            return Err(Failure::arguments(
                message,
                "hil rerun gives its controller what it heard; hil show --at says what stood",
            ));
        }
        let records = folder.records()?;
        let header = records.header().clone();
        let mut is_full = false;
        for record in records {
            let record = record.map_err(|source| folder.unreadable(source))?;
            is_full |= matches!(record.kind, RecordKind::Bytes(_) | RecordKind::Frame(_));
        }
        let prepared = self.prepared(&header, &name)?;
        let seed = header.seed;
        let ears = ears(&header, self.plan.as_deref())?.unwrap_or_else(Ears::of_base);
        let header = prepared.header(seed);
        let (input, output) = (io::stdin().lock(), io::stdout().lock());
        let is_asked = io::stdin().is_terminal();
        let has_left = Cell::new(false);
        // Only the readable records; an unreadable one was reported above.
        let recorded = folder.records()?.filter_map(Result::ok);
        let moment = Moment::new(header.clone(), ears);
        let mut session = Session::new(
            (input, output),
            is_asked,
            (recorded, is_full),
            (moment, &header),
            &has_left,
        );
        session.go_to(at);
        let run =
            simulate(&prepared, seed, &Answers::default(), &mut session, &mut |_| !has_left.get());
        let said = session.close(run.end);
        said.map_err(Failure::output)?;
        if has_left.get() {
            return Ok(Outcome::Passed);
        }
        let summary = summarise(&prepared, seed, &run);
        let outcome = summary.outcome;
        if let Some(reason) = &summary.reason {
            say(&format!("{}: {reason}\n", outcome.name()))?;
        }
        tell(Ok(()), &[summary], false)??;
        Ok(outcome)
    }

    /// The recorded plan, or the one given, with the given controller.
    fn prepared(&self, header: &Header, name: &str) -> Result<Prepared, Failure> {
        let mut prepared = recorded(self.plan.as_deref(), header, name)?;
        prepared.hosting = Controller::of_robot(self.controller.as_ref(), &prepared.rig, name)?;
        Ok(prepared)
    }
}

/// The plan that the record holds, or the one named `plan`; `name` is that of the run.
pub(super) fn recorded(
    plan: Option<&str>,
    header: &Header,
    name: &str,
) -> Result<Prepared, Failure> {
    prepare_recorded(header, plan)?.ok_or_else(|| {
        let message = format!("the record of {name} holds no plan");
        Failure::arguments(message, "name the plan with --plan")
    })
}

/// Formats the run's position when it stops.
fn seconds(at: Timestamp) -> String {
    format!("{:.6} s", at.as_secs_f64())
}
