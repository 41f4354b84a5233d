//! `hil show`: a record as lines.

use super::failure::Failure;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use record::Device;
use record::outcome::Outcome;
use record::run_folder::{RECORD, RunFolder, RunFolderError};
use record::text::Line;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

/// Prints the record of a run, one line an event: bench time in seconds, device, what happened.
#[derive(Debug, Args)]
pub(super) struct ShowArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Only the events of this device.
    #[arg(long, value_parser = device_parser())]
    device: Option<Device>,
    /// No more lines than this.
    #[arg(long, value_name = "N")]
    limit: Option<u64>,
}

fn device_parser() -> impl TypedValueParser<Value = Device> {
    PossibleValuesParser::new(Device::ALL.map(Device::name)).try_map(|name| {
        Device::ALL.into_iter().find(|device| device.name() == name).ok_or("no such device")
    })
}

impl ShowArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let folder = RunFolder::open(&self.run)?;
        let mut out = BufWriter::new(io::stdout().lock());
        let mut left = self.limit.unwrap_or(u64::MAX);
        let records = folder.records()?;
        let header = records.header().clone();
        for record in records {
            if left == 0 {
                break;
            }
            // Lines before the place of a damage are good; they are out before the error is told.
            let record = record.map_err(|source| {
                let _ = out.flush();
                RunFolderError::Record { path: folder.file(RECORD), source }
            })?;
            if self.device.is_some_and(|device| device != record.device) {
                continue;
            }
            left -= 1;
            match writeln!(out, "{}", Line(&record, header.name_of(record.device))) {
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                    return Ok(Outcome::Passed);
                }
                written => written.map_err(Failure::output)?,
            }
        }
        match out.flush() {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::output(error)),
            _ => Ok(Outcome::Passed),
        }
    }
}
