//! Cases drawn ahead by a fixed number, carried out in parallel, and learnt from in order.

use super::case::{Case, CaseResult};
use super::journal::Line;
use super::search::Search;
use std::collections::{BTreeMap, VecDeque};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Number of cases drawn before the result of the first is learnt. It is constant, so that the cases of a campaign
/// depend neither on the machines that carry them out nor on their number. A machine that is late by the time of this
/// many cases does not delay the others.
pub const WINDOW: u64 = 64;

/// Interval at which a stop is possible while no result arrives.
const WAITING: Duration = Duration::from_millis(100);

/// Progress of cases.
pub(super) enum Step<'a> {
    /// A case was carried out; in any order.
    Done(&'a Line),
    /// A case was learnt from, in order.
    Learnt {
        /// The case.
        line: &'a Line,
        /// Whether the result was known before.
        resumed: bool,
    },
    /// No result arrived for a while.
    Waiting,
}

/// Draws `cases` cases and has them carried out, `threads` in parallel.
pub(super) struct Window {
    pub(super) cases: u64,
    pub(super) threads: NonZeroUsize,
}

impl Window {
    /// `known` returns results from before, `job` carries out a case, `tell` receives each step; false or an error
    /// stops. Cases under way are then finished and reported. Returns true if it was stopped.
    pub(super) fn run<E>(
        &self,
        search: &mut dyn Search,
        known: &dyn Fn(u64, &Case) -> Option<CaseResult>,
        job: &(dyn Fn(&Case) -> CaseResult + Sync),
        tell: &mut dyn FnMut(Step<'_>) -> Result<bool, E>,
    ) -> Result<bool, E> {
        let (hand_out, todo) = channel();
        let (finished, results) = channel();
        let (todo, stopped) = (Mutex::new(todo), AtomicBool::new(false));
        thread::scope(|scope| {
            for _ in 0..self.threads.get() {
                let (todo, stopped, finished) = (&todo, &stopped, finished.clone());
                scope.spawn(move || carry_out(todo, stopped, &finished, job));
            }
            drop(finished);
            let ahead = VecDeque::new();
            let mut drawing = Drawing { search, known, hand_out, ahead, drawn: 0 };
            let gone = self.go(&mut drawing, &results, tell);
            stopped.store(true, Ordering::Relaxed);
            drop(drawing);
            // Keeps the results of cases under way; a request to stop makes no difference any more.
            for line in results {
                tell(Step::Done(&line))?;
            }
            gone
        })
    }

    fn go<E>(
        &self,
        drawing: &mut Drawing<'_>,
        results: &Receiver<Line>,
        tell: &mut dyn FnMut(Step<'_>) -> Result<bool, E>,
    ) -> Result<bool, E> {
        for _ in 0..WINDOW.min(self.cases) {
            drawing.draw();
        }
        let mut early = BTreeMap::new();
        let mut learnt = 0;
        while let Some(next) = drawing.ahead.front() {
            let found = match next {
                Some(line) => Some((line.clone(), true)),
                None => early.remove(&learnt).map(|line| (line, false)),
            };
            if let Some((line, resumed)) = found {
                drawing.ahead.pop_front();
                drawing.search.learn(&line.case, &line.result);
                learnt += 1;
                // One case is drawn for each that is learnt, so that each draw always knows the same results.
                if drawing.drawn < self.cases {
                    drawing.draw();
                }
                if !tell(Step::Learnt { line: &line, resumed })? {
                    return Ok(true);
                }
                continue;
            }
            let goes_on = match results.recv_timeout(WAITING) {
                Ok(line) => {
                    let goes_on = tell(Step::Done(&line))?;
                    early.insert(line.number, line);
                    goes_on
                }
                Err(RecvTimeoutError::Timeout) => tell(Step::Waiting)?,
                // All threads have ended.
                Err(RecvTimeoutError::Disconnected) => false,
            };
            if !goes_on {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

struct Drawing<'a> {
    search: &'a mut dyn Search,
    known: &'a dyn Fn(u64, &Case) -> Option<CaseResult>,
    hand_out: Sender<(u64, Case)>,
    /// Cases drawn and not yet learnt from, the oldest first, with their result if it was known.
    ahead: VecDeque<Option<Line>>,
    drawn: u64,
}

impl Drawing<'_> {
    fn draw(&mut self) {
        let (number, case) = (self.drawn, self.search.next());
        self.drawn += 1;
        match (self.known)(number, &case) {
            Some(result) => {
                self.ahead.push_back(Some(Line { number, case, result, announced: false }))
            }
            None => {
                self.ahead.push_back(None);
                // If no thread takes it, the results channel is closed too.
                let _ = self.hand_out.send((number, case));
            }
        }
    }
}

fn carry_out(
    todo: &Mutex<Receiver<(u64, Case)>>,
    stopped: &AtomicBool,
    finished: &Sender<Line>,
    job: &(dyn Fn(&Case) -> CaseResult + Sync),
) {
    loop {
        let next = todo.lock().unwrap_or_else(PoisonError::into_inner).recv();
        let Ok((number, case)) = next else { return };
        if stopped.load(Ordering::Relaxed) {
            return;
        }
        let result = job(&case);
        if finished.send(Line { number, case, result, announced: false }).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Step, WINDOW, Window};
    use crate::{Case, CaseResult, Search};
    use std::num::NonZeroUsize;

    /// Writes down the events.
    #[derive(Default)]
    struct Scribe {
        drawn: u64,
        learnt: u64,
        /// Number of cases learnt when each case was drawn.
        seen: Vec<u64>,
    }

    impl Search for Scribe {
        fn next(&mut self) -> Case {
            self.drawn += 1;
            self.seen.push(self.learnt);
            Case { seed: self.drawn - 1, ..Case::default() }
        }

        fn learn(&mut self, case: &Case, _: &CaseResult) {
            assert_eq!(case.seed, self.learnt, "in their order");
            self.learnt += 1;
        }
    }

    /// Cases of different duration, so that they overtake one another.
    fn job(case: &Case) -> CaseResult {
        let spins = case.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) % 20_000;
        std::hint::black_box((0..spins).fold(case.seed, |a, b| std::hint::black_box(a ^ b)));
        CaseResult::default()
    }

    fn run(cases: u64, threads: usize, stop_after: u64) -> (Scribe, Vec<u64>, bool) {
        let window = Window { cases, threads: NonZeroUsize::new(threads).unwrap() };
        let (mut scribe, mut done) = (Scribe::default(), Vec::new());
        let known = |number: u64, _: &Case| number.is_multiple_of(5).then(CaseResult::default);
        let stopped = window.run(&mut scribe, &known, &job, &mut |step| {
            if let Step::Done(line) = &step {
                done.push(line.number);
            }
            let enough = matches!(step, Step::Learnt { line, .. } if line.number + 1 == stop_after);
            Ok::<_, ()>(!enough)
        });
        (scribe, done, stopped.unwrap())
    }

    #[test]
    fn a_case_is_drawn_when_all_before_the_window_are_learnt() {
        for threads in [1, 3, 64] {
            let (scribe, mut done, stopped) = run(300, threads, 0);
            assert!(!stopped);
            assert_eq!((scribe.drawn, scribe.learnt), (300, 300));
            let expected: Vec<u64> = (0..300_u64).map(|k| (k + 1).saturating_sub(WINDOW)).collect();
            assert_eq!(scribe.seen, expected);
            done.sort_unstable();
            let unknown: Vec<u64> = (0..300).filter(|number| number % 5 != 0).collect();
            assert_eq!(done, unknown, "each once, and none that was known");
        }
    }

    #[test]
    fn what_is_under_way_when_it_is_stopped_is_told_of_and_nothing_more_begins() {
        let (scribe, done, stopped) = run(10_000, 4, 100);
        assert!(stopped);
        assert_eq!(scribe.learnt, 100);
        assert!((80..100 + WINDOW as usize).contains(&done.len()), "{}", done.len());
    }

    #[test]
    fn an_error_ends_it() {
        let window = Window { cases: 1_000, threads: NonZeroUsize::new(2).unwrap() };
        let mut told = 0;
        let ended = window.run(&mut Scribe::default(), &|_, _| None, &job, &mut |_| {
            told += 1;
            if told < 10 { Ok(true) } else { Err("no disk") }
        });
        assert_eq!(ended, Err("no disk"));
    }
}
