//! The progress of a campaign, one JSON line per case, so that an interrupted campaign can resume.

use super::case::{Case, CaseResult};
use super::course::Course;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use wire::time::Span;

/// First line of a journal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    schema: u32,
    version: String,
    campaign: String,
    /// In real time: the duration of a run without faults at the start of the campaign.
    #[serde(default, rename = "horizon_ns", skip_serializing_if = "Option::is_none")]
    horizon: Option<Span>,
    /// In real time: the durations of its phases.
    #[serde(default, rename = "phases_ns", skip_serializing_if = "BTreeMap::is_empty")]
    phases: BTreeMap<String, Vec<Span>>,
}

const SCHEMA: u32 = 1;

impl Head {
    /// Whether both are of the same campaign, even if begun at different times.
    fn is_of_the_same(&self, other: &Self) -> bool {
        let of = |head: &Self| (head.schema, head.horizon.is_some());
        of(self) == of(other) && self.version == other.version && self.campaign == other.campaign
    }

    /// What determines the cases, one statement a part.
    fn parts(&self) -> Vec<String> {
        let clock = if self.horizon.is_some() { "in real time" } else { "in virtual time" };
        let parts = self.campaign.split(", ").map(str::to_owned);
        parts.chain([clock.to_owned(), format!("hil {}", self.version)]).collect()
    }

    /// The parts that the other has not.
    fn differs_from(&self, other: &Self) -> String {
        let others = other.parts();
        let parts: Vec<String> =
            self.parts().into_iter().filter(|part| !others.contains(part)).collect();
        parts.join(", ")
    }
}

/// Version and build of this program: two builds of one version may judge a case differently.
fn build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        // The file that runs, also where another build has taken its place.
        let running = std::fs::read("/proc/self/exe");
        let program = running.or_else(|_| std::fs::read(std::env::current_exe()?));
        match program {
            Ok(bytes) => format!("{} (build {:08x})", record::VERSION, crc32fast::hash(&bytes)),
            Err(_) => record::VERSION.to_owned(),
        }
    })
}

/// One finished case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Number in the campaign, from 0.
    pub number: u64,
    /// The case.
    pub case: Case,
    /// The result.
    pub result: CaseResult,
    /// Copy of the result's flag, for envelopes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub announced: bool,
}

/// Why a journal cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum JournalError {
    /// The file cannot be read or written.
    #[error("failed to keep the journal {}", path.display())]
    Io {
        /// The journal.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The journal is from another campaign.
    #[error("{} is of another campaign: {found} there, {asked} here", path.display())]
    #[diagnostic(help("choose another --out, or remove the folder"))]
    Other {
        /// The journal.
        path: PathBuf,
        /// What differs, as it is in the journal.
        found: String,
        /// The same as it is in the requested campaign.
        asked: String,
    },
    /// A line is invalid.
    #[error("{}:{line}: {message}", path.display())]
    #[diagnostic(help("remove the journal to begin anew"))]
    Broken {
        /// The journal.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// Description of the error.
        message: String,
    },
}

/// The journal of one campaign, open for appending.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    course: Option<Course>,
    /// Finished cases by number.
    pub(super) done: BTreeMap<u64, Line>,
}

impl Journal {
    /// Opens the journal at `path`, or creates it. `campaign` identifies the campaign: plan, search, seed and
    /// everything else that determines its cases, with a comma between them. A truncated last line is dropped.
    ///
    /// # Errors
    ///
    /// When it cannot be read or written, or is from another campaign or version.
    pub fn open(path: &Path, campaign: &str) -> Result<Self, JournalError> {
        Self::open_with(path, campaign, None)
    }

    /// The same with the `course` of a campaign in real time: how a run without faults has gone by now. The durations at the
    /// start of the campaign stay valid ([`course`](Self::course)), because they differ from run to run and cases must be
    /// drawn as before.
    ///
    /// # Errors
    ///
    /// See [`open`](Self::open).
    pub fn open_with(
        path: &Path,
        campaign: &str,
        course: Option<Course>,
    ) -> Result<Self, JournalError> {
        let failed = |source| JournalError::Io { path: path.to_owned(), source };
        let head = Head {
            schema: SCHEMA,
            version: build().to_owned(),
            campaign: campaign.to_owned(),
            horizon: course.as_ref().map(|course| course.lasted),
            phases: course.map_or_else(BTreeMap::new, |course| course.phases),
        };
        let mut file =
            OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        let mut done = BTreeMap::new();
        let (found, whole) = read(path, &file, &mut |line| {
            done.insert(line.number, line);
        })?;
        let head = match found {
            None => {
                file.set_len(0).map_err(failed)?;
                write(&mut file, &head).map_err(failed)?;
                head
            }
            Some(found) if !found.is_of_the_same(&head) => {
                let (found, asked) = (found.differs_from(&head), head.differs_from(&found));
                return Err(JournalError::Other { path: path.to_owned(), found, asked });
            }
            Some(found) => {
                file.set_len(whole).map_err(failed)?;
                file.seek(SeekFrom::End(0)).map_err(failed)?;
                found
            }
        };
        let course = head.horizon.map(|lasted| Course { lasted, phases: head.phases });
        Ok(Self { path: path.to_owned(), file, course, done })
    }

    /// The cases that were finished before it was opened.
    pub const fn done(&self) -> &BTreeMap<u64, Line> {
        &self.done
    }

    /// In real time: how a run without faults went by at the start of the campaign.
    pub const fn course(&self) -> Option<&Course> {
        self.course.as_ref()
    }

    /// Appends a finished case.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub fn keep(&mut self, line: &Line) -> Result<(), JournalError> {
        write(&mut self.file, line)
            .map_err(|source| JournalError::Io { path: self.path.clone(), source })
    }
}

/// Reads the journal at `path` case by case, without changing it: in the order of their numbers, since the order in which several
/// threads end is chance. Only cases that ended before an earlier one are held back. A truncated last line is left out.
///
/// # Errors
///
/// When it cannot be read, or a line is invalid.
pub fn each_line(path: &Path, take: &mut dyn FnMut(Line)) -> Result<(), JournalError> {
    let failed = |source| JournalError::Io { path: path.to_owned(), source };
    let (mut next, mut early) = (0, BTreeMap::new());
    let mut in_order = |line: Line| {
        early.insert(line.number, line);
        while let Some(line) = early.remove(&next) {
            next += 1;
            take(line);
        }
    };
    read(path, &File::open(path).map_err(failed)?, &mut in_order)?;
    early.into_values().for_each(take);
    Ok(())
}

/// The head, and the number of bytes in complete lines.
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
        // A line that a power failure cut off has no line end.
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
    // A single write, so that a line is complete or truncated at its end.
    file.write_all(&text)
}

#[cfg(test)]
mod tests {
    use super::{Course, Journal, JournalError, Line, build, each_line};
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
    fn a_journal_of_another_build_is_not_continued() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        drop(Journal::open(&path, "toy").unwrap());
        let text = std::fs::read_to_string(&path).unwrap();
        let other = text.replace(build(), &format!("{} (build 00000000)", record::VERSION));
        assert_ne!(text, other);
        std::fs::write(&path, other).unwrap();
        let error = Journal::open(&path, "toy").unwrap_err().to_string();
        assert!(error.contains("(build 00000000)"), "{error}");
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

    /// The page of a campaign on several threads named another first case than the campaign itself.
    #[test]
    fn cases_are_read_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        let mut journal = Journal::open(&path, "toy").unwrap();
        let lines = lines(5);
        for place in [1, 0, 4, 2] {
            journal.keep(&lines[place]).unwrap();
        }
        let mut read = Vec::new();
        each_line(&path, &mut |line| read.push(line.number)).unwrap();
        assert_eq!(read, [0, 1, 2, 4]);
    }

    /// Durations in real time differ; the first one determines the cases for good.
    #[test]
    fn the_first_horizon_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        let course = |ms| {
            let lasted = Span::from_millis(ms);
            Course { lasted, phases: [("lap".to_owned(), vec![lasted])].into() }
        };
        let open = |ms| Journal::open_with(&path, "toy", Some(course(ms)));
        assert_eq!(open(8_003).unwrap().course(), Some(&course(8_003)));
        assert_eq!(open(7_998).unwrap().course(), Some(&course(8_003)));
        // A campaign in virtual time is a different campaign.
        assert!(matches!(Journal::open(&path, "toy"), Err(JournalError::Other { .. })));
    }

    #[test]
    fn that_of_another_campaign_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.jsonl");
        drop(Journal::open(&path, "laps, seed 1").unwrap());
        let error = Journal::open(&path, "laps, seed 2").unwrap_err();
        assert!(matches!(error, JournalError::Other { .. }));
        assert!(
            error.to_string().ends_with("another campaign: seed 1 there, seed 2 here"),
            "{error}"
        );
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
