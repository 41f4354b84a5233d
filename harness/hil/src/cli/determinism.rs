//! `hil run --verify-determinism`: runs the plan a second time and compares the records one by one.

use super::failure::Failure;
use harness::run::{Completed, Options, Prepared, run_to_folder, write_documents};
use record::header::Header;
use record::outcome::Outcome;
use record::reader::RecordError;
use record::run_folder::{RunFolder, RunFolderError};
use record::text::Line;
use record::{Progress, Record};
use std::path::Path;

/// Runs the plan again. If the second run differs from the one in `out`, the summary there states the first difference:
/// an error, since the results of such a run cannot be reproduced.
pub(super) fn verify(
    prepared: &Prepared,
    (options, out): (&Options<'_>, &Path),
    completed: &mut Completed,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<(), Failure> {
    let scratch = tempfile::tempdir().map_err(|source| Failure::file(out, source))?;
    let again = Options { out: scratch.path(), answers: options.answers.clone(), ..*options };
    let repeated = run_to_folder(prepared, &again, pulse, &|| 0.0)?;
    let stopped = |completed: &Completed| completed.summary.outcome == Outcome::Aborted;
    if stopped(completed) || stopped(&repeated) {
        return Ok(());
    }
    let folder = RunFolder::open(out)?;
    if let Some([first, second]) = difference(&folder, &RunFolder::open(scratch.path())?)? {
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

/// The first difference between two records: a line of each.
pub(super) fn difference(
    one: &RunFolder,
    other: &RunFolder,
) -> Result<Option<[String; 2]>, RunFolderError> {
    let (one, other) = (one.records()?, other.records()?);
    let header = one.header().clone();
    Ok(first(&header, one, other))
}

fn first(
    header: &Header,
    mut one: impl Iterator<Item = Result<Record, RecordError>>,
    mut other: impl Iterator<Item = Result<Record, RecordError>>,
) -> Option<[String; 2]> {
    let told = |record: Option<Result<Record, RecordError>>| match record {
        Some(Ok(record)) => Line(&record, header.name_of(record.device)).to_string(),
        Some(Err(error)) => error.to_string(),
        None => "the record ends".to_owned(),
    };
    loop {
        let pair = (one.next(), other.next());
        match pair {
            (None, None) => return None,
            (Some(Ok(first)), Some(Ok(second))) if first == second => {}
            (first, second) => {
                return Some([first, second].map(|record| told(record).trim().to_owned()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Header, Record, RecordError, first};
    use record::{Device, RecordKind};
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
        let [one, other] = between(&["a", "b", "c"], &["a", "x", "c"]).unwrap();
        assert!(one.starts_with("1.0") && one.ends_with(" b"), "{one}");
        assert!(other.starts_with("1.0") && other.ends_with(" x"), "{other}");
        let [_, other] = between(&["a", "b"], &["a"]).unwrap();
        assert_eq!(other, "the record ends");
    }
}
