//! Latest events of a run, as text.

use record::text::OneLine;
use std::collections::VecDeque;
use wire::time::Timestamp;

/// Maximum number of pieces kept for slow readers.
pub const NEWS_MAX: usize = 512;
/// Maximum length of a piece.
const TEXT_CHARS_MAX: usize = 200;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewsKind {
    StepBegan,
    StepEnded,
    Health,
    /// The device under test refused a mission or broke it off.
    Refusal,
    /// A fault of the plan began, ended, or did something.
    Fault,
    Broken,
    /// A failure, a loss or a repair; or a reply of a person.
    Note,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Number, counted from 1.
    pub number: u64,
    pub at: Timestamp,
    pub kind: NewsKind,
    pub text: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct News {
    pieces: VecDeque<Piece>,
    count: u64,
}

impl News {
    pub(super) fn add(&mut self, at: Timestamp, kind: NewsKind, text: &str) {
        if self.pieces.len() == NEWS_MAX {
            self.pieces.pop_front();
        }
        self.count += 1;
        let text = OneLine(text).to_string().chars().take(TEXT_CHARS_MAX).collect();
        self.pieces.push_back(Piece { number: self.count, at, kind, text });
    }

    /// Returns the pieces after the one with this number, and how many of those are no longer kept.
    pub fn after(&self, number: u64) -> (Vec<Piece>, u64) {
        let first = self.pieces.front().map_or(self.count + 1, |piece| piece.number);
        let new = self.pieces.iter().filter(|piece| piece.number > number).cloned().collect();
        (new, first.saturating_sub(number + 1))
    }

    pub fn latest(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().rev()
    }

    /// Returns how many pieces there were.
    pub const fn count(&self) -> u64 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::{NEWS_MAX, News, NewsKind};
    use wire::time::Timestamp;

    #[test]
    fn what_is_forgotten_is_counted() {
        let mut news = News::default();
        assert_eq!(news.after(0), (Vec::new(), 0));
        let total = NEWS_MAX as u64 + 7;
        for _ in 0..total {
            news.add(Timestamp::ZERO, NewsKind::Note, "a\u{1b}[2J\nb");
        }
        let (pieces, lost) = news.after(2);
        assert_eq!((pieces.len(), lost), (NEWS_MAX, 5));
        assert_eq!(news.after(total), (Vec::new(), 0));
        // Text of a device cannot move the cursor of a terminal.
        assert_eq!(pieces[0].text, "a\\u{1b}[2J\\nb");
    }
}
