//! Replays a log onto a bus: computes when each entry is due.
//!
//! Without IO and without a clock. The owner of the port waits for [`Replay::next_wakeup`], and sends what
//! [`Replay::transmit`] returns, until it returns `None`.

use super::{Entry, LogError};
use wire::time::{Span, Timestamp};

/// Entries with due times: the first at the start, the others with their original spacing.
///
/// An entry with an earlier time than the previous one, as at the seam of two logs, is due at once. A returned entry
/// has the time at which it was due.
#[derive(Debug)]
pub struct Replay<I> {
    entries: I,
    start: Timestamp,
    speed: f64,
    /// Time of the first entry.
    origin: Option<Timestamp>,
    next: Next,
}

#[derive(Debug)]
enum Next {
    Due(Timestamp, Box<Entry>),
    Failed(LogError),
    Ended,
}

impl<I: Iterator<Item = Result<Entry, LogError>>> Replay<I> {
    /// Starts with the first entry at `start`; `speed` times as fast as it was logged. An invalid or non-positive speed
    /// counts as 1.
    pub fn new(entries: I, start: Timestamp, speed: f64) -> Self {
        let speed = if speed.is_finite() && speed > 0.0 { speed } else { 1.0 };
        let mut replay = Self { entries, start, speed, origin: None, next: Next::Ended };
        replay.next = replay.fetch(start);
        replay
    }

    /// When the next entry is due; [`Timestamp::MAX`] after the last.
    pub const fn next_wakeup(&self) -> Timestamp {
        match &self.next {
            Next::Due(at, _) => *at,
            // An error is reported at once.
            Next::Failed(_) => Timestamp::ZERO,
            Next::Ended => Timestamp::MAX,
        }
    }

    /// Returns the next entry due by `now`; call it until it returns `None`.
    ///
    /// # Errors
    /// The reader's error, once; then the replay is over.
    pub fn transmit(&mut self, now: Timestamp) -> Result<Option<Entry>, LogError> {
        match std::mem::replace(&mut self.next, Next::Ended) {
            Next::Due(at, entry) if at <= now => {
                self.next = self.fetch(at);
                Ok(Some(Entry { at, ..*entry }))
            }
            Next::Due(at, entry) => {
                self.next = Next::Due(at, entry);
                Ok(None)
            }
            Next::Failed(error) => Err(error),
            Next::Ended => Ok(None),
        }
    }

    /// The source of the entries, read as far as needed.
    pub fn into_entries(self) -> I {
        self.entries
    }

    fn fetch(&mut self, not_before: Timestamp) -> Next {
        match self.entries.next() {
            None => Next::Ended,
            Some(Err(error)) => Next::Failed(error),
            Some(Ok(entry)) => {
                let since = entry.at.since(*self.origin.get_or_insert(entry.at));
                // Exact to the nanosecond at the original speed.
                let since = match self.speed {
                    1.0 => since,
                    speed => Span::from_secs_f64(since.as_secs_f64() / speed),
                };
                Next::Due((self.start + since).max(not_before), Box::new(entry))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Entry, LogError, Replay, Timestamp};
    use crate::{Channel, Direction, Payload};
    use wire::can::{CanFrame, StandardId};

    const START: Timestamp = Timestamp::from_nanos(1_000_000);

    fn entries(times_ms: &[i64]) -> Vec<Result<Entry, LogError>> {
        let frame = CanFrame::new(StandardId::ZERO, &[]).unwrap();
        let entry = |ms: &i64| Entry {
            at: Timestamp::from_nanos(1_436_509_052_000_000_000 + ms * 1_000_000),
            channel: Channel::CAN0,
            direction: Some(Direction::Rx),
            payload: Payload::Frame(frame),
        };
        times_ms.iter().map(|ms| Ok(entry(ms))).collect()
    }

    fn due_ms(mut replay: Replay<impl Iterator<Item = Result<Entry, LogError>>>) -> Vec<i64> {
        let mut due = Vec::new();
        while replay.next_wakeup() < Timestamp::MAX {
            let now = replay.next_wakeup();
            let early = Timestamp::from_nanos(now.as_nanos() - 1);
            assert_eq!(replay.transmit(early).unwrap(), None);
            due.push(replay.transmit(now).unwrap().unwrap().at.since(START).as_nanos() / 1_000_000);
        }
        assert_eq!(replay.transmit(Timestamp::MAX).unwrap(), None);
        due
    }

    #[test]
    fn entries_are_due_as_far_apart_as_they_were() {
        let log = entries(&[0, 20, 20, 15, 40]);
        assert_eq!(due_ms(Replay::new(log.into_iter(), START, 1.0)), [0, 20, 20, 20, 40]);
        let log = entries(&[5, 25, 45]);
        assert_eq!(due_ms(Replay::new(log.into_iter(), START, 2.0)), [0, 10, 20]);
        assert!(due_ms(Replay::new(entries(&[]).into_iter(), START, 1.0)).is_empty());
    }

    #[test]
    fn an_error_is_told_once() {
        let mut log = entries(&[0]);
        let source = std::io::ErrorKind::NotFound.into();
        log.push(Err(LogError::Unreadable { path: "x.log".into(), source }));
        let mut replay = Replay::new(log.into_iter(), START, 1.0);
        assert!(replay.transmit(START).unwrap().is_some());
        assert!(replay.next_wakeup() <= START);
        assert!(replay.transmit(START).is_err());
        assert_eq!(replay.transmit(Timestamp::MAX).unwrap(), None);
    }
}
