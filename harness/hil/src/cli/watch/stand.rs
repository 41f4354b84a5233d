//! What the view shows beside the model of the run: plans, notes and questions.

use harness::stopwatch::Stopwatch;
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

/// Progress of a plan.
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
        })))
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Stand> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stand {
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

    /// Appends a character to the answer.
    pub(super) fn type_in(&mut self, character: char) {
        if let Some(asking) = &mut self.asking
            && asking.typed.chars().count() < TYPED_CHARS_MAX
        {
            asking.typed.push(character);
        }
    }

    /// Deletes the last character.
    pub(super) fn erase(&mut self) {
        if let Some(asking) = &mut self.asking {
            asking.typed.pop();
        }
    }

    /// Completes the answer.
    pub(super) fn enter(&mut self) {
        if let Some(asking) = &mut self.asking
            && self.answers.len() < LINES_MAX
        {
            self.answers.push_back(std::mem::take(&mut asking.typed).trim().to_owned());
        }
    }

    /// Returns the next answer.
    pub(super) fn answer(&mut self) -> Option<String> {
        self.answers.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::SharedStand;

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
}
