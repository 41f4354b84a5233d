//! The person at the terminal, with questions in the view.

use super::super::terminal::Terminal;
use super::stand::SharedStand;
use harness::operator::{Line, Person};

/// The person at the terminal on which the view is drawn.
#[derive(Debug)]
pub(super) struct Viewer {
    pub(super) at: Terminal,
    pub(super) stand: SharedStand,
}

impl Person for Viewer {
    fn name(&self) -> String {
        self.at.name()
    }

    fn ask(&mut self, text: &str) {
        self.stand.lock().ask(text);
    }

    fn say(&mut self, text: &str) {
        self.stand.lock().say(text);
    }

    fn heard(&mut self) -> Line {
        let mut stand = self.stand.lock();
        match stand.answer() {
            Some(line) => Line::Text(line),
            // The view broke down, and no keys are read any more.
            None if stand.is_over => Line::Gone,
            None => Line::NotYet,
        }
    }

    fn done(&mut self) {
        self.stand.lock().asking = None;
    }

    fn unix_s(&self) -> Option<i64> {
        self.at.unix_s()
    }
}
