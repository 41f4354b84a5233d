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
    let headers = [one.header().clone(), other.header().clone()];
    if let Some(Parted { sides: [first, second], .. }) = first(&headers, one, other) {
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
    let headers = [one.header().clone(), other.header().clone()];
    let parted = match in_part {
        true => first(&headers, one.filter(in_each_record), other.filter(in_each_record)),
        false => first(&headers, one, other),
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
    headers: &[Header; 2],
    mut one: impl Iterator<Item = Result<Record, RecordError>>,
    mut other: impl Iterator<Item = Result<Record, RecordError>>,
) -> Option<Parted> {
    let [first_header, second_header] = headers;
    let told = |record: Option<Result<Record, RecordError>>, header| match record {
        Some(Ok(record)) => Line(&record, header).to_string(),
        Some(Err(error)) => error.to_string(),
        None => "the record ends".to_owned(),
    };
    // A record numbers its nodes in the order of its rig file.
    let is_same = |first: &Record, second: &Record| {
        (first.at, first_header.name_of(first.device), &first.kind)
            == (second.at, second_header.name_of(second.device), &second.kind)
    };
    loop {
        let pair = (one.next(), other.next());
        match pair {
            (None, None) => return None,
            (Some(Ok(first)), Some(Ok(second))) if is_same(&first, &second) => {}
            (first, second) => {
                let is_damaged = |side: &Option<_>| matches!(side, Some(Err(_)));
                let damaged = is_damaged(&first)
                    || is_damaged(&second)
                    || one.any(|record| record.is_err())
                    || other.any(|record| record.is_err());
                let sides = [told(first, first_header), told(second, second_header)];
                let sides = sides.map(|side| side.trim().to_owned());
                return Some(Parted { sides, damaged });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Header, Record, RecordError, RecordKind, first};
    use record::Device;
    use record::header::Node;
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
            first(&Default::default(), notes(one).into_iter(), notes(other).into_iter())
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

    /// Found by a user: the second record's nodes had the names of the first.
    #[test]
    fn nodes_are_compared_by_their_names() {
        let header = |names: [&str; 2]| Header {
            nodes: names.map(|name| Node { name: name.to_owned(), ..Node::default() }).to_vec(),
            ..Header::default()
        };
        let said_by = |place: u8, text: &str| {
            let kind = RecordKind::Note(text.to_owned());
            let (at, device) = (Timestamp::ZERO, Device::Node(place));
            [Ok(Record { at, device, kind })].into_iter()
        };
        let headers = [header(["motor", "ecu"]), header(["ecu", "motor"])];
        assert_eq!(first(&headers, said_by(1, "on"), said_by(0, "on")), None);
        let [one, other] = first(&headers, said_by(1, "on"), said_by(1, "on")).unwrap().sides;
        assert!(one.contains(" ecu ") && other.contains(" motor "), "{one}, {other}");
    }

    #[test]
    fn damage_is_told_also_behind_the_first_difference() {
        let broken = || {
            let error = std::io::Error::from(std::io::ErrorKind::UnexpectedEof);
            notes(&["a", "b"]).into_iter().chain([Err(RecordError::Io(error))])
        };
        for whole in [notes(&["a", "b", "c"]), notes(&["x"])] {
            assert!(first(&Default::default(), broken(), whole.into_iter()).unwrap().damaged);
        }
    }
}
