//! What happened last, in words.

use std::collections::VecDeque;
use wire::time::Timestamp;

/// Pieces of news that are kept for whoever has not read them yet.
pub const NEWS_MAX: usize = 512;
/// The longest text of a piece that is kept.
const TEXT_CHARS_MAX: usize = 200;

/// What kind of news.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewsKind {
    /// A step of the plan began.
    StepBegan,
    /// A step of the plan ended.
    StepEnded,
    /// The device under test changed its mind about itself.
    Health,
    /// The device under test refused a mission or broke it off.
    Refusal,
    /// A fault of the plan began, ended, or did something.
    Fault,
    /// A property does not hold.
    Broken,
    /// Something went wrong, was dropped or was mended; or a person replied.
    Note,
}

/// A piece of news.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Counted from 1.
    pub number: u64,
    /// When, in bench time.
    pub at: Timestamp,
    /// What kind.
    pub kind: NewsKind,
    /// In words, on one line.
    pub text: String,
}

/// The latest news.
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
        let text = text.escape_debug().take(TEXT_CHARS_MAX).collect();
        self.pieces.push_back(Piece { number: self.count, at, kind, text });
    }

    /// The pieces after the one with this number, and how many of those are forgotten already.
    pub fn after(&self, number: u64) -> (Vec<Piece>, u64) {
        let first = self.pieces.front().map_or(self.count + 1, |piece| piece.number);
        let new = self.pieces.iter().filter(|piece| piece.number > number).cloned().collect();
        (new, first.saturating_sub(number + 1))
    }

    /// The latest first.
    pub fn latest(&self) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().rev()
    }

    /// How many there were.
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
        // No text of a device moves the cursor of a terminal.
        assert_eq!(pieces[0].text, "a\\u{1b}[2J\\nb");
    }
}
