//! What the view shows beside the model of the run: plans, notes and questions.

use harness::stopwatch::Stopwatch;
use ratatui::crossterm::event::KeyCode;
use record::outcome::Outcome;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use views::watch::Feed;

/// Remarks on a question that are kept.
const SAID_MAX: usize = 6;
/// Typed lines that have not been read.
const LINES_MAX: usize = 16;
/// Maximum length of an answer.
const TYPED_CHARS_MAX: usize = 200;

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PlanLine {
    pub(super) name: String,
    pub(super) stage: Stage,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Waiting,
    UnderWay,
    Over(Outcome),
}

/// A question to the person at the terminal, and the answer typed so far.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Asking {
    pub(super) text: String,
    pub(super) said: Vec<String>,
    pub(super) typed: String,
}

/// Where a replay is, and how it goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Playing {
    pub(super) at_s: f64,
    pub(super) end_s: f64,
    /// Times as fast as the run was.
    pub(super) speed: f64,
    pub(super) is_held: bool,
}

/// Keys that move a replay, as parts of the run.
const JUMPS: f64 = 100.0;
/// Speeds that can be chosen.
const SPEED: std::ops::RangeInclusive<f64> = 0.001..=1e6;

impl Playing {
    /// Moves it by a key; whether the key does so.
    pub(super) fn key(&mut self, code: KeyCode) -> bool {
        match code {
            KeyCode::Char(' ' | 'p') => self.is_held = !self.is_held,
            KeyCode::Left => self.at_s -= self.end_s / JUMPS,
            KeyCode::Right => self.at_s += self.end_s / JUMPS,
            KeyCode::Home => self.at_s = 0.0,
            KeyCode::End => self.at_s = self.end_s,
            KeyCode::Char('<') => self.speed /= 2.0,
            KeyCode::Char('>') => self.speed *= 2.0,
            _ => return false,
        }
        self.at_s = self.at_s.clamp(0.0, self.end_s);
        self.speed = self.speed.clamp(*SPEED.start(), *SPEED.end());
        true
    }
}

/// What the view shows beside the model of the run.
#[derive(Debug, Clone)]
pub(super) struct Stand {
    pub(super) plans: Vec<PlanLine>,
    /// The clock is real: the remaining bench time is remaining wall time.
    pub(super) is_real_time: bool,
    pub(super) run: Option<(Feed, Stopwatch)>,
    pub(super) asking: Option<Asking>,
    answers: VecDeque<String>,
    pub(super) is_stopping: bool,
    pub(super) is_over: bool,
    pub(super) replay: Option<Playing>,
}

/// The state of a view, shared by the run and the thread that draws.
#[derive(Debug, Clone)]
pub(super) struct SharedStand(Arc<Mutex<Stand>>);

impl SharedStand {
    pub(super) fn new(plans: &[&str], is_real_time: bool) -> Self {
        let line = |name: &&str| PlanLine { name: (*name).to_owned(), stage: Stage::Waiting };
        Self(Arc::new(Mutex::new(Stand {
            plans: plans.iter().map(line).collect(),
            is_real_time,
            run: None,
            asking: None,
            answers: VecDeque::new(),
            is_stopping: false,
            is_over: false,
            replay: None,
        })))
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Stand> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stand {
    /// Moves a replay on by this much time of the clock; returns the bench time to show.
    pub(super) fn moved_on(&mut self, by_s: f64) -> f64 {
        let Some(playing) = &mut self.replay else { return 0.0 };
        if !playing.is_held {
            playing.at_s = (playing.at_s + by_s * playing.speed).min(playing.end_s);
        }
        playing.at_s
    }

    /// Asks a new question and drops what was typed before.
    pub(super) fn ask(&mut self, text: &str) {
        self.answers.clear();
        self.asking = Some(Asking { text: text.to_owned(), ..Asking::default() });
    }

    /// Adds a remark to the question.
    pub(super) fn say(&mut self, text: &str) {
        if let Some(asking) = &mut self.asking {
            if asking.said.len() == SAID_MAX {
                asking.said.remove(0);
            }
            asking.said.push(text.to_owned());
        }
    }

    pub(super) fn type_in(&mut self, character: char) {
        if let Some(asking) = &mut self.asking
            && asking.typed.chars().count() < TYPED_CHARS_MAX
        {
            asking.typed.push(character);
        }
    }

    pub(super) fn erase(&mut self) {
        if let Some(asking) = &mut self.asking {
            asking.typed.pop();
        }
    }

    pub(super) fn enter(&mut self) {
        if let Some(asking) = &mut self.asking
            && self.answers.len() < LINES_MAX
        {
            self.answers.push_back(std::mem::take(&mut asking.typed).trim().to_owned());
        }
    }

    pub(super) fn answer(&mut self) -> Option<String> {
        self.answers.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::Playing;
    use super::SharedStand;
    use ratatui::crossterm::event::KeyCode;

    #[test]
    fn what_was_typed_before_a_question_is_no_answer_to_it() {
        let stand = SharedStand::new(&["laps"], true);
        let mut stand = stand.lock();
        stand.type_in('x');
        stand.enter();
        assert_eq!(stand.answer(), None, "nobody asked");
        stand.ask("How wide is the gap?");
        "1.5 mmm".chars().for_each(|typed| stand.type_in(typed));
        stand.erase();
        stand.enter();
        stand.ask("And now?");
        assert_eq!(stand.answer(), None, "it was another question");
        "2 mm ".chars().for_each(|typed| stand.type_in(typed));
        stand.enter();
        assert_eq!(stand.answer().as_deref(), Some("2 mm"));
    }

    #[test]
    fn a_replay_goes_on_is_held_and_moves_by_keys() {
        let stand = SharedStand::new(&["plan"], false);
        let mut stand = stand.lock();
        stand.replay = Some(Playing { at_s: 1.0, end_s: 50.0, speed: 4.0, is_held: false });
        assert_eq!(stand.moved_on(2.0), 9.0);
        let mut after = |code, by_s| {
            assert!(stand.replay.as_mut().unwrap().key(code));
            stand.moved_on(by_s)
        };
        assert_eq!(after(KeyCode::Char(' '), 2.0), 9.0, "held");
        assert_eq!(after(KeyCode::Right, 2.0), 9.5, "a hundredth of the run");
        assert_eq!(after(KeyCode::Char('p'), 1.0), 13.5);
        assert_eq!(after(KeyCode::Char('>'), 1.0), 21.5);
        assert_eq!(after(KeyCode::Home, 0.0), 0.0);
        assert_eq!(after(KeyCode::Left, 0.0), 0.0, "not before the begin");
        assert_eq!(after(KeyCode::End, 1.0), 50.0, "not behind the end");
        assert!(!stand.replay.as_mut().unwrap().key(KeyCode::Char('1')), "another key");
    }
}
