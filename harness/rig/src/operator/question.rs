//! One question to a person: the text shown, and the handling of each line typed.

use super::number;
use plan::Answer;
use record::text::OneLine;
use record::{Reply, Through};

/// Most unusable answers to one question before the run is given up.
pub const TRIES_MAX: u32 = 5;

#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// An answer, with the value if one was asked for.
    Answered(Option<f64>),
    /// Not usable; shows this message and keeps the question open.
    Again(String),
    /// Not usable, and the last try.
    GivenUp(String),
}

#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    text: String,
    answer: Option<Answer>,
    tries: u32,
}

impl Question {
    /// Asks for a number, or without `answer` for manual work.
    pub fn new(text: &str, answer: Option<Answer>) -> Self {
        Self { text: text.to_owned(), answer, tries: 0 }
    }

    /// Text of the plan.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text shown to the person: the question and the expected answer.
    pub fn shown(&self) -> String {
        // Escaped, so that a text of a plan cannot move the cursor.
        let text = OneLine(&self.text);
        match &self.answer {
            None => format!("{text}\n  press Enter when it is done"),
            Some(Answer { name, unit, range, .. }) => {
                format!("{text}\n  {name}: a number{}, {range}", number::in_unit(unit))
            }
        }
    }

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

    pub(super) fn reply(&self, value: Option<f64>, by: String, through: Through) -> Reply {
        match (&self.answer, value) {
            (Some(answer), Some(value)) => Reply::number(&self.text, answer, value, by, through),
            _ => Reply::done(self.text.clone(), by, through),
        }
    }
}
