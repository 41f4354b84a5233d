//! A person's answer: the number, its author, the way it was given, and when.

use crate::figures;
use crate::text::OneLine;
use plan::Answer;
use serde::{Deserialize, Serialize};
use std::fmt;

wire::tabled! {
    /// The way a reply was given.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Through {
        /// Typed during the run.
        Terminal = "at the terminal",
        /// Written to a file before the run.
        File = "in a file",
        /// Given as an argument.
        Argument = "as an argument",
    }
    fn words() -> &'static str
}

/// A number that the plan asked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Number {
    /// Name of the answer in the plan.
    pub name: String,
    /// The value, in `unit`.
    pub value: f64,
    /// The unit that the plan asks for.
    pub unit: String,
}

/// A person's answer, or the confirmation of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// The question in the plan's words.
    pub question: String,
    /// The number; `None` if the person was to do something and did it.
    pub number: Option<Number>,
    /// The person.
    pub by: String,
    /// The way it was given.
    pub through: Through,
    /// Seconds since 1970-01-01 00:00 UTC, if a person answered during the run. The bench time is that of the record.
    pub unix_s: Option<i64>,
}

impl Reply {
    /// A reply with a number.
    pub fn number(text: &str, answer: &Answer, value: f64, by: String, through: Through) -> Self {
        let (name, unit) = (answer.name.to_string(), answer.unit.clone());
        let number = Some(Number { name, value, unit });
        Self { question: text.to_owned(), number, by, through, unix_s: None }
    }

    /// A reply that confirms a task.
    pub const fn done(question: String, by: String, through: Through) -> Self {
        Self { question, number: None, by, through, unix_s: None }
    }
}

/// Always on one line.
impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { question, number, by, through, unix_s } = self;
        match number {
            None => write!(f, "done")?,
            Some(Number { name, value, unit }) => {
                let value = figures::quantity(*value, 0.0, unit);
                write!(f, "{} = {}", OneLine(name), OneLine(&value))?;
            }
        }
        write!(f, " by {} {}", OneLine(by), through.words())?;
        if let Some(unix_s) = unix_s {
            write!(f, ", unix time {unix_s} s")?;
        }
        write!(f, ": {}", OneLine(question))
    }
}
