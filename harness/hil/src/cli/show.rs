//! `hil show`: prints a record as lines.

use super::export_whole::ears;
use super::failure::Failure;
use super::progress::Screen;
use super::say;
use clap::Args;
use described::hint;
use exchange::moment::Moment;
use exchange::tables::Ears;
use record::header::Header;
use record::outcome::Outcome;
use record::reader::RecordError;
use record::run_folder::RunFolder;
use record::text::Line;
use record::{Device, Record};
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

/// Prints the record of a run, one line for each event: bench time in seconds, device, what
/// happened.
#[derive(Debug, Args)]
pub(super) struct ShowArguments {
    /// A run folder.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Only the events of this device (plan, controller, gyro, base, table, absolute, device), or node of a rig.
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// Print the state at this time (s) instead of events: active steps and faults, the last
    /// mission and reports of the controller, the truth, and the last value of every signal of
    /// every node and of every quantity. Signals need `--record full`.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, conflicts_with = "device")]
    at: Option<f64>,
    /// Print at most this many lines.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    limit: Option<u64>,
}

/// Refuses a name that is no device or node of the record.
fn check_name(header: &Header, name: &str) -> Result<(), Failure> {
    let strangers = header.strangers().map(|device| header.name_of(device));
    let nodes = header.nodes.iter().map(|node| node.name.as_str()).chain(strangers);
    let known: Vec<&str> = nodes.chain(Device::ALL.iter().map(|device| device.name())).collect();
    if known.contains(&name) {
        return Ok(());
    }
    Err(Failure::arguments(
        format!("no device `{name}` in this record"),
        hint::proposal(name, &known),
    ))
}

impl ShowArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let folder = RunFolder::open(&self.run)?;
        let mut out = BufWriter::new(io::stdout().lock());
        let mut left = self.limit.unwrap_or(u64::MAX);
        let records = folder.records()?;
        let header = records.header().clone();
        if let Some(at_s) = self.at {
            return self.moment((&folder, &header), at_s, records, screen);
        }
        let wanted = self.device.as_deref();
        wanted.map_or(Ok(()), |name| check_name(&header, name))?;
        for record in records {
            if left == 0 {
                break;
            }
            // Lines before the damage are valid; print them before the error.
            let record = record.map_err(|source| {
                let _ = out.flush();
                folder.unreadable(source)
            })?;
            // A node on several lines counts as one device.
            if wanted.is_some_and(|name| name != header.name_of(record.device)) {
                continue;
            }
            left -= 1;
            match writeln!(out, "{}", Line(&record, &header)) {
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

impl ShowArguments {
    fn moment(
        &self,
        (folder, header): (&RunFolder, &Header),
        at_s: f64,
        records: impl Iterator<Item = Result<Record, RecordError>>,
        screen: &Screen,
    ) -> Result<Outcome, Failure> {
        if at_s.is_nan() || at_s < 0.0 {
            let what = format!("{at_s} s is before the run began");
            return Err(Failure::arguments(what, "a run begins at 0 s"));
        }
        let ears = ears(header, None)?.unwrap_or_else(Ears::of_base);
        let mut moment = Moment::new(header.clone(), ears);
        let mut last_s = 0.0;
        for record in records {
            let record = record.map_err(|source| folder.unreadable(source))?;
            last_s = record.at.as_secs_f64();
            if last_s > at_s {
                break;
            }
            moment.take(&record);
        }
        if last_s < at_s {
            screen.note(&format!("the record ends at {last_s:.3} s: this is the state then"));
        }
        let limit =
            self.limit.map_or(usize::MAX, |limit| usize::try_from(limit).unwrap_or(usize::MAX));
        let lines: Vec<String> =
            moment.lines().into_iter().take(limit).map(|line| line + "\n").collect();
        say(&lines.concat())?;
        Ok(Outcome::Passed)
    }
}

#[cfg(test)]
mod tests {
    use super::{Header, check_name};
    use record::header::Node;

    #[test]
    fn nodes_of_a_rig_have_their_names() {
        let node =
            |name: &str| Node { name: name.to_owned(), line: "can0".to_owned(), ..<_>::default() };
        let nodes = ["manager", "cells"].map(node).to_vec();
        let header = Header { nodes, ..Header::default() };
        assert!(check_name(&header, "cells").is_ok() && check_name(&header, "plan").is_ok());
        let said = format!("{:?}", check_name(&header, "cell").unwrap_err());
        assert!(said.contains("did you mean `cells`?"), "{said}");
        let said = format!("{:?}", check_name(&header, "oven").unwrap_err());
        assert!(said.contains("`manager`, `cells`, `plan`"), "{said}");
    }
}
