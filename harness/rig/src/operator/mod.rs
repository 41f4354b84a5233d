//! What a plan asks a person: numbers to read off, and manual work.
//!
//! * [`number`]: a number with its unit, as a person writes it. Anything else is refused with a reason.
//! * [`question`]: one question, repeated until the answer is usable, a bounded number of times.
//! * [`answers`], [`file`](mod@file): answers given before the run, on the command line or in a file.
//! * [`by_hand`]: what a person does for real devices: carry, set and measure them.
//! * [`Person`]: a person who answers questions during a run.
//!
//! The record keeps every reply with its author, source and time. Nothing here reads a terminal or a clock; the command
//! line does.

pub mod answers;
mod asking;
mod attendance;
pub mod by_hand;
pub mod file;
pub mod number;
pub mod question;
#[cfg(test)]
mod tests;

pub use answers::{Answers, GivenAnswer};
pub use attendance::{AnswersError, Attendance};
pub use by_hand::RealRoles;
pub use file::AnswerFile;

use plan::{Answer, Plan};
use question::{Heard, Question};
use record::{Reply, Through};
use std::collections::BTreeMap;
use std::fmt;

/// Whether the plan asks a person for anything on a bench with these real devices.
pub fn asks_a_person(plan: &Plan, real: RealRoles) -> bool {
    let mut found = Vec::new();
    asking::questions(plan, &plan.steps, 1, real, &mut found);
    !found.is_empty()
}

/// What the person has typed by now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A whole line, without its line ending.
    Text(String),
    /// Nothing yet.
    NotYet,
    /// The terminal is closed; nothing more will come.
    Gone,
}

/// A person who answers questions during a run. No method blocks.
pub trait Person: fmt::Debug + Send {
    fn name(&self) -> String;
    /// Begins a question. Text typed earlier does not answer it.
    fn ask(&mut self, text: &str);
    /// Adds a message to the open question.
    fn say(&mut self, text: &str);
    /// What was typed since.
    fn heard(&mut self) -> Line;
    /// Closes the question; no input is expected any more.
    fn done(&mut self);
    /// Seconds since 1970-01-01 00:00 UTC, for the record.
    fn unix_s(&self) -> Option<i64>;
}

#[derive(Debug, Clone, PartialEq)]
pub enum Asked {
    Replied(Reply),
    /// In simulation: the manual work counts as done.
    Assumed,
    /// The person has been asked; see [`Operator::heard`].
    Waiting,
    /// There is no answer, and the run cannot go on; why, in a sentence.
    Nobody(String),
}

/// Answers for a run: those given in advance, and those of the person beside the bench, if there is one.
#[derive(Debug)]
pub struct Operator {
    answers: Answers,
    bench: Bench,
    /// Number of used answers to each question.
    used: BTreeMap<String, usize>,
}

#[derive(Debug)]
enum Bench {
    Simulated,
    Real { person: Option<Box<dyn Person>>, open: Option<Question> },
}

impl Default for Operator {
    fn default() -> Self {
        Self::simulated(Answers::default())
    }
}

impl Operator {
    /// For a simulated bench: without a person, and with manual work assumed done.
    pub const fn simulated(answers: Answers) -> Self {
        Self { answers, bench: Bench::Simulated, used: BTreeMap::new() }
    }

    /// For a bench in real time. Answers given in advance take precedence over asking the person.
    pub const fn live(answers: Answers, person: Option<Box<dyn Person>>) -> Self {
        let bench = Bench::Real { person, open: None };
        Self { answers, bench, used: BTreeMap::new() }
    }

    /// A copy that has used the same answers. `None` where a person answers.
    pub(crate) fn copied(&self) -> Option<Self> {
        let Bench::Simulated = self.bench else { return None };
        let (answers, used) = (self.answers.clone(), self.used.clone());
        Some(Self { answers, bench: Bench::Simulated, used })
    }

    pub fn ask(&mut self, text: &str, answer: Option<&Answer>) -> Asked {
        match answer {
            Some(answer) => {
                let used = self.used.entry(answer.name.to_string()).or_default();
                if let Some(reply) = self.answers.reply(text, answer, *used) {
                    *used += 1;
                    return Asked::Replied(reply);
                }
            }
            None => {
                if let Some(by) = self.answers.done_by_hand() {
                    let (text, by) = (text.to_owned(), by.to_owned());
                    return Asked::Replied(Reply::done(text, by, Through::File));
                }
            }
        }
        match (&mut self.bench, answer) {
            (Bench::Real { person: Some(person), open }, _) => {
                let question = Question::new(text, answer.cloned());
                person.ask(&question.shown());
                *open = Some(question);
                Asked::Waiting
            }
            (Bench::Simulated, None) => Asked::Assumed,
            (_, Some(Answer { name, .. })) => Asked::Nobody(format!(
                "no answer \"{name}\" was given, and nobody is there to be asked"
            )),
            (_, None) => {
                Asked::Nobody(format!("nobody is there to do what the plan asks for: {text}"))
            }
        }
    }

    /// Outcome of what the person has typed for the open question; `None` while there is nothing to do.
    pub fn heard(&mut self) -> Option<Asked> {
        let Bench::Real { person: Some(person), open } = &mut self.bench else { return None };
        let question = open.as_mut()?;
        loop {
            let asked = match person.heard() {
                Line::NotYet => return None,
                Line::Gone => Asked::Nobody(format!(
                    "the terminal was closed before the question was answered: {}",
                    question.text()
                )),
                Line::Text(line) => match question.hear(&line) {
                    Heard::Again(why) => {
                        person.say(&why);
                        continue;
                    }
                    Heard::GivenUp(why) => Asked::Nobody(why),
                    Heard::Answered(value) => Asked::Replied(Reply {
                        unix_s: person.unix_s(),
                        ..question.reply(value, person.name(), Through::Terminal)
                    }),
                },
            };
            person.done();
            *open = None;
            return Some(asked);
        }
    }
}
