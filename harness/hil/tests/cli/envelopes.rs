//! `hil campaign --envelope` and `--envelopes`: the tolerated severity of a fault, and whether it suffices.

use super::hil::{Hil, TURN as UNCALIBRATED};
use serde_json::Value;
use std::fs;

/// A plan with a calibrated gyro, so that failures are caused by faults.
fn turn() -> String {
    UNCALIBRATED.replace("steps = [", "steps = [\n    { use_calibration = \"temperature\" },")
}

fn declaring(at_least: f64) -> Hil {
    let envelope = format!(
        "\n[[envelope]]\nfault = \"drop\"\ntarget = \"gyro\"\nat_least = {at_least}\nruns = 35\n"
    );
    Hil::with_plan(&format!("{}{envelope}", turn()))
}

#[test]
fn a_plan_asserts_how_much_it_stands() {
    let hil = declaring(0.02);
    let ran =
        hil.run(&["campaign", "./turn.toml", "--envelopes", "--out", "narrow", "--quiet"]).exits(0);
    assert!(ran.out.contains("at least 0.02 % is required: holds"), "{}", ran.out);
    let figures = fs::read(hil.path("narrow/envelopes.json")).unwrap();
    let figures: Value = serde_json::from_slice(&figures).unwrap();
    let tolerated = figures[0]["tolerated"].as_f64().unwrap();
    let page = fs::read_to_string(hil.path("narrow/report.html")).unwrap();
    assert!(page.contains("<svg class=\"plot\"") && page.contains("drop of gyro"));
    let other = ["campaign", "./turn.toml", "--envelope", "duplicate", "--runs", "35"];
    hil.run(&[&other[..], &["--out", "narrow", "--quiet"]].concat()).exits(0);
    let page = fs::read_to_string(hil.path("narrow/report.html")).unwrap();
    assert!(page.contains("duplicate"), "what is measured later stands beside the others");
    let verdicts = fs::read_to_string(hil.path("narrow/junit.xml")).unwrap();
    assert!(verdicts.contains("drop") && verdicts.contains("duplicate"), "{verdicts}");
    fs::remove_file(hil.path("narrow/report.html")).unwrap();
    hil.run(&["report", "narrow"]).exits(0);
    assert_eq!(fs::read_to_string(hil.path("narrow/report.html")).unwrap(), page);
    fs::write(hil.path("narrow/envelopes.json"), "[{\"plan\": \"turn\"}]").unwrap();
    let ran = hil.run(&["report", "narrow"]).exits(2);
    assert!(ran.err.contains("envelopes.json") && ran.err.contains("missing field"), "{}", ran.err);

    // The requirement exceeds the tolerated severity.
    let wide = declaring((2.0 * tolerated).min(100.0));
    let ran = wide.run(&["campaign", "./turn.toml", "--envelopes", "--quiet"]).exits(1);
    assert!(ran.out.contains("does not hold"), "{}", ran.out);
    assert!(wide.path("runs/envelopes-turn-seed1/report.html").exists());
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let hil = Hil::with_plan(&turn());
    let ran = hil.run(&["campaign", "./turn.toml", "--envelopes"]).exits(2);
    assert!(ran.err.contains("turn declares no envelope"), "{}", ran.err);
    // What the plan declares is not changed by options of `--envelope`.
    for option in [["--runs", "35"], ["--share", "0.5"], ["--at-least", "1"]] {
        let asked = [&["campaign", "./turn.toml", "--envelopes"][..], &option].concat();
        let ran = hil.run(&asked).exits(2);
        assert!(ran.err.contains("cannot be used with"), "{option:?}: {}", ran.err);
    }
    let asked = ["campaign", "./turn.toml", "--envelope", "drop", "--target", "gyro.Status"];
    let ran = hil.run(&asked).exits(2);
    assert!(ran.err.contains("no node here sends one message or signal"), "{}", ran.err);
    for (option, value, why) in [
        ("--at-least", "nan", "NaN, expected above 0 and at most 100"),
        ("--at-least", "150", "150, expected above 0 and at most 100"),
        ("--share", "nan", "NaN, expected above 0 and below 1"),
        ("--runs", "3", "so few can never show a share of 0.9"),
    ] {
        let asked = ["campaign", "./turn.toml", "--envelope", "drop", option, value];
        let ran = hil.run(&asked).exits(2);
        assert!(ran.err.contains(&format!("{option}: {why}")), "{}", ran.err);
    }
    let stranger = format!("{}\n[[envelope]]\nfault = \"lost_steps\"\nat_least = 80\n", turn());
    let ran = Hil::with_plan(&stranger).run(&["campaign", "./turn.toml", "--envelopes"]).exits(2);
    assert!(ran.err.contains("can strike nothing on this bench"), "{}", ran.err);
}

#[test]
fn what_fails_without_any_fault_has_no_envelope() {
    let hil = Hil::with_plan(UNCALIBRATED);
    let ran = hil
        .run(&["campaign", "./turn.toml", "--envelope", "drop", "--runs", "35", "--quiet"])
        .exits(2);
    assert!(ran.err.contains("too few runs of turn pass without the fault"), "{}", ran.err);
}

/// Interrupted in the middle of a line of the journal.
#[test]
fn what_was_interrupted_goes_on_where_it_stopped() {
    let hil = declaring(0.02);
    let command = ["campaign", "./turn.toml", "--envelopes", "--out", "kept", "--quiet", "--json"];
    let whole = hil.run(&command).exits(0).out;
    let journal = hil.path("kept/runs.jsonl");
    let runs = fs::read_to_string(&journal).unwrap();
    let cut: String = runs.chars().take(runs.len() / 2).collect();
    fs::write(&journal, &cut).unwrap();
    fs::remove_file(hil.path("kept/envelopes.json")).unwrap();
    fs::remove_file(hil.path("kept/report.html")).unwrap();
    fs::remove_file(hil.path("kept/junit.xml")).unwrap();
    assert_eq!(hil.run(&command).exits(0).out, whole);
    let again = fs::read_to_string(&journal).unwrap();
    let lines_of = |text: &str| text.lines().count();
    assert_eq!(lines_of(&again), lines_of(&runs), "what was there was not run again");
    // An existing line counts, whatever a new run would give.
    fs::write(&journal, again.replace("\"passed\":true", "\"passed\":false")).unwrap();
    let ran = hil.run(&command).exits(2);
    assert!(
        ran.err.contains("too few runs of turn pass without the fault: 0 of 20"),
        "{}",
        ran.err
    );
    // Runs of another plan do not count for this one.
    let text = fs::read_to_string(hil.path("turn.toml")).unwrap();
    fs::write(hil.path("turn.toml"), format!("{text}\n# another\n")).unwrap();
    let ran = hil.run(&command).exits(2);
    assert!(ran.err.contains("runs.jsonl is of another campaign: plan"), "{}", ran.err);
}

#[test]
fn a_campaign_of_other_targets_is_another_one() {
    let hil = Hil::with_plan(&turn());
    let search = |target: &str| {
        let faults = ["--cases", "1", "--faults", "drop", "--target", target, "--out", "c"];
        hil.run(&[&["campaign", "./turn.toml"][..], &faults].concat())
    };
    search("gyro").exits(0);
    let ran = search("gyro,base").exits(2);
    assert!(ran.err.contains("of drop of gyro there"), "{}", ran.err);
    assert!(ran.err.contains("of drop of gyro/"), "{}", ran.err);
    let ran = search("bsae").exits(2);
    assert!(ran.err.contains("no node and no line `bsae`"), "{}", ran.err);
}
