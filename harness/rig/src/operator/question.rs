//! One question to a person: what is shown, and what is made of each line that is typed.

use super::number;
use plan::Answer;
use record::{Reply, Through};

/// So often a person may answer what cannot be used, before the run is given up.
pub const TRIES_MAX: u32 = 5;

/// What a line came to.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// It is an answer: the value where one was asked for.
    Answered(Option<f64>),
    /// It cannot be used; this is to be said, and the question stays open.
    Again(String),
    /// It cannot be used, and was the last try.
    GivenUp(String),
}

/// A question that is open.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    text: String,
    answer: Option<Answer>,
    tries: u32,
}

impl Question {
    /// A number, or with no `answer` something that is to be done.
    pub fn new(text: &str, answer: Option<Answer>) -> Self {
        Self { text: text.to_owned(), answer, tries: 0 }
    }

    /// As the plan words it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What is shown: the text and what is expected.
    pub fn shown(&self) -> String {
        // A text of a plan may not move the cursor.
        let text = self.text.escape_debug();
        match &self.answer {
            None => format!("{text}\n  press Enter when it is done"),
            Some(Answer { name, unit, range, .. }) => {
                format!("{text}\n  {name}: a number{}, {range}", number::in_unit(unit))
            }
        }
    }

    /// Takes a line.
    pub fn hear(&mut self, line: &str) -> Heard {
        let Some(answer) = &self.answer else { return Heard::Answered(None) };
        let refusal = match number::read(line, answer) {
            Ok(value) => return Heard::Answered(Some(value)),
            Err(refusal) => refusal,
        };
        self.tries += 1;
        match TRIES_MAX.saturating_sub(self.tries) {
            0 => Heard::GivenUp(format!(
                "no usable answer \"{}\" in {TRIES_MAX} tries; the last: {refusal}",
                answer.name
            )),
            1 => Heard::Again(format!("{refusal} (1 try left)")),
            left => Heard::Again(format!("{refusal} ({left} tries left)")),
        }
    }

    /// The reply for the record.
    pub(super) fn reply(&self, value: Option<f64>, by: String, through: Through) -> Reply {
        match (&self.answer, value) {
            (Some(answer), Some(value)) => Reply::number(&self.text, answer, value, by, through),
            _ => Reply::done(self.text.clone(), by, through),
        }
    }
}
