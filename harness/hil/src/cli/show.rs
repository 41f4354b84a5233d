//! `hil show`: a record as lines.

use super::failure::Failure;
use clap::Args;
use plan::hint;
use record::Device;
use record::header::Header;
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
    /// Only the events of this device (plan, controller, gyro, base, table, absolute, device), or node of a rig.
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// No more lines than this.
    #[arg(long, value_name = "N")]
    limit: Option<u64>,
}

/// The device or node of that name.
fn device(header: &Header, name: &str) -> Result<Device, Failure> {
    let nodes =
        (0..=u8::MAX).zip(&header.nodes).map(|(place, node)| (Device::Node(place), &**node));
    let known: Vec<(Device, &str)> =
        nodes.chain(Device::ALL.map(|device| (device, device.name()))).collect();
    let found = known.iter().find(|(_, known)| *known == name).map(|(device, _)| *device);
    found.ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(_, name)| *name).collect();
        Failure::arguments(
            format!("no device `{name}` in this record"),
            hint::proposal(name, &names),
        )
    })
}

impl ShowArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let folder = RunFolder::open(&self.run)?;
        let mut out = BufWriter::new(io::stdout().lock());
        let mut left = self.limit.unwrap_or(u64::MAX);
        let records = folder.records()?;
        let header = records.header().clone();
        let wanted = self.device.as_deref().map(|name| device(&header, name)).transpose()?;
        for record in records {
            if left == 0 {
                break;
            }
            // Lines before the place of a damage are good; they are out before the error is told.
            let record = record.map_err(|source| {
                let _ = out.flush();
                RunFolderError::Record { path: folder.file(RECORD), source }
            })?;
            if wanted.is_some_and(|device| device != record.device) {
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

#[cfg(test)]
mod tests {
    use super::{Device, Header, device};

    #[test]
    fn nodes_of_a_rig_have_their_names() {
        let nodes = ["manager", "cells"].map(str::to_owned).to_vec();
        let header = Header { nodes, ..Header::default() };
        assert_eq!(device(&header, "cells").unwrap(), Device::Node(1));
        assert_eq!(device(&header, "plan").unwrap(), Device::Plan);
        let said = format!("{:?}", device(&header, "cell").unwrap_err());
        assert!(said.contains("did you mean `cells`?"), "{said}");
        let said = format!("{:?}", device(&header, "oven").unwrap_err());
        assert!(said.contains("`manager`, `cells`, `plan`"), "{said}");
    }
}
