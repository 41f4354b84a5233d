//! Answers given before the run, checked against the questions of the plans.

use super::asking::{Asking, asking_for, known, questions, tell, wanted};
use super::attendance::{AnswersError, Attendance};
use super::by_hand::RealRoles;
use super::file::{AnswerFile, Written};
use super::number;
use plan::{Answer, Name, Plan};
use record::{Reply, Through};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::str::FromStr;

/// Source of answers given as arguments.
const ON_THE_COMMAND_LINE: &str = "the command line";

/// One answer as an argument: `NAME=VALUE`. The value is in the plan's unit unless it has its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GivenAnswer {
    name: Name,
    text: String,
}

impl FromStr for GivenAnswer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
        let known = Name::new(name).ok_or_else(|| format!("\"{name}\" is no name"))?;
        if value.trim().is_empty() {
            return Err("expected a value after the =".to_owned());
        }
        Ok(Self { name: known, text: value.to_owned() })
    }
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answers {
    by_name: BTreeMap<String, Given>,
    done_by: Option<String>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Given {
    values: Values,
    by: String,
    through: Through,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Values {
    Always(f64),
    InTurn(Vec<f64>),
}

impl From<BTreeMap<String, f64>> for Answers {
    fn from(values: BTreeMap<String, f64>) -> Self {
        let given = |value| Given {
            values: Values::Always(value),
            by: ON_THE_COMMAND_LINE.to_owned(),
            through: Through::Argument,
        };
        let by_name = values.into_iter().map(|(name, value)| (name, given(value))).collect();
        Self { by_name, done_by: None }
    }
}

impl Answers {
    /// The answer to a question that was answered `used` times before.
    pub(super) fn reply(&self, text: &str, answer: &Answer, used: usize) -> Option<Reply> {
        let Given { values, by, through } = self.by_name.get(answer.name.as_str())?;
        let value = match values {
            Values::Always(value) => *value,
            Values::InTurn(values) => *values.get(used)?,
        };
        Some(Reply::number(text, answer, value, by.clone(), *through))
    }

    /// Name of the person who attests that the manual work is done.
    pub(super) fn done_by_hand(&self) -> Option<&str> {
        self.done_by.as_deref()
    }

    /// Collects the answers of arguments and a file, arguments first, and checks them against the questions of `plans`
    /// on a bench with these `real` devices.
    ///
    /// # Errors
    /// When an answer is unusable, given twice, not asked for by any plan, or missing with no person to ask.
    pub fn collect<'a>(
        arguments: &[GivenAnswer],
        file: Option<&AnswerFile>,
        plans: impl IntoIterator<Item = &'a Plan>,
        real: RealRoles,
        attendance: Attendance,
    ) -> Result<Self, AnswersError> {
        let mut asked = Vec::new();
        for plan in plans {
            questions(plan, &plan.steps, 1, real, &mut asked);
        }
        let mut answers = Self { done_by: file.and_then(done_by), ..Self::default() };
        if let Some(file) = file {
            for name in file.answers.keys() {
                answers.by_name.insert(name.clone(), from_file(file, name, &asked)?);
            }
        }
        for (index, argument) in arguments.iter().enumerate() {
            if arguments[..index].iter().any(|earlier| earlier.name == argument.name) {
                let message = format!("the answer {} is given twice", argument.name);
                return Err(AnswersError::Argument { message, help: "give each once".to_owned() });
            }
            let given = from_argument(argument, &asked)?;
            answers.by_name.insert(argument.name.to_string(), given);
        }
        answers.complete(&asked, attendance)?;
        Ok(answers)
    }

    fn complete(&self, asked: &[Asking<'_>], attendance: Attendance) -> Result<(), AnswersError> {
        let missing = |asking: &&Asking<'_>| match (&asking.answer, attendance) {
            (_, Attendance::Person) | (None, Attendance::Simulated) => false,
            (None, Attendance::Nobody) => self.done_by.is_none(),
            (Some(answer), _) => !self.by_name.contains_key(answer.name.as_str()),
        };
        let missing: Vec<_> = asked.iter().filter(missing).collect();
        if missing.is_empty() { Ok(()) } else { Err(tell(&missing, attendance)) }
    }
}

fn done_by(file: &AnswerFile) -> Option<String> {
    file.done.then(|| file.by.clone())
}

fn from_argument(given: &GivenAnswer, asked: &[Asking<'_>]) -> Result<Given, AnswersError> {
    let mut value = None;
    for (plan, answer) in asking_for(given.name.as_str(), asked) {
        let read = number::read_unit_implied(&given.text, answer);
        value = Some(read.map_err(|refusal| AnswersError::Argument {
            message: format!("failed to use the answer {}={}: {refusal}", given.name, given.text),
            help: format!("plan {} asks for {}", plan.name, wanted(answer)),
        })?);
    }
    let value = value.ok_or_else(|| AnswersError::Argument {
        message: format!("no plan asks for {}", given.name),
        help: known(asked),
    })?;
    let (by, through) = (ON_THE_COMMAND_LINE.to_owned(), Through::Argument);
    Ok(Given { values: Values::Always(value), by, through })
}

fn from_file(file: &AnswerFile, name: &str, asked: &[Asking<'_>]) -> Result<Given, AnswersError> {
    let written = &file.answers[name];
    let mut values = None;
    for (plan, answer) in asking_for(name, asked) {
        let read = |text: &str, at| {
            number::read(text, answer).map_err(|refusal| {
                let help = format!("plan {} asks for {}", plan.name, wanted(answer));
                file.mistake(at, refusal.to_string(), Some(help))
            })
        };
        values = Some(match written.get_ref() {
            Written::Always(text) => Values::Always(read(text, written.span())?),
            Written::InTurn(texts) => {
                let asks = asked.iter().filter(|asking| asking.is(plan, name));
                let times: u64 = asks.map(|asking| asking.times).sum();
                if texts.len() as u64 != times {
                    let message = format!("{} answers, expected {times}", texts.len());
                    let help = format!("plan {} asks for {name} {times} times", plan.name);
                    return Err(file.mistake(written.span(), message, Some(help)).into());
                }
                let values = texts.iter().map(|text| read(text.get_ref(), text.span()));
                Values::InTurn(values.collect::<Result<_, _>>()?)
            }
        });
    }
    let values = values.ok_or_else(|| {
        file.mistake(written.span(), format!("no plan asks for {name}"), Some(known(asked)))
    })?;
    Ok(Given { values, by: file.by.clone(), through: Through::File })
}
