//! Every project that is made can be run as it is.

use super::{Template, from_dbc, write};
use harness::operator::Answers;
use harness::run::{Prepared, simulate};
use plan::Name;
use plan::made::Made;
use record::outcome::Outcome;
use record::sink::NullSink;
use std::path::Path;

fn plans(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut plans: Vec<String> = names
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.display().to_string())
        .collect();
    plans.sort();
    plans
}

/// The outcome of each plan of the project, as the checks have it.
fn outcomes(folder: &Path) -> Vec<(String, Outcome)> {
    let outcome = |plan: &String| {
        let prepared = Prepared::load(plan, &Made::default());
        let prepared = prepared.unwrap_or_else(|error| panic!("{plan}: {error:?}"));
        let run = simulate(&prepared, 1, &Answers::default(), &mut NullSink, &mut |_| true);
        let (measurements, judged) =
            judge::checks::judge_all(&prepared.plan.measurements, &run.observations);
        assert_eq!(run.ending.outcome, Outcome::Passed, "{plan}: {:?}", run.ending);
        assert!(judged == Outcome::Passed, "{plan}: {measurements:#?}");
        (prepared.plan.name.to_string(), judged)
    };
    plans(folder).iter().map(outcome).collect()
}

#[test]
fn each_template_runs_under_any_name_and_passes() {
    let folder = tempfile::tempdir().unwrap();
    for (template, plan) in [(Template::Can, "noisy-bus"), (Template::Serial, "noisy-line")] {
        let at = folder.path().join(plan);
        write(&at, &template.files(&Name::new("oven-2").unwrap())).unwrap();
        let names: Vec<String> = outcomes(&at).into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, [plan, "safe-alone", "settles"]);
    }
}

#[test]
fn a_project_of_a_dbc_passes_too() {
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("../../../../wire/dbc/k2a.dbc");
    let name = Name::new("base").unwrap();
    let node = text.lines().find_map(|line| line.strip_prefix("BU_:")).unwrap();
    for node in node.split_whitespace() {
        let at = folder.path().join(node);
        let made = from_dbc(&name, "k2a.dbc", text.as_bytes(), Some(node)).unwrap();
        write(&at, &made.files).unwrap();
        assert_eq!(outcomes(&at).len(), 1, "{node}");
    }
}

#[test]
fn nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.txt"), "mine").unwrap();
    let error = write(folder.path(), &Template::Can.files(&Name::new("oven").unwrap()));
    assert_eq!(error.unwrap_err().to_string(), "the folder is not empty");
}
