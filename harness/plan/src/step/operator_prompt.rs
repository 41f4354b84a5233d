//! Asks a person to do something or to give an answer.

use super::{Known, Op, Order, StepKind};
use crate::Checked;
use crate::band::Band;
use crate::name::Name;
use crate::number;
use crate::survey::Survey;
use crate::time_limits::PERSON_LIMIT;
use described::Place;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, de};
use std::fmt;
use wire::time::Span;

/// Longest text shown to an operator, in bytes.
pub const PROMPT_LEN_MAX: usize = 500;

/// Something that a person does or tells.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OperatorPrompt {
    /// What is shown.
    #[serde(deserialize_with = "prompt")]
    #[schemars(length(min = 1, max = PROMPT_LEN_MAX))]
    pub text: String,
    /// What is asked for; a key press where it is absent.
    #[serde(default)]
    pub answer: Option<Answer>,
}

/// A number that a person gives; observed as `operator.<name>`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Its name.
    pub name: Name,
    /// Its unit.
    pub unit: String,
    /// What is taken; anything else is asked for again.
    pub range: Band,
    /// Its standard uncertainty.
    #[serde(default, with = "number::NotNegative")]
    pub uncertainty: f64,
}

impl StepKind for OperatorPrompt {
    fn title(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ask the operator: {}", self.text)
    }

    fn script(&self, _: &Known<'_>) -> Result<Vec<Op>, String> {
        let (text, answer) = (self.text.clone(), self.answer.clone());
        Ok(vec![Op::Order(Order::Prompt { text, answer })])
    }

    fn check<'a>(&'a self, survey: &mut Survey<'a>, _: &Place) -> Checked {
        let answer = self.answer.iter().map(|answer| (answer.name.as_str(), answer.unit.as_str()));
        survey.answers.extend(answer);
        Ok(())
    }

    fn limit(&self) -> Span {
        PERSON_LIMIT
    }
}

fn prompt<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let text = String::deserialize(deserializer)?;
    if text.trim().is_empty() || text.len() > PROMPT_LEN_MAX {
        return Err(de::Error::invalid_length(text.len(), &"a text of 1 to 500 bytes"));
    }
    Ok(text)
}
