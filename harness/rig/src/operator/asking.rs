//! The questions of plans, and messages about missing answers.

use super::attendance::{AnswersError, Attendance};
use super::by_hand::{self, RealRoles};
use super::number::in_unit;
use plan::{Answer, Plan, Step};
use record::figures::{counted, with_unit};
use record::text::OneLine;
use std::collections::{BTreeMap, BTreeSet};

/// A question of a plan.
pub(super) struct Asking<'a> {
    pub(super) plan: &'a Plan,
    pub(super) text: String,
    pub(super) answer: Option<Answer>,
    pub(super) times: u64,
}

impl Asking<'_> {
    /// Whether `plan` asks for `name` here.
    pub(super) fn is(&self, plan: &Plan, name: &str) -> bool {
        self.plan.name == plan.name && self.answer.as_ref().is_some_and(|a| a.name.as_str() == name)
    }
}

/// All questions in `steps`, which run `times` times on a bench with these real devices.
pub(super) fn questions<'a>(
    plan: &'a Plan,
    steps: &'a [Step],
    times: u64,
    real: RealRoles,
    found: &mut Vec<Asking<'a>>,
) {
    for step in steps {
        for ((text, answer), each_time) in by_hand::questions(&step.action, real) {
            found.push(Asking { plan, text, answer, times: times.saturating_mul(each_time) });
        }
        let times = times.saturating_mul(step.action.repetitions());
        questions(plan, step.action.steps(), times, real, found);
    }
}

/// The questions that ask for `name`.
pub(super) fn asking_for<'a>(
    name: &'a str,
    asked: &'a [Asking<'a>],
) -> impl Iterator<Item = (&'a Plan, &'a Answer)> {
    let answers = asked.iter().filter_map(|asking| Some((asking.plan, asking.answer.as_ref()?)));
    answers.filter(move |(_, answer)| answer.name.as_str() == name)
}

/// Name, unit and range.
pub(super) fn wanted(Answer { name, unit, range, .. }: &Answer) -> String {
    format!("{name}{}, {range}", in_unit(unit))
}

/// Names of all answers that the plans ask for.
pub(super) fn known(asked: &[Asking<'_>]) -> String {
    let names: BTreeSet<_> =
        asked.iter().filter_map(|asking| Some(asking.answer.as_ref()?.name.as_str())).collect();
    match names.len() {
        0 => "asked for: nothing".to_owned(),
        _ => format!("asked for: {}", Vec::from_iter(names).join(", ")),
    }
}

/// An error that lists the missing answers and a file that would provide them.
pub(super) fn tell(missing: &[&Asking<'_>], attendance: Attendance) -> AnswersError {
    let numbers = missing.iter().filter(|asking| asking.answer.is_some()).count();
    let by_hand = missing.len() - numbers;
    let what = match (numbers as u64, by_hand as u64) {
        (0, by_hand) => counted(by_hand, "thing has to be done", "things have to be done"),
        (numbers, 0) => counted(numbers, "answer is missing", "answers are missing"),
        (numbers, by_hand) => format!(
            "{} and {}",
            counted(numbers, "answer is missing", "answers are missing"),
            counted(by_hand, "thing has to be done", "things have to be done"),
        ),
    };
    let mut help = String::new();
    let mut lines = BTreeMap::new();
    let mut told = BTreeSet::new();
    for Asking { plan, text, answer, .. } in missing {
        let text = OneLine(text);
        let line = match answer {
            None => format!("plan {} asks to be done: {text}\n", plan.name),
            Some(answer) => {
                let Answer { name, unit, .. } = answer;
                let example = with_unit("...".to_owned(), unit);
                lines.insert(name.as_str(), format!("{name} = \"{example}\"\n"));
                format!("plan {} asks for {}: {text}\n", plan.name, wanted(answer))
            }
        };
        // A question that is asked repeatedly is listed once.
        if !told.contains(&line) {
            help += &line;
            told.insert(line);
        }
    }
    let (why, otherwise) = match attendance {
        Attendance::Simulated => ("nobody is asked in virtual time", ""),
        _ => (
            "nobody is there to be asked: the standard input is no terminal",
            "run it in a terminal, or ",
        ),
    };
    help += &format!("{otherwise}add --answers FILE with:\nby = \"your name\"\n");
    if by_hand > 0 {
        help += "done = true\n";
    }
    if !lines.is_empty() {
        help += "[answers]\n";
        help.extend(lines.into_values());
    }
    AnswersError::Missing { what, why, help: help.trim_end().to_owned() }
}
