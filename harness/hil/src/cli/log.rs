//! `hil log`: converts bus logs from one format to another, and replays them to a port.

use super::failure::Failure;
use super::log_format::{format_of, format_parser};
use super::progress::Screen;
use super::replay::ReplayArguments;
use super::say;
use bus_log::convert::{Converted, convert};
use bus_log::{Format, LogError, LogReader, LogWriter};
use clap::{Args, Subcommand};
use record::figures;
use record::outcome::Outcome;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Reads, writes and plays bus logs: candump (.log), Vector ASC (.asc) and BLF (.blf), pcapng (.pcapng), PEAK TRC
/// (.trc), MDF 4 (.mf4).
#[derive(Debug, Args)]
pub(super) struct LogArguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Convert(ConvertArguments),
    Replay(ReplayArguments),
}

/// Writes a log in another format.
///
/// Candump, ASC and TRC keep microseconds. Only pcapng keeps serial lines. ASC, BLF, MDF and TRC number channels
/// from 1 (can0 is 1), and say of an error frame only that it occurred. What is left out is counted.
#[derive(Debug, Args)]
struct ConvertArguments {
    /// The log.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// The file to write.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Format of IN. [default: from its extension]
    #[arg(long, value_name = "FORMAT", value_parser = format_parser())]
    from: Option<Format>,
    /// Format of OUT. [default: from its extension]
    #[arg(long, value_name = "FORMAT", value_parser = format_parser())]
    to: Option<Format>,
}

pub(super) fn tell(path: &Path, converted: Converted, screen: &Screen) -> Result<Outcome, Failure> {
    if !converted.is_whole() {
        screen.note("the format has no place for everything; pcapng has");
    }
    say(&format!("{}: {converted}\n", path.display()))?;
    Ok(Outcome::Passed)
}

impl LogArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        match &self.command {
            Command::Convert(arguments) => arguments.execute(screen),
            Command::Replay(arguments) => arguments.execute(screen),
        }
    }
}

impl ConvertArguments {
    fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let from = format_of(&self.input, self.from, "--from")?;
        let to = format_of(&self.output, self.to, "--to")?;
        let name = self.input.display().to_string();
        let mut reader = LogReader::open_telling(&self.input, from, screen.reading(&name))?;
        if is_same(&self.input, &self.output) {
            return Err(Failure::arguments(
                format!("{} would be written over itself", self.input.display()),
                "name another file to write",
            ));
        }
        let converted = convert(reader.by_ref(), LogWriter::create(&self.output, to)?);
        let converted = converted.inspect_err(|error| {
            if let LogError::Malformed { good, .. } = error {
                let entries = figures::counted(*good, "entry", "entries");
                screen.note(&format!("{}: {entries} before the error", self.output.display()));
            }
        })?;
        if reader.passed_over() > 0 {
            let passed_over = match reader.passed_over() {
                1 => "1 line or block that is no frame was passed over".to_owned(),
                count => format!("{count} lines or blocks that are no frames were passed over"),
            };
            screen.note(&format!("{}: {passed_over}", self.input.display()));
        }
        tell_notes(&self.input, &reader, screen);
        tell(&self.output, converted, screen)
    }
}

pub(super) fn tell_notes(path: &Path, reader: &LogReader<'_>, screen: &Screen) {
    for note in reader.notes() {
        screen.note(&format!("{}: {note}", path.display()));
    }
}

fn is_same(a: &Path, b: &Path) -> bool {
    // Two names of one file, hard links included.
    let of = |path: &Path| path.metadata().map(|file| (file.dev(), file.ino()));
    matches!((of(a), of(b)), (Ok(a), Ok(b)) if a == b)
}
