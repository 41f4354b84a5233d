//! `hil rerun`: feeds a controller with the input of a recorded run.

use super::failure::Failure;
use super::progress::Screen;
use super::setup::Controller;
use super::{say, say_json};
use clap::Args;
use harness::run::{Clock, Difference, Prepared, Rerun, Said, load_recorded, moments_of, rerun};
use plan::Rig;
use plan::rig::{NodePart, RigNode, UnderTest};
use record::Record;
use record::header::Header;
use record::outcome::Outcome;
use record::text::Line;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Replays the inputs of a recorded run to a controller, and compares its outputs with the recorded
/// ones.
///
/// Nothing reacts to it: the record holds what the devices sent. The run needs `--record full`.
/// Outputs in virtual time are the same to the nanosecond. Those of a run in real time are compared
/// by contents and order, and the reports of a controller differ in their last digits. Fails if
/// anything differs.
#[derive(Debug, Args)]
pub(super) struct RerunArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// The controller: in-process, process, or a command line with {gyro} and {base} for the ports
    #[arg(long, value_name = "in-process|process|COMMAND")]
    controller: Option<Controller>,
    /// Start its programs with the commands in this plan's rig file as it is now, not with the
    /// recorded ones.
    #[arg(long)]
    plan: Option<String>,
    /// Print one JSON document and nothing else.
    #[arg(long)]
    pub(super) json: bool,
}

impl RerunArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let (name, folder) = screen.opened(&self.run)?;
        let records = folder.records()?;
        let header = records.header().clone();
        let Some((plan, rig)) = load_recorded(&header, self.plan.as_deref())? else {
            let message = format!("the record of {name} holds no plan");
            return Err(Failure::arguments(message, "run the plan again with this version"));
        };
        let hosting = Controller::of_robot(self.controller.as_ref(), &rig, &name)?;
        let prepared = Prepared::new(Arc::new(plan), rig, <_>::default(), <_>::default());
        let prepared = Prepared { hosting, ..prepared };
        let (moments, started) = (moments_of(&folder)?, started(&prepared.rig));
        let clock = moments.clock;
        let came = rerun(&prepared, header.seed, moments, records)?;
        if self.json {
            say_json(&document(&came, &header, &started))?;
        } else {
            let whose = match &self.plan {
                Some(plan) => format!("by the rig of {plan}"),
                None => "as recorded; --plan PLAN takes the command of a rig file".to_owned(),
            };
            for (node, command) in &started {
                say(&format!("started `{node}`: {command} ({whose})\n"))?;
            }
            say(&text(&came, &header, clock))?;
        }
        Ok(if came.is_same() { Outcome::Passed } else { Outcome::Failed })
    }
}

fn started(rig: &Rig) -> Vec<(String, String)> {
    let command = |node: &RigNode| match &node.part {
        NodePart::UnderTest(UnderTest::Command(words)) => {
            Some((node.name.clone(), words.join(" ")))
        }
        _ => None,
    };
    rig.nodes.iter().filter_map(command).collect()
}

fn line(record: Option<&Record>, header: &Header) -> Option<String> {
    record.map(|record| Line(record, header).to_string().trim().to_owned())
}

fn text(came: &Rerun, header: &Header, clock: Clock) -> String {
    let count = |said: Said| format!("{} outputs and {} reports", said.outputs, said.reports);
    let mut text = match &came.difference {
        None if clock == Clock::Real => format!(
            "the same contents in the same order, of a run in real time: {}\n",
            count(came.now)
        ),
        None => format!("the same: {}\n", count(came.now)),
        Some(Difference { recorded, now }) => {
            let told = |record| {
                line(record, header)
                    .map_or_else(|| "nothing".to_owned(), |line| format!("`{line}`"))
            };
            format!(
                "first difference: recorded {}, now {}\nrecorded: {}, now: {}\n",
                told(recorded.as_ref()),
                told(now.as_ref()),
                count(came.recorded),
                count(came.now),
            )
        }
    };
    if !came.is_same() && clock == Clock::Real {
        text += "the run was in real time: what the program does by its own timers may have fallen on the other side of an input\n";
    }
    text += &match (&came.ended, &came.recorded_end) {
        (Some(_), Some(recorded)) if came.ends_alike => {
            format!("it ended as in the run: {recorded}\n")
        }
        (Some(how), None) => format!("the program did not last to the end of the run: {how}\n"),
        (Some(how), Some(recorded)) => {
            format!("it ended otherwise than in the run: recorded {recorded}, now {how}\n")
        }
        (None, Some(recorded)) => {
            format!("it did not end early, as it did in the run: recorded {recorded}\n")
        }
        (None, None) => String::new(),
    };
    text
}

fn document(came: &Rerun, header: &Header, started: &[(String, String)]) -> Value {
    let count = |said: Said| json!({ "outputs": said.outputs, "reports": said.reports });
    let difference = came.difference.as_ref().map(|Difference { recorded, now }| {
        json!({ "recorded": line(recorded.as_ref(), header), "now": line(now.as_ref(), header) })
    });
    json!({
        "started": started.iter().cloned().collect::<BTreeMap<_, _>>(),
        "recorded": count(came.recorded),
        "now": count(came.now),
        "difference": difference,
        "ended": came.ended,
        "recorded_end": came.recorded_end,
    })
}
