//! Answers to what a plan asks a person for, given before the run: `--answer NAME=VALUE`.

use super::failure::Failure;
use crate::plan::{Action, Answer, Name, Plan, Step};
use std::collections::BTreeMap;
use std::str::FromStr;

/// One answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GivenAnswer {
    name: Name,
    value: f64,
}

impl FromStr for GivenAnswer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
        let known = Name::new(name).ok_or_else(|| format!("\"{name}\" is no name"))?;
        match value.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Self { name: known, value }),
            _ => Err(format!("\"{value}\" is not a finite number")),
        }
    }
}

/// Answers by name.
pub(super) type Answers = BTreeMap<String, f64>;

/// The answers, checked against what the plans ask for. With `all_needed`, nobody is there to be asked.
///
/// # Errors
///
/// When one is given twice, is asked for by no plan, is out of its range, or is needed and missing.
pub(super) fn collect<'a>(
    given: &[GivenAnswer],
    plans: impl IntoIterator<Item = &'a Plan>,
    all_needed: bool,
) -> Result<Answers, Failure> {
    let mut answers = Answers::new();
    for GivenAnswer { name, value } in given {
        if answers.insert(name.to_string(), *value).is_some() {
            let message = format!("the answer {name} is given twice");
            return Err(Failure::arguments(message, "give each answer once"));
        }
    }
    let mut asked = Vec::new();
    for plan in plans {
        questions(&plan.steps, &mut |answer| asked.push((plan, answer)));
    }
    for (plan, answer) in &asked {
        let Answer { name, unit, range, .. } = *answer;
        match answers.get(name.as_str()) {
            Some(value) if !range.contains(*value) => {
                let message = format!("the answer {name} = {value} {unit} is out of its range");
                return Err(Failure::arguments(message, format!("{} takes {range}", plan.name)));
            }
            None if all_needed => {
                let message = format!("plan {} asks for {name}, in {unit}", plan.name);
                let help = format!("nobody is there to be asked; add --answer {name}=VALUE");
                return Err(Failure::arguments(message, help));
            }
            _ => {}
        }
    }
    let unknown = answers.keys().find(|name| asked.iter().all(|(_, a)| a.name.as_str() != **name));
    match unknown {
        Some(name) => {
            let names: Vec<_> = asked.iter().map(|(_, answer)| answer.name.as_str()).collect();
            let names = if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
            let message = format!("no plan asks for {name}");
            Err(Failure::arguments(message, format!("asked for: {names}")))
        }
        None => Ok(answers),
    }
}

fn questions<'a>(steps: &'a [Step], found: &mut impl FnMut(&'a Answer)) {
    for step in steps {
        match &step.action {
            Action::OperatorPrompt(prompt) => {
                if let Some(answer) = &prompt.answer {
                    found(answer);
                }
            }
            action => questions(action.steps(), found),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Answers, GivenAnswer, collect};
    use crate::plan::Plan;

    const PLAN: &str = r#"
        name = "weigh"
        title = "Weigh"
        devices = "paper"
        steps = [{ repeat = { times = 2, steps = [
            { operator_prompt = { text = "Weigh it", answer = { name = "mass", unit = "kg", range = [10, 90] } } },
            { operator_prompt = { text = "Put it back" } },
        ] } }]

        [[measurement]]
        name = "mass"
        doc = "What the scales say"
        quantity = "operator.mass"
        unit = "kg"
        check = { all_within = [10, 90] }
    "#;

    fn collected(given: &[&str], all_needed: bool) -> Result<Answers, String> {
        let given: Vec<GivenAnswer> = given.iter().map(|text| text.parse().unwrap()).collect();
        let plan = Plan::parse("weigh.toml", PLAN).unwrap();
        collect(&given, [&plan], all_needed).map_err(|failure| failure.to_string())
    }

    #[test]
    fn an_answer_is_a_name_and_a_number() {
        let answer: GivenAnswer = "mass=-1.5e2".parse().unwrap();
        assert_eq!((answer.name.as_str(), answer.value), ("mass", -150.0));
        for text in
            ["", "mass", "=1", "mass=", "mass=heavy", "mass=nan", "mass=inf", "a b=1", "m=1=2"]
        {
            assert!(text.parse::<GivenAnswer>().is_err(), "{text}");
        }
    }

    #[test]
    fn answers_are_checked_before_the_run() {
        assert_eq!(collected(&["mass=60"], true).unwrap()["mass"], 60.0);
        assert!(collected(&[], false).unwrap().is_empty());
        for (given, message) in [
            (&["mass=60", "mass=61"][..], "the answer mass is given twice"),
            (&["mass=5"], "the answer mass = 5 kg is out of its range"),
            (&["mass=60", "length=1"], "no plan asks for length"),
            (&[], "plan weigh asks for mass, in kg"),
        ] {
            assert_eq!(collected(given, true).unwrap_err(), message);
        }
    }
}
