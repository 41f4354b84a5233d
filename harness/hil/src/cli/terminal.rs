//! The person at the terminal. A thread reads the lines and may block; the harness must not.

use super::progress::Screen;
use crate::who;
use harness::operator::{Line, Person};
use live::unix_time;
use std::io::{self, BufRead, IsTerminal, Read};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// Lines in the queue; further ones wait in the terminal itself.
const LINES_MAX: usize = 16;
/// Maximum length of a line; no answer comes near it, and the rest of a longer one is discarded.
const LINE_BYTES_MAX: u64 = 4_096;
/// Name of the person by default.
const SOMEBODY: &str = "somebody at the terminal";

/// The person at the terminal; a clone is the same person.
#[derive(Debug, Clone)]
pub(super) struct Terminal {
    screen: Screen,
    name: String,
    lines: Arc<Mutex<Option<Receiver<String>>>>,
}

impl Terminal {
    /// Returns the person at the terminal, if the standard input and error are a terminal.
    pub(super) fn of_stdin(screen: &Screen, name: Option<&str>) -> Option<Self> {
        if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
            return None;
        }
        let name =
            name.map(str::to_owned).or_else(who::user).filter(|name| !name.trim().is_empty());
        let name = name.unwrap_or_else(|| SOMEBODY.to_owned());
        Some(Self { screen: screen.clone(), name, lines: Arc::default() })
    }

    pub(super) fn name(&self) -> String {
        self.name.clone()
    }

    fn next_line(&self) -> Line {
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        // Nothing is read from the terminal before the first question.
        let lines = lines.get_or_insert_with(start_reading);
        match lines.try_recv() {
            Ok(line) => Line::Text(line),
            Err(TryRecvError::Empty) => Line::NotYet,
            Err(TryRecvError::Disconnected) => Line::Gone,
        }
    }
}

impl Person for Terminal {
    fn name(&self) -> String {
        Self::name(self)
    }

    fn ask(&mut self, text: &str) {
        while matches!(self.next_line(), Line::Text(_)) {}
        self.screen.hold();
        self.screen.note(text);
        self.screen.prompt();
    }

    fn say(&mut self, text: &str) {
        self.screen.note(&format!("  {text}"));
        self.screen.prompt();
    }

    fn heard(&mut self) -> Line {
        self.next_line()
    }

    fn done(&mut self) {
        self.screen.release();
    }

    fn unix_s(&self) -> Option<i64> {
        unix_time::unix_s()
    }
}

/// Reads lines from the standard input until it ends or the receiver is dropped. If the thread cannot start, the
/// terminal counts as closed.
fn start_reading() -> Receiver<String> {
    let (sender, lines) = sync_channel(LINES_MAX);
    let reader = thread::Builder::new().name("operator".to_owned());
    let _ = reader.spawn(move || read_lines(io::stdin().lock(), &sender));
    lines
}

fn read_lines(mut input: impl BufRead, lines: &SyncSender<String>) {
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = (&mut input).take(LINE_BYTES_MAX).read_until(b'\n', &mut line);
        if !matches!(read, Ok(1..)) {
            return;
        }
        if line.last() != Some(&b'\n') && input.skip_until(b'\n').is_err() {
            return;
        }
        if lines.send(String::from_utf8_lossy(&line).trim().to_owned()).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{LINE_BYTES_MAX, LINES_MAX, read_lines};
    use std::sync::mpsc::sync_channel;

    #[test]
    fn lines_come_one_by_one_and_the_end_of_a_long_one_is_thrown_away() {
        let long = "x".repeat(2 * LINE_BYTES_MAX as usize);
        let input = format!("1.5 deg\r\n\n{long}\n2 deg\nlast");
        let (sender, lines) = sync_channel(LINES_MAX);
        read_lines(input.as_bytes(), &sender);
        drop(sender);
        let lines: Vec<String> = lines.iter().collect();
        let short: Vec<&str> = lines.iter().map(|line| &line[..line.len().min(8)]).collect();
        assert_eq!(short, ["1.5 deg", "", "xxxxxxxx", "2 deg", "last"]);
        assert_eq!(lines[2].len() as u64, LINE_BYTES_MAX);
    }
}
