//! Whether the device under test says what the run needs, and whether that is more than anybody can keep.

use wire::time::{Span, Timestamp};

/// Time limit for the first state of a device under test that is started for the run. Assumption: the slowest interpreter
/// starts in 2 s.
pub const START_LIMIT: Span = Span::from_secs(10);

/// Window for the count of reports.
const WINDOW: Span = Span::from_secs(1);
/// Most reports within the window. Assumption: a controller reports its state at 1 kHz at most, and reports that
/// gathered in the pipes while this machine was busy come at once.
const REPORTS_MAX: u64 = 20_000;
/// Most notes in a record about ports, and about lines that are no reports. Further ones are counted.
pub const NOTES_MAX: u64 = 500;

/// Counts what is noted in the record.
#[derive(Debug, Clone, Copy, Default)]
pub struct Notes(u64);

impl Notes {
    /// Counts one more; returns whether it is kept.
    pub const fn keeps(&mut self) -> bool {
        self.0 += 1;
        self.0 <= NOTES_MAX
    }

    /// A note about those that were not kept: `12 more lines are not noted`.
    pub fn beyond(self, what: &str) -> Option<String> {
        let more = self.0.checked_sub(NOTES_MAX).filter(|more| *more > 0)?;
        Some(format!("{more} more {what} are not noted"))
    }
}

/// Counts the reports of the device under test: each is recorded, and the disk is finite.
#[derive(Debug, Clone, Default)]
pub struct Talk {
    reports: u64,
    /// Lines that are not reports.
    unread: Notes,
    window: Option<(Timestamp, u64)>,
}

impl Talk {
    /// Counts a report; returns whether it is one too many.
    pub fn floods(&mut self, now: Timestamp) -> bool {
        self.reports += 1;
        self.exceeds(now)
    }

    /// Counts a report or another line; returns whether it is one too many.
    pub fn exceeds(&mut self, now: Timestamp) -> bool {
        let (began, count) = self.window.get_or_insert((now, 0));
        if now - *began >= WINDOW {
            (*began, *count) = (now, 0);
        }
        *count += 1;
        *count > REPORTS_MAX
    }

    /// Counts a line that is not a report; returns whether a note of it is kept.
    pub const fn misspoke(&mut self) -> bool {
        self.unread.keeps()
    }

    /// A note about the lines of which none is kept.
    pub fn unnoted(&self) -> Option<String> {
        self.unread.beyond("lines of the device under test that are no reports")
    }

    /// What it has sent instead of a state in all this time, to stand behind its name.
    pub fn why_silent(&self, waited: Span) -> String {
        let said = match (self.reports, self.unread.0) {
            (0, 0) => "said nothing".to_owned(),
            (0, 1) => "said one line that is no report".to_owned(),
            (0, unread) => format!("said {unread} lines that are no reports"),
            _ => "reported no state".to_owned(),
        };
        format!("{said} within {} s", waited.as_secs_f64())
    }

    pub fn why() -> String {
        format!(
            "the device under test sent more than {REPORTS_MAX} reports within {} s",
            WINDOW.as_secs_f64()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{NOTES_MAX, REPORTS_MAX, Talk, WINDOW};
    use wire::time::Timestamp;

    #[test]
    fn what_was_said_instead_of_a_state_is_told() {
        let mut talk = Talk::default();
        assert_eq!(talk.why_silent(WINDOW), "said nothing within 1 s");
        talk.misspoke();
        assert_eq!(talk.why_silent(WINDOW), "said one line that is no report within 1 s");
        talk.misspoke();
        assert_eq!(talk.why_silent(WINDOW), "said 2 lines that are no reports within 1 s");
        talk.floods(Timestamp::ZERO);
        assert_eq!(talk.why_silent(WINDOW), "reported no state within 1 s");
        assert_eq!((3..=NOTES_MAX).find(|_| !talk.misspoke()), None);
        assert!(talk.unnoted().is_none() && !talk.misspoke());
        assert!(talk.unnoted().unwrap().starts_with("1 more lines of"));
    }

    #[test]
    fn only_more_than_anybody_needs_is_a_flood() {
        let mut talk = Talk::default();
        let mut now = Timestamp::ZERO;
        for _ in 0..3 {
            assert!((0..REPORTS_MAX).all(|_| !talk.floods(now)));
            now += WINDOW;
        }
        assert!(!(0..REPORTS_MAX).any(|_| talk.floods(now)));
        assert!(talk.floods(now));
    }
}
