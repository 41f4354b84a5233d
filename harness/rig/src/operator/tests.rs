use super::file::AnswerFile;
use super::number::{read, read_unit_implied};
use super::question::{Heard, Question, TRIES_MAX};
use super::{Answers, Asked, Attendance, GivenAnswer, Line, Operator, Person, RealRoles};
use plan::library::Source;
use plan::{Answer, Plan};
use proptest::prelude::*;
use record::Through;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

const PLAN: &str = r#"
name = "weigh"
title = "Weigh"
devices = "paper"
steps = [
    { operator_prompt = { text = "Put the weight on" } },
    { repeat = { times = 3, steps = [
        { operator_prompt = { text = "How wide is the gap?", answer = { name = "gap", unit = "mm", range = [-2, 2] } } },
    ] } },
    { operator_prompt = { text = "How heavy is it?", answer = { name = "mass", unit = "kg", range = { at_least = 10 } } } },
]

[[measurement]]
name = "mass"
doc = "What the scales say"
quantity = "operator.mass"
unit = "kg"
check = { all_within = [10, 90] }
"#;

fn plan() -> Plan {
    Plan::parse("weigh.toml", PLAN).unwrap()
}

fn asked(unit: &str, range: &str) -> Answer {
    let text = format!("name = \"x\"\nunit = \"{unit}\"\nrange = {range}");
    toml::from_str(&text).unwrap()
}

#[test]
fn a_number_has_its_unit_and_lies_in_its_range() {
    let mut shown = String::new();
    for (unit, range, texts) in [
        (
            "deg",
            "[-5, 5]",
            &[
                "1.5 deg",
                "1.5deg",
                " -0.5e1  deg ",
                "17.45 mrad",
                "1.5",
                "",
                "deg",
                "1,5 deg",
                "6 deg",
                "1 rad",
                "1.5 m",
                "1.5 Deg",
                "inf deg",
                "1e999 deg",
                "--1 deg",
                "1.5 deg deg",
            ][..],
        ),
        ("m", "{ at_least = 0 }", &["1500 mm", "0 m", "-1 cm", "5e m", "5e"]),
        ("1", "[0, 10]", &["3", "3 1", "30", "50 %"]),
        ("degC", "[5, 40]", &["21.5 degC", "21.5 Cel", "70 degC"]),
        ("kg", "[10, 90]", &["60 kg", "60000 g"]),
    ] {
        let answer = asked(unit, range);
        for text in texts {
            let came = match read(text, &answer) {
                Ok(value) => value.to_string(),
                Err(refusal) => refusal.to_string(),
            };
            shown += &format!("{unit:5} {text:13?} {came}\n");
        }
    }
    insta::assert_snapshot!(shown);
}

proptest! {
    #[test]
    fn whatever_is_typed_is_a_number_in_range_or_refused(text in "\\PC{0,80}") {
        let answer = asked("deg", "[-5, 5]");
        if let Ok(value) = read(&text, &answer) {
            prop_assert!(value.abs() <= 5.0);
        }
    }

    #[test]
    fn a_number_is_read_as_it_is(value in -5.0..5.0_f64) {
        let answer = asked("deg", "[-5, 5]");
        prop_assert_eq!(read(&format!("{value} deg"), &answer), Ok(value));
        prop_assert_eq!(read_unit_implied(&value.to_string(), &answer), Ok(value));
    }
}

#[test]
fn a_question_is_asked_again_and_not_for_ever() {
    let mut question = Question::new("How wide is it?", Some(asked("mm", "[-2, 2]")));
    assert_eq!(question.shown(), "How wide is it?\n  x: a number in mm, -2 to 2");
    for left in (1..TRIES_MAX).rev() {
        let Heard::Again(why) = question.hear("3 mm") else { panic!("asked again") };
        assert!(why.contains("out of range, expected -2 to 2 mm"), "{why}");
        assert!(why.contains(&format!("{left} tr")), "{why}");
    }
    let Heard::GivenUp(why) = question.hear("wide") else { panic!("given up") };
    assert!(why.starts_with("no usable answer \"x\" in 5 tries; the last: \"wide\""), "{why}");
}

/// A person with prepared answers.
#[derive(Debug)]
struct Scripted {
    lines: VecDeque<Line>,
    said: Arc<Mutex<Vec<String>>>,
}

impl Person for Scripted {
    fn name(&self) -> String {
        "Jane Doe".to_owned()
    }
    fn ask(&mut self, text: &str) {
        self.say(text);
    }
    fn say(&mut self, text: &str) {
        self.said.lock().unwrap().push(text.to_owned());
    }
    fn heard(&mut self) -> Line {
        self.lines.pop_front().unwrap_or(Line::NotYet)
    }
    fn done(&mut self) {
        self.say("done");
    }
    fn unix_s(&self) -> Option<i64> {
        Some(1_770_000_000)
    }
}

#[test]
fn a_conversation() {
    let text = |text: &str| Line::Text(text.to_owned());
    let lines = [Line::NotYet, text("3 mm"), text("1.5 mm"), text(""), Line::Gone].into();
    let said = Arc::<Mutex<Vec<String>>>::default();
    let person = Scripted { lines, said: Arc::clone(&said) };
    let mut operator = Operator::live(Answers::default(), Some(Box::new(person)));
    assert_eq!(operator.heard(), None, "nothing was asked");

    let gap = asked("mm", "[-2, 2]");
    assert_eq!(operator.ask("How wide is it?", Some(&gap)), Asked::Waiting);
    assert_eq!(operator.heard(), None);
    let Some(Asked::Replied(reply)) = operator.heard() else { panic!("answered") };
    assert_eq!(reply.number.as_ref().map(|number| number.value), Some(1.5));
    assert_eq!((reply.by.as_str(), reply.through), ("Jane Doe", Through::Terminal));
    assert_eq!(reply.unix_s, Some(1_770_000_000));

    assert_eq!(operator.ask("Switch it on", None), Asked::Waiting);
    let Some(Asked::Replied(reply)) = operator.heard() else { panic!("done") };
    assert_eq!(reply.number, None);

    assert_eq!(operator.ask("Switch it off", None), Asked::Waiting);
    let Some(Asked::Nobody(why)) = operator.heard() else { panic!("gone") };
    assert!(why.ends_with("Switch it off"), "{why}");
    assert_eq!(operator.heard(), None);
    assert_eq!(said.lock().unwrap().iter().filter(|said| *said == "done").count(), 3);
}

fn collected(
    given: &[&str],
    file: Option<&str>,
    attendance: Attendance,
) -> Result<Answers, super::AnswersError> {
    let given: Vec<GivenAnswer> = given.iter().map(|text| text.parse().unwrap()).collect();
    let source = |text: &str| Source { origin: "answers.toml".to_owned(), text: text.to_owned() };
    let file = file.map(|text| AnswerFile::parse(source(text))).transpose()?;
    Answers::collect(&given, file.as_ref(), [&plan()], RealRoles::default(), attendance)
}

fn values(operator: &mut Operator, name: &str, times: usize) -> Vec<f64> {
    let unit = if name == "gap" { "mm" } else { "kg" };
    let mut answer = asked(unit, "{ at_least = -10 }");
    answer.name = plan::Name::new(name).unwrap();
    (0..times)
        .map(|_| match operator.ask("?", Some(&answer)) {
            Asked::Replied(reply) => reply.number.unwrap().value,
            other => panic!("{other:?}"),
        })
        .collect()
}

#[test]
fn answers_come_from_a_file_and_from_arguments() {
    let file = "by = \"Jane Doe\"\ndone = true\n[answers]\ngap = [\"1 mm\", \"-0.1 cm\", \"2 mm\"]\nmass = \"60 kg\"";
    let answers = collected(&["mass=61.5"], Some(file), Attendance::Nobody).unwrap();
    let mut operator = Operator::live(answers, None);
    let Asked::Replied(reply) = operator.ask("Put it on", None) else { panic!("attested") };
    assert_eq!((reply.by.as_str(), reply.through), ("Jane Doe", Through::File));
    assert_eq!(values(&mut operator, "gap", 3), [1.0, -1.0, 2.0]);
    assert_eq!(values(&mut operator, "mass", 2), [61.5, 61.5]);
    let Asked::Nobody(why) = operator.ask("?", Some(&asked("deg", "[0, 1]"))) else { panic!() };
    assert_eq!(why, "no answer \"x\" was given, and nobody is there to be asked");
}

#[test]
fn a_simulated_bench_needs_numbers_and_no_hands() {
    let answers = collected(&["mass=60kg", "gap=1 mm"], None, Attendance::Simulated).unwrap();
    let mut operator = Operator::simulated(answers);
    assert_eq!(operator.ask("Put it on", None), Asked::Assumed);
    assert!(collected(&["mass=60kg", "gap=1 mm"], None, Attendance::Nobody).is_err());
    assert!(collected(&[], None, Attendance::Person).is_ok(), "asked when it is time");
}

#[test]
fn an_argument_is_a_name_and_a_text() {
    for text in ["", "mass", "=1", "mass=", "mass= ", "a b=1"] {
        assert!(text.parse::<GivenAnswer>().is_err(), "{text}");
    }
}

#[test]
fn what_cannot_be_used_or_is_missing_is_said() {
    let mut shown = String::new();
    let mut show = |given: &[&str], file: Option<&str>, attendance| {
        let error = collected(given, file, attendance).unwrap_err();
        let handler = miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::none());
        handler.with_width(100).render_report(&mut shown, &error).unwrap();
        shown.push('\n');
    };
    show(&["mass=60", "mass=61"], None, Attendance::Person);
    show(&["mass=5"], None, Attendance::Person);
    show(&["mass=60 mm"], None, Attendance::Person);
    show(&["length=1"], None, Attendance::Person);
    show(&[], None, Attendance::Nobody);
    show(&["mass=60"], None, Attendance::Simulated);
    for text in [
        "by = \"\"",
        "[answers]\ngap = \"1 mm\"",
        "by = \"J\"\n[answers]\ngap = \"1\"",
        "by = \"J\"\n[answers]\ngap = 1.5",
        "by = \"J\"\n[answers]\ngap = [\"1 mm\", \"2 mm\"]",
        "by = \"J\"\n[answers]\ngap = [\"1 mm\", \"20 mm\", \"1 mm\"]",
        "by = \"J\"\n[answers]\ngap = []",
        "by = \"J\"\n[answers]\nlength = \"1 m\"",
        "by = \"J\"\nanswer = 1",
    ] {
        show(&[], Some(text), Attendance::Person);
    }
    insta::assert_snapshot!(shown);
}
