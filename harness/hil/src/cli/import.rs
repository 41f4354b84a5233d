//! `hil import`: the log of a bench's CAN bus as a run folder.

use super::completions;
use super::failure::Failure;
use super::log::tell_notes;
use super::log_format::{format_of, format_parser};
use super::measured::plain_name;
use super::progress::Screen;
use super::{EXIT_STATUSES, say};
use crate::import::{import_rig_to_folder, import_to_folder};
use bus_log::{Channel, Format, LogReader};
use clap::Args;
use described::hint;
use harness::run::Prepared;
use plan::made::Made;
use record::figures;
use record::outcome::Outcome;
use std::path::PathBuf;
use views::console::{self, Style};

/// Turns a log of a bench's CAN bus into a run folder, and judges it by a plan.
///
/// With a rig or your own device, every node sends what it sent in the log, and the plan only listens: its steps wait and
/// hold as in a run. What the plan would send or set is assumed to be in the log already. Channels of the log are matched
/// to lines by name.
///
/// With the paper's robot, the identifiers show which frames belong to the base. They give straight.stop_error (how far
/// each straight went) and pose_write.retries (how often a pose was written). Nothing of the gyro, the table, the absolute
/// measurement or the controller's reports is on the bus: a measurement that needs them is not made, and fails. `hil check
/// RUN` judges the folder again.
#[derive(Debug, Args)]
#[command(after_help = EXIT_STATUSES)]
pub(super) struct ImportArguments {
    /// The log: candump (.log), Vector ASC (.asc) or BLF (.blf), pcapng (.pcapng), PEAK TRC (.trc) or MDF 4 (.mf4).
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The plan that ran on the bench: a name or a path.
    #[arg(long, value_name = "PLAN", add = completions::plan())]
    plan: String,
    /// The run folder. [default: runs/PLAN-LOG]
    #[arg(long, value_name = "RUN")]
    out: Option<PathBuf>,
    /// Format of the log. [default: from the extension of its name]
    #[arg(long, value_name = "FORMAT", value_parser = format_parser())]
    from: Option<Format>,
    /// Channel of the log for a line of the rig, once for each line; without LINE=, for all lines. [default: that of the
    /// line's name, the only one, or that of the base's first frame]
    #[arg(long, value_name = "LINE=CHANNEL", value_parser = channel)]
    channel: Vec<OfLine>,
    /// Begin the plan with the first frame of the log, as it always does for the paper's robot. [default: at the zero of a
    /// log without dates, and with the first frame of one that has them]
    #[arg(long)]
    from_first: bool,
}

#[derive(Debug, Clone)]
struct OfLine {
    line: Option<String>,
    channel: Channel,
}

fn channel(said: &str) -> Result<OfLine, &'static str> {
    let (line, name) = match said.split_once('=') {
        Some((line, name)) => (Some(line.to_owned()), name),
        None => (None, said),
    };
    let channel = Channel::new(name).ok_or("expected the name of an interface such as can0")?;
    Ok(OfLine { line, channel })
}

impl ImportArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let prepared = Prepared::load(&self.plan, &Made::default())?;
        let format = format_of(&self.log, self.from, "--from")?;
        let name = self.log.display().to_string();
        let mut reader = LogReader::open_telling(&self.log, format, screen.reading(&name))?;
        let folder = self.folder(&prepared.plan.name);
        self.check_lines(&prepared)?;
        if prepared.rig.robot.is_none() {
            let named = |line: &str| self.named(Some(line)).or(self.named(None));
            let named = |line: &str| named(line).map(Channel::as_str);
            let entries = reader.by_ref();
            let summary =
                import_rig_to_folder(&prepared, entries, &named, self.from_first, &folder)
                    .map_err(|error| error.of(&self.log))?;
            tell_notes(&self.log, &reader, screen);
            let outcome = summary.outcome;
            say(&console::measurements_table(&[summary], Style::of_stdout()))?;
            return Ok(outcome);
        }
        let channel = self.named(None).copied();
        let imported = import_to_folder(&prepared.plan, reader.by_ref(), channel, &folder)
            .map_err(|error| error.of(&self.log))?;
        tell_notes(&self.log, &reader, screen);
        let (summary, channel) = (imported.summary, imported.channel);
        let frames = figures::counted(summary.events, "frame", "frames");
        let moves = figures::counted(imported.moves, "move", "moves");
        screen.chat(&format!("{channel}: {frames}, {moves}"));
        if imported.left_out != crate::import::LeftOut::default() {
            screen.note(&imported.left_out.to_string());
        }
        for (measurement, why) in imported.unjudged {
            screen.note(&format!("{measurement} cannot be judged by a log: {why}"));
        }
        let outcome = summary.outcome;
        say(&console::measurements_table(&[summary], Style::of_stdout()))?;
        Ok(outcome)
    }

    fn named(&self, line: Option<&str>) -> Option<&Channel> {
        let said = self.channel.iter().find(|said| said.line.as_deref() == line);
        said.map(|said| &said.channel)
    }

    fn check_lines(&self, prepared: &Prepared) -> Result<(), Failure> {
        let lines: Vec<&str> = prepared.rig.lines.iter().map(|line| &*line.name).collect();
        for said in &self.channel {
            match said.line.as_deref() {
                Some(line) if !lines.contains(&line) => {
                    let message = format!("--channel {line}={}: no line `{line}`", said.channel);
                    return Err(Failure::arguments(message, hint::proposal(line, &lines)));
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn folder(&self, plan: &plan::Name) -> PathBuf {
        self.out.clone().unwrap_or_else(|| {
            let log = self.log.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from("runs").join(format!("{}-{}", plan.as_str(), plain_name(&log)))
        })
    }
}
