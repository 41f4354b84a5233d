//! `hil run --verify-determinism`: runs the plan a second time and compares the records one by one.

use super::failure::Failure;
use controller::mission::Report;
use harness::run::{Completed, Options, Prepared, run_to_folder, write_documents};
use record::header::Header;
use record::outcome::Outcome;
use record::reader::RecordError;
use record::run_folder::{RunFolder, RunFolderError};
use record::text::Line;
use record::{Progress, Record, RecordKind};
use std::path::Path;

/// Runs the plan again. If the second run differs from the one in `out`, the summary there states the first difference:
/// an error, since the results of such a run cannot be reproduced.
pub(super) fn verify(
    prepared: &Prepared,
    (options, out): (&Options<'_>, &Path),
    completed: &mut Completed,
    pulse: &mut dyn FnMut(Progress) -> bool,
) -> Result<(), Failure> {
    let scratch = tempfile::tempdir().map_err(|source| Failure::file(out, source))?;
    let again = Options { out: scratch.path(), answers: options.answers.clone(), ..*options };
    let repeated = run_to_folder(prepared, &again, pulse, &|| 0.0)?;
    let stopped = |completed: &Completed| completed.summary.outcome == Outcome::Aborted;
    if stopped(completed) || stopped(&repeated) {
        return Ok(());
    }
    let folder = RunFolder::open(out)?;
    let (one, other) = (folder.records()?, RunFolder::open(scratch.path())?.records()?);
    let header = one.header().clone();
    if let Some(Parted { sides: [first, second], .. }) = first(&header, one, other) {
        let summary = &mut completed.summary;
        summary.outcome = Outcome::Error;
        summary.reason = Some(format!(
            "two runs of seed {} differ: `{first}`, and then `{second}`",
            options.seed
        ));
        write_documents(&folder, summary, &prepared.header(options.seed))?;
    }
    Ok(())
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Parted {
    pub(super) sides: [String; 2],
    /// From there on, one of them cannot be read to its end.
    pub(super) damaged: bool,
}

/// Two records beside each other.
pub(super) struct Compared {
    /// Where they part; `None` if they are the same.
    pub(super) parted: Option<Parted>,
    /// Only one of them is full: bytes, frames, truths and states were not compared.
    pub(super) in_part: bool,
}

/// The first difference between two records. If only one of them is full, what the other leaves out is not compared.
pub(super) fn difference(one: &RunFolder, other: &RunFolder) -> Result<Compared, RunFolderError> {
    let in_part = is_full(one)? != is_full(other)?;
    let (one, other) = (one.records()?, other.records()?);
    let header = one.header().clone();
    let parted = match in_part {
        true => first(&header, one.filter(in_each_record), other.filter(in_each_record)),
        false => first(&header, one, other),
    };
    Ok(Compared { parted, in_part })
}

fn is_full(run: &RunFolder) -> Result<bool, RunFolderError> {
    let is_traffic =
        |kind: &RecordKind| matches!(kind, RecordKind::Bytes(_) | RecordKind::Frame(_));
    Ok(run.records()?.flatten().any(|record| is_traffic(&record.kind)))
}

/// Whether a record has this at any level.
pub(super) const fn is_in_each_record(kind: &RecordKind) -> bool {
    use RecordKind::{Bytes, Frame, Truth};
    !matches!(kind, Bytes(_) | Frame(_) | Truth { .. } | RecordKind::Report(Report::State(_)))
}

fn in_each_record(record: &Result<Record, RecordError>) -> bool {
    record.as_ref().map_or(true, |record| is_in_each_record(&record.kind))
}

fn first(
    header: &Header,
    mut one: impl Iterator<Item = Result<Record, RecordError>>,
    mut other: impl Iterator<Item = Result<Record, RecordError>>,
) -> Option<Parted> {
    let told = |record: Option<Result<Record, RecordError>>| match record {
        Some(Ok(record)) => Line(&record, header).to_string(),
        Some(Err(error)) => error.to_string(),
        None => "the record ends".to_owned(),
    };
    loop {
        let pair = (one.next(), other.next());
        match pair {
            (None, None) => return None,
            (Some(Ok(first)), Some(Ok(second))) if first == second => {}
            (first, second) => {
                let is_damaged = |side: &Option<_>| matches!(side, Some(Err(_)));
                let damaged = is_damaged(&first)
                    || is_damaged(&second)
                    || one.any(|record| record.is_err())
                    || other.any(|record| record.is_err());
                let sides = [first, second].map(|record| told(record).trim().to_owned());
                return Some(Parted { sides, damaged });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Header, Record, RecordError, RecordKind, first};
    use record::Device;
    use wire::time::Timestamp;

    fn notes(texts: &[&str]) -> Vec<Result<Record, RecordError>> {
        let note = |(place, text): (usize, &&str)| {
            let at = Timestamp::from_secs_f64(place as f64);
            Ok(Record { at, device: Device::Plan, kind: RecordKind::Note((*text).to_owned()) })
        };
        texts.iter().enumerate().map(note).collect()
    }

    #[test]
    fn the_first_difference_is_told() {
        let between = |one: &[&str], other: &[&str]| {
            first(&Header::default(), notes(one).into_iter(), notes(other).into_iter())
        };
        assert_eq!(between(&["a", "b"], &["a", "b"]), None);
        let parted = between(&["a", "b", "c"], &["a", "x", "c"]).unwrap();
        assert!(!parted.damaged);
        let [one, other] = parted.sides;
        assert!(one.starts_with("1.0") && one.ends_with(" b"), "{one}");
        assert!(other.starts_with("1.0") && other.ends_with(" x"), "{other}");
        let [_, other] = between(&["a", "b"], &["a"]).unwrap().sides;
        assert_eq!(other, "the record ends");
    }

    #[test]
    fn damage_is_told_also_behind_the_first_difference() {
        let broken = || {
            let error = std::io::Error::from(std::io::ErrorKind::UnexpectedEof);
            notes(&["a", "b"]).into_iter().chain([Err(RecordError::Io(error))])
        };
        for whole in [notes(&["a", "b", "c"]), notes(&["x"])] {
            assert!(first(&Header::default(), broken(), whole.into_iter()).unwrap().damaged);
        }
    }
}
