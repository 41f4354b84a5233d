//! What has been done of a campaign: one JSON line a case, so that one that was interrupted goes on where it
//! stopped.

use super::case::{Case, CaseResult};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use wire::time::Span;

/// First line of a journal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    schema: u32,
    version: String,
    campaign: String,
    /// In real time: how long a run without faults took when the campaign was begun.
    #[serde(default, rename = "horizon_ns", skip_serializing_if = "Option::is_none")]
    horizon: Option<Span>,
}

const SCHEMA: u32 = 1;

impl Head {
    /// Of the same campaign, begun at another time.
    fn is_of_the_same(&self, other: &Self) -> bool {
        let of = |head: &Self| (head.schema, head.horizon.is_some());
        of(self) == of(other) && self.version == other.version && self.campaign == other.campaign
    }
}

/// One case that is done.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Its number in the campaign, from 0.
    pub number: u64,
    /// The case.
    pub case: Case,
    /// What it came to.
    pub result: CaseResult,
    /// That of the result, where an envelope asks for it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub announced: bool,
}

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum JournalError {
    /// It cannot be read or written.
    #[error("failed to keep the journal {}", path.display())]
    Io {
        /// The journal.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is of another campaign.
    #[error("{} is of another campaign: {found}", path.display())]
    #[diagnostic(help("this one is {asked}; choose another --out, or remove the folder"))]
    Other {
        /// The journal.
        path: PathBuf,
        /// What it says of itself.
        found: String,
        /// What is asked for.
        asked: String,
    },
    /// A line within it is not right.
    #[error("{}:{line}: {message}", path.display())]
    #[diagnostic(help("remove the journal to begin anew"))]
    Broken {
        /// The journal.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
}

/// The journal of one campaign, open for more.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    horizon: Option<Span>,
    /// What was done before, by number.
    pub(super) done: BTreeMap<u64, Line>,
}

impl Journal {
    /// Opens `path`, or begins it. `campaign` says which campaign it is of: plan, search, seed and what else
    /// decides its cases. A last line that was cut short is dropped.
    ///
    /// # Errors
    ///
    /// When it cannot be read or written, or is of another campaign or version.
    pub fn open(path: &Path, campaign: &str) -> Result<Self, JournalError> {
        Self::open_any(path, campaign, None)
    }

    /// The same of a campaign in real time, where a run without faults took `horizon` this time. What it took when the
    /// campaign was begun goes on to count ([`horizon`](Self::horizon)): no two runs take the same time, and cases are to
    /// be drawn as they were.
    ///
    /// # Errors
    ///
    /// As of [`open`](Self::open).
    pub fn open_in_real_time(
        path: &Path,
        campaign: &str,
        horizon: Span,
    ) -> Result<Self, JournalError> {
        Self::open_any(path, campaign, Some(horizon))
    }

    fn open_any(path: &Path, campaign: &str, horizon: Option<Span>) -> Result<Self, JournalError> {
        let failed = |source| JournalError::Io { path: path.to_owned(), source };
        let head = Head {
            schema: SCHEMA,
            version: record::VERSION.to_owned(),
            campaign: campaign.to_owned(),
            horizon,
        };
        let mut file =
            OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        let mut done = BTreeMap::new();
        let (found, whole) = read(path, &file, &mut |line| {
            done.insert(line.number, line);
        })?;
        let horizon = match found {
            None => {
                file.set_len(0).map_err(failed)?;
                write(&mut file, &head).map_err(failed)?;
                horizon
            }
            Some(found) if !found.is_of_the_same(&head) => {
                let words = |head: &Head| format!("{} by version {}", head.campaign, head.version);
                let (found, asked) = (words(&found), words(&head));
                return Err(JournalError::Other { path: path.to_owned(), found, asked });
            }
            Some(found) => {
                file.set_len(whole).map_err(failed)?;
                file.seek(SeekFrom::End(0)).map_err(failed)?;
                found.horizon
            }
        };
        Ok(Self { path: path.to_owned(), file, horizon, done })
    }

    /// What was done before it was opened.
    pub const fn done(&self) -> &BTreeMap<u64, Line> {
        &self.done
    }

    /// In real time: how long a run without faults took when the campaign was begun.
    pub const fn horizon(&self) -> Option<Span> {
        self.horizon
    }

    /// Keeps one more.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub fn keep(&mut self, line: &Line) -> Result<(), JournalError> {
        write(&mut self.file, line)
            .map_err(|source| JournalError::Io { path: self.path.clone(), source })
    }
}

/// Reads the journal at `path`, one case after another in the order in which they were done, and leaves it as it is.
/// A last line that was cut short is left out.
///
/// # Errors
///
/// When it cannot be read, or a line within it is not right.
pub fn each_line(path: &Path, take: &mut dyn FnMut(Line)) -> Result<(), JournalError> {
    let failed = |source| JournalError::Io { path: path.to_owned(), source };
    read(path, &File::open(path).map_err(failed)?, take).map(|_| ())
}

/// The head, and how many bytes of it are whole lines.
type Read = (Option<Head>, u64);

fn read(path: &Path, file: &File, take: &mut dyn FnMut(Line)) -> Result<Read, JournalError> {
    let broken =
        |line, message: String| JournalError::Broken { path: path.to_owned(), line, message };
    let mut reader = BufReader::new(file);
    let (mut head, mut whole) = (None, 0);
    let mut text = Vec::new();
    for number in 1.. {
        text.clear();
        let length = reader
            .read_until(b'\n', &mut text)
            .map_err(|source| JournalError::Io { path: path.to_owned(), source })?;
        // What was being written when the power went has no end of line.
        if length == 0 || text.last() != Some(&b'\n') {
            break;
        }
        if head.is_none() {
            let found = serde_json::from_slice(&text);
            head = Some(found.map_err(|error| broken(number, error.to_string()))?);
        } else {
            let line: Line =
                serde_json::from_slice(&text).map_err(|error| broken(number, error.to_string()))?;
            take(line);
        }
        whole += length as u64;
    }
    Ok((head, whole))
}

fn write(file: &mut File, line: &impl Serialize) -> io::Result<()> {
    let mut text = serde_json::to_vec(line)?;
    text.push(b'\n');
    // One write, so that a line is there as a whole or cut short at its end.
    file.write_all(&text)
}

#[cfg(test)]
mod tests {
    use super::{Journal, JournalError, Line, each_line};
    use crate::toy::{Toy, space};
    use crate::{Executor as _, Random, Search as _};
    use std::io::Write as _;
    use wire::time::Span;

    fn lines(count: u64) -> Vec<Line> {
        let mut random = Random::new(&space(), 9);
        (0..count)
            .map(|number| {
                let case = random.next();
                let result = Toy::default().execute(&case);
                Line { number, case, result, announced: false }
            })
            .collect()
    }

    #[test]
    fn what_is_kept_is_there_again_but_for_a_line_that_was_cut_short() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        let lines = lines(5);
        let mut journal = Journal::open(&path, "toy").unwrap();
        for line in &lines[..3] {
            journal.keep(line).unwrap();
        }
        drop(journal);
        let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"{\"number\":3,\"ca").unwrap();
        drop(file);
        let mut journal = Journal::open(&path, "toy").unwrap();
        assert!(journal.done().values().eq(&lines[..3]));
        journal.keep(&lines[3]).unwrap();
        drop(journal);
        assert!(Journal::open(&path, "toy").unwrap().done().values().eq(&lines[..4]));
        let mut read = Vec::new();
        each_line(&path, &mut |line| read.push(line)).unwrap();
        assert_eq!(read, lines[..4]);
    }

    /// No two runs in real time take the same: what the first took decides the cases for good.
    #[test]
    fn the_first_horizon_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        let open = |ms| Journal::open_in_real_time(&path, "toy", Span::from_millis(ms));
        assert_eq!(open(8_003).unwrap().horizon(), Some(Span::from_millis(8_003)));
        assert_eq!(open(7_998).unwrap().horizon(), Some(Span::from_millis(8_003)));
        // That of a campaign in virtual time is another's.
        assert!(matches!(Journal::open(&path, "toy"), Err(JournalError::Other { .. })));
    }

    #[test]
    fn that_of_another_campaign_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        drop(Journal::open(&path, "laps, seed 1").unwrap());
        let error = Journal::open(&path, "laps, seed 2").unwrap_err();
        assert!(matches!(error, JournalError::Other { .. }));
        assert!(error.to_string().contains("another campaign: laps, seed 1"), "{error}");
    }

    #[test]
    fn a_line_that_is_none_is_shown_by_its_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        drop(Journal::open(&path, "toy").unwrap());
        let mut file = std::fs::OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"nonsense\n").unwrap();
        let error = Journal::open(&path, "toy").unwrap_err();
        assert!(matches!(error, JournalError::Broken { line: 2, .. }), "{error}");
    }
}
