//! What a plan asks a person: numbers that somebody reads off, and things that somebody does.
//!
//! * [`number`]: a number with its unit, as a person writes it. Anything else is refused with a reason.
//! * [`question`]: one question, asked again until the answer can be used, a bounded number of times.
//! * [`answers`], [`file`](mod@file): answers given before the run, on the command line or in a file.
//! * [`by_hand`]: what is asked for real devices, which nobody else can carry, set or measure.
//! * [`Person`]: whoever can be asked while the run goes on.
//!
//! Every reply goes into the record with who gave it, what it was, and when. Nothing here reads a
//! terminal or a clock; the command line does.

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

/// Does the plan ask a person for anything on a bench with these real devices?
pub fn asks_a_person(plan: &Plan, real: RealRoles) -> bool {
    let mut found = Vec::new();
    asking::questions(plan, &plan.steps, 1, real, &mut found);
    !found.is_empty()
}

/// What a person has typed by now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A whole line, without its end.
    Text(String),
    /// Nothing yet.
    NotYet,
    /// Nothing will come any more: the terminal is closed.
    Gone,
}

/// Somebody who can be asked while the run goes on. No method waits.
pub trait Person: fmt::Debug + Send {
    /// Who it is, for the record.
    fn name(&self) -> String;
    /// Begins a question. What was typed before it is no answer to it.
    fn ask(&mut self, text: &str);
    /// Says something more about the question that is open.
    fn say(&mut self, text: &str);
    /// What was typed since.
    fn heard(&mut self) -> Line;
    /// The question is closed; nothing is expected any more.
    fn done(&mut self);
    /// Seconds since 1970-01-01 00:00 UTC, for the record.
    fn unix_s(&self) -> Option<i64>;
}

/// What came of a question.
#[derive(Debug, Clone, PartialEq)]
pub enum Asked {
    /// It is answered.
    Replied(Reply),
    /// In simulation: what is to be done counts as done, and nobody did it.
    Assumed,
    /// A person has been asked; see [`Operator::heard`].
    Waiting,
    /// There is no answer and nobody to give one: the run cannot go on. Why, in a sentence.
    Nobody(String),
}

/// Answers for a run: those given before it, and the person beside the bench, if there is one.
#[derive(Debug)]
pub struct Operator {
    answers: Answers,
    bench: Bench,
    /// How many of the answers to each question have been used.
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
    /// For a bench that is simulated: nobody stands beside it, and what is to be done by hand is done.
    pub const fn simulated(answers: Answers) -> Self {
        Self { answers, bench: Bench::Simulated, used: BTreeMap::new() }
    }

    /// For a bench in real time. Answers given before go before asking the person.
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

    /// Asks for what a step wants.
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

    /// What the person has said by now to the question that is open; `None` while there is nothing to do.
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
