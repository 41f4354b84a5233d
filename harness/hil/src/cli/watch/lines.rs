//! A run as plain lines, where no picture can be drawn: what happened and when, with a limited number of lines at once.

use super::super::progress::Screen;
use harness::stopwatch::Stopwatch;
use views::watch::{Feed, Piece};

/// Interval between two updates, in seconds.
const PERIOD_S: f64 = 1.0;
/// Maximum lines per update.
const LINES_AT_ONCE: usize = 10;

/// Prints the events of a run.
#[derive(Debug)]
pub(super) struct Lines {
    screen: Screen,
    feed: Feed,
    stopwatch: Stopwatch,
    looked_s: f64,
    told: u64,
}

impl Lines {
    pub(super) fn new(screen: &Screen, feed: Feed) -> Self {
        let (screen, stopwatch) = (screen.clone(), Stopwatch::start());
        Self { screen, feed, stopwatch, looked_s: f64::NEG_INFINITY, told: 0 }
    }

    /// Prints new events, unless the last update was just now.
    pub(super) fn look(&mut self) {
        let now_s = self.stopwatch.elapsed_s();
        if now_s - self.looked_s >= PERIOD_S {
            self.looked_s = now_s;
            self.tell();
        }
    }

    pub(super) fn tell(&mut self) {
        let (pieces, forgotten) = self.feed.news_after(self.told);
        let Some(last) = pieces.last() else { return };
        self.told = last.number;
        for line in chosen(&pieces, forgotten) {
            self.screen.note(&line);
        }
    }
}

/// Formats the latest pieces as lines, preceded by the number of omitted ones.
fn chosen(pieces: &[Piece], forgotten: u64) -> Vec<String> {
    let skipped = pieces.len().saturating_sub(LINES_AT_ONCE);
    let untold = forgotten + skipped as u64;
    let mut lines = Vec::new();
    if untold > 0 {
        lines.push(format!("  ... {untold} more, all of them in the record"));
    }
    let line = |piece: &Piece| format!("{:>12.3} s  {}", piece.at.as_secs_f64(), piece.text);
    lines.extend(pieces[skipped..].iter().map(line));
    lines
}

#[cfg(test)]
mod tests {
    use super::chosen;
    use views::watch::{NewsKind, Piece};
    use wire::time::Timestamp;

    #[test]
    fn a_fast_run_does_not_flood_a_log() {
        let piece = |number| Piece {
            number,
            at: Timestamp::from_secs_f64(number as f64 * 7.25),
            kind: NewsKind::StepBegan,
            text: format!("begin steps[{number}]: wait 7 s"),
        };
        let pieces: Vec<Piece> = (1..=14).map(piece).collect();
        let lines = chosen(&pieces, 3);
        assert_eq!(lines.len(), 11);
        assert_eq!(lines[0], "  ... 7 more, all of them in the record");
        assert_eq!(lines[1], "      36.250 s  begin steps[5]: wait 7 s");
        assert_eq!(chosen(&pieces[..2], 0).len(), 2);
    }
}
