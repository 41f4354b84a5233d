//! Carries out each case once and stores its result in a journal, so that an interrupted envelope can resume.

use super::case::{Case, CaseId, CaseResult};
use super::executor::Executor;
use super::journal::{Journal, JournalError, Line};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

/// Carries out the cases that are missing in a journal, and adds them. Lines are numbered in order.
#[derive(Debug)]
pub struct Kept<'a, E> {
    executor: &'a E,
    keeping: Mutex<Keeping>,
}

#[derive(Debug)]
struct Keeping {
    journal: Journal,
    known: BTreeMap<CaseId, CaseResult>,
    next: u64,
    failure: Option<JournalError>,
}

impl<'a, E: Executor> Kept<'a, E> {
    /// Opens or creates the journal at `path`; `what` identifies the campaign.
    ///
    /// # Errors
    ///
    /// See [`Journal::open`].
    pub fn open(executor: &'a E, path: &Path, what: &str) -> Result<Self, JournalError> {
        let mut journal = Journal::open(path, what)?;
        let done = std::mem::take(&mut journal.done);
        let next = done.last_key_value().map_or(0, |(number, _)| number + 1);
        let result = |line: Line| CaseResult { announced: line.announced, ..line.result };
        let known = done.into_values().map(|line| (line.case.id(""), result(line))).collect();
        Ok(Self { executor, keeping: Mutex::new(Keeping { journal, known, next, failure: None }) })
    }

    fn kept(&self) -> std::sync::MutexGuard<'_, Keeping> {
        self.keeping.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// The error that stopped the journal. Results since then are lost with this process.
    pub fn failure(&self) -> Option<JournalError> {
        self.kept().failure.take()
    }
}

impl<E: Executor> Executor for Kept<'_, E> {
    fn execute(&self, case: &Case) -> CaseResult {
        let id = case.id("");
        if let Some(result) = self.kept().known.get(&id) {
            return result.clone();
        }
        let result = self.executor.execute(case);
        if result.is_given_up() {
            return result;
        }
        let mut keeping = self.kept();
        let (number, announced) = (keeping.next, result.announced);
        let line = Line { number, case: case.clone(), result: result.clone(), announced };
        if let Err(failure) = keeping.journal.keep(&line) {
            keeping.failure.get_or_insert(failure);
        }
        keeping.next += 1;
        keeping.known.insert(id, line.result);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::Kept;
    use crate::toy::{Toy, space};
    use crate::{Case, CaseResult, Executor, Random, Search as _, each_line};
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Counts the cases that it carries out.
    #[derive(Default)]
    struct Counted {
        toy: Toy,
        times: AtomicU64,
    }

    impl Executor for Counted {
        fn execute(&self, case: &Case) -> CaseResult {
            self.times.fetch_add(1, Ordering::Relaxed);
            CaseResult { announced: true, ..self.toy.execute(case) }
        }
    }

    #[test]
    fn what_was_carried_out_is_not_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.jsonl");
        let mut random = Random::new(&space(), 9);
        let cases: Vec<Case> = (0..8).map(|_| random.next()).collect();
        let counted = Counted::default();
        let times = || counted.times.load(Ordering::Relaxed);
        let open = || Kept::open(&counted, &path, "toy").unwrap();
        let (first, cut) = (open(), cases.len() / 2);
        let before: Vec<_> = cases[..cut].iter().map(|case| first.execute(case)).collect();
        assert_eq!((times(), first.failure().is_none()), (4, true));
        drop(first);
        let second = open();
        let after: Vec<_> = cases.iter().map(|case| second.execute(case)).collect();
        assert_eq!(times(), 8, "four of them were known");
        assert_eq!(after[..cut], before);
        assert!(after.iter().all(|result| result.announced), "an envelope asks for it");
        let mut numbers = Vec::new();
        each_line(&path, &mut |line| numbers.push(line.number)).unwrap();
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7]);
    }
}
