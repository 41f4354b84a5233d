//! A controller in Python as the device under test, right and with a sign that has slipped.

use super::rig::{file, python, shown};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Runs that a good controller gets.
const TRIES: u32 = 3;

fn run(python: &Path, out: &Path, slip: &[&str]) -> (Output, Value) {
    let mut controller = vec![
        python.to_str().unwrap().to_owned(),
        file("tests/interop/python_controller/controller.py").to_str().unwrap().to_owned(),
        "--gyro".to_owned(),
        "{gyro}".to_owned(),
        "--base".to_owned(),
        "{base}".to_owned(),
    ];
    controller.extend(slip.iter().map(|word| (*word).to_owned()));
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .arg("run")
        .arg(file("tests/interop/plans/square.toml"))
        .args(["--clock", "real", "--controller", &controller.join(" "), "--out"])
        .arg(out)
        .output()
        .unwrap();
    let summary = std::fs::read(out.join("summary.json"))
        .unwrap_or_else(|error| panic!("{error}: {}", shown(&output)));
    (output, serde_json::from_slice(&summary).unwrap())
}

/// Names of the measurements with that verdict.
fn with_verdict<'a>(summary: &'a Value, verdict: &str) -> Vec<&'a str> {
    let measurements = summary["measurements"].as_array().unwrap();
    let of = measurements.iter().filter(|measurement| measurement["verdict"] == verdict);
    of.map(|measurement| measurement["name"].as_str().unwrap()).collect()
}

#[test]
fn somebody_elses_controller_drives_a_square() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    // In real time on a machine that others use too, a late command may rightly spoil a run.
    let attempt = |number: u32| run(&python, &folder.path().join(number.to_string()), &[]);
    let passed = |output: &Output| output.status.code() == Some(0);
    let (output, summary) = (1..TRIES)
        .map(attempt)
        .find(|(output, _)| passed(output))
        .unwrap_or_else(|| attempt(TRIES));
    assert!(passed(&output), "{}{summary:#}", shown(&output));
    assert!(with_verdict(&summary, "fail").is_empty(), "{summary:#}");
}

/// It believes in itself: only the absolute measurement sees that its square goes the other way round.
#[test]
fn a_sign_that_has_slipped_is_found() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let slip = ["--slip", "clockwise-positive"];
    let (output, summary) = run(&python, &folder.path().join("run"), &slip);
    assert_eq!(output.status.code(), Some(1), "{}{summary:#}", shown(&output));
    assert_eq!(summary["outcome"], "failed");
    assert!(with_verdict(&summary, "fail").contains(&"corner_heading"), "{summary:#}");
    assert!(with_verdict(&summary, "pass").contains(&"return_x"), "{summary:#}");
}
