//! What a build server and an editor get: files of `ci/` that do what they say, summaries, and schemas.

use super::hil::{Hil, Ran, TURN};
use std::fs;
use std::path::Path;

/// Places where the commands of these files need more than this test has.
const NEEDS_MORE: [&str; 2] = ["--bus vcan", "hil doctor"];

/// The lines of a workflow that call `hil`.
fn commands(file: &str) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../ci").join(file);
    let text = fs::read_to_string(path).unwrap();
    assert!(!text.contains('\t'), "{file}: YAML has no tabs");
    let lines = text.lines().map(|line| line.trim_start().trim_start_matches("- "));
    let commands = lines.map(|line| line.trim_start_matches("run: "));
    let commands = commands.filter(|line| line.starts_with("hil "));
    commands.map(str::to_owned).collect()
}

#[test]
fn the_workflows_that_ship_do_what_they_say() {
    for file in ["github.yml", "gitlab.yml"] {
        let (hil, commands) = (Hil::new(), commands(file));
        assert!(commands.len() >= 4, "{file}: {commands:?}");
        for command in commands {
            let words: Vec<&str> =
                command.trim_end_matches("|| true").split_whitespace().skip(1).collect();
            if NEEDS_MORE.iter().any(|needed| command.contains(needed)) {
                // Its arguments are right, at least.
                hil.run(&[&words[..1], &["--help"]].concat()).exits(0);
                continue;
            }
            hil.run(&words).exits(0);
        }
        let junit = fs::read_dir(hil.path("runs")).unwrap();
        let junit = junit.filter(|run| run.as_ref().unwrap().path().join("junit.xml").is_file());
        assert!(junit.count() >= 3, "{file}: build servers read runs/*/junit.xml");
    }
}

/// `hil` where GitHub runs it.
fn on_github(hil: &Hil, arguments: &[&str]) -> Ran {
    let mut command = hil.command(arguments);
    command.env("GITHUB_ACTIONS", "true").env("GITHUB_STEP_SUMMARY", hil.path("summary.md"));
    Ran::of(command.output().unwrap())
}

#[test]
fn a_job_has_a_summary_and_mistakes_their_place() {
    let hil = Hil::with_plan(TURN);
    on_github(&hil, &["run", "turn.toml"]).exits(0);
    let passed = fs::read_to_string(hil.path("summary.md")).unwrap();
    assert!(passed.contains("### turn: passed") && passed.contains(r"| pass | stop\_error |"));

    fs::write(hil.path("turn.toml"), TURN.replace("[-5, 5]", "[4, 5]")).unwrap();
    let failed = on_github(&hil, &["run", "turn.toml"]).exits(1);
    assert!(
        failed.err.contains("::error file=turn.toml,line=1,title=turn%3A failed::"),
        "{failed:#?}"
    );
    let both = fs::read_to_string(hil.path("summary.md")).unwrap();
    assert!(both.starts_with(&passed) && both.contains(r"| **fail** | stop\_error |"), "{both}");

    fs::write(hil.path("turn.toml"), TURN.replace("bias_test", "bais_test")).unwrap();
    let wrong = on_github(&hil, &["run", "turn.toml"]).exits(2);
    assert!(
        wrong.err.contains("::error file=./turn.toml,line=6,")
            || wrong.err.contains("::error file=turn.toml,line=6,"),
        "{wrong:#?}"
    );
    let elsewhere = hil.run(&["run", "turn.toml"]).exits(2);
    assert!(!elsewhere.err.contains("::error"), "{elsewhere:#?}");
}

#[test]
fn a_summary_goes_where_it_is_asked_for() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--summary", "here.md"]).exits(0);
    assert!(fs::read_to_string(hil.path("here.md")).unwrap().contains("### turn: passed"));
    let junit = fs::read_to_string(hil.path("runs/turn-seed1/junit.xml")).unwrap();
    assert!(junit.contains("[[ATTACHMENT|runs/turn-seed1/report.html]]"), "{junit}");
}

#[test]
fn schemas_and_pages_are_written_for_every_kind() {
    let hil = Hil::new();
    hil.run(&["schema", "--out", "schemas"]).exits(0);
    let printed = hil.run(&["schema", "plan"]).exits(0).out;
    assert_eq!(printed, fs::read_to_string(hil.path("schemas/plan.schema.json")).unwrap());
    assert!(hil.path("schemas/device.schema.json").is_file());
    hil.run(&["man", "--out", "man"]).exits(0);
    assert!(hil.path("man/hil-run.1").is_file());
    assert!(hil.run(&["completions", "bash"]).exits(0).out.contains("campaign"));
    hil.run(&["schema"]).exits(2);
}
