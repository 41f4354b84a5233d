//! `--json`: one document on the standard output and nothing else; no colours unless wanted.

use crate::hil::{Hil, Ran, TURN};
use serde_json::Value;

/// Parses the whole standard output as one document.
#[track_caller]
fn document(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{error}: {ran:#?}"))
}

#[test]
fn runs_are_told_as_their_summaries() {
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--out", "out", "--json"]).exits(0);
    let told = document(&ran);
    let file = std::fs::read(hil.path("out/summary.json")).unwrap();
    let file: Value = serde_json::from_slice(&file).unwrap();
    assert_eq!(told["runs"], Value::from(vec![file]), "as in summary.json");
    let checked = hil.run(&["check", "out", "--plan", "turn.toml", "--json"]).exits(0);
    assert_eq!(document(&checked)["runs"][0]["measurements"], told["runs"][0]["measurements"]);
    let seeds = hil.run(&["run", "turn.toml", "--seeds", "3", "--json"]).exits(0);
    let seeds = document(&seeds);
    assert_eq!(seeds["seeds"]["count"], 3);
    assert_eq!((&seeds["shares"][0]["seeds"], &seeds["stopped"]), (&3.into(), &false.into()));
    assert_eq!(seeds["not_passed"]["turn"], Value::from(Vec::<Value>::new()));
}

#[test]
fn what_went_wrong_is_told_with_the_same_status_and_what_was_done_before_it() {
    let hil = Hil::with_plan(TURN);
    // Conflicting arguments, a missing plan, and arguments that clap does not accept.
    for arguments in [
        &["run", "tern.toml", "--json"][..],
        &["run", "turn.toml", "--clock", "real", "--bus", "memory", "--json"],
        &["run", "turn.toml", "--nonsense", "--json"],
        &["run", "turn.toml", "--watch", "--json"],
    ] {
        let plain: Vec<&str> = arguments.iter().copied().filter(|one| *one != "--json").collect();
        let told = hil.run(arguments).exits(2);
        let error = document(&told);
        assert!(error["error"].as_str().is_some_and(|text| !text.is_empty()), "{error}");
        assert!(error.get("help").is_some() && error["causes"].is_array(), "{error}");
        assert!(!told.err.trim().is_empty(), "people are told, too");
        if !plain.contains(&"--watch") {
            hil.run(&plain).exits(2);
        }
    }
    hil.run(&["run", "turn.toml", "--out", "one", "--quiet"]).exits(0);
    let told = hil.run(&["check", "one", "nowhere", "--plan", "turn.toml", "--json"]).exits(2);
    let told = document(&told);
    assert_eq!(told["runs"][0]["plan"], "turn");
    assert!(told["error"].as_str().is_some(), "{told}");
}

#[test]
fn lists_campaigns_and_machines_are_told() {
    let hil = Hil::with_plan(TURN);
    let all = document(&hil.run(&["list", "--json"]).exits(0));
    let topics: Vec<&String> = all.as_object().unwrap().keys().collect();
    assert_eq!(topics.len(), 10, "{topics:?}");
    assert!(all["plans"].as_array().unwrap().iter().any(|plan| plan["plan"] == "warm-up"));
    let campaign = [
        "campaign",
        "straight-accuracy",
        "--cases",
        "3",
        "--shrink-max",
        "1",
        "--out",
        "found",
        "--json",
    ];
    let ran = hil.run(&campaign);
    assert_eq!(document(&ran)["cases"], 3);
    let ran = hil.run(&["doctor", "--json"]);
    assert!(document(&ran)["findings"].is_array(), "{ran:?}");
}

#[test]
fn no_escape_byte_where_no_colour_is_wanted() {
    let hil = Hil::with_plan(TURN);
    let wanted = [
        (&[("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")][..], false),
        (&[], false),
        (&[("CLICOLOR_FORCE", "1")], true),
    ];
    for (env, is_coloured) in wanted {
        for arguments in [
            &["run", "turn.toml", "--out", "out"][..],
            &["run", "tern.toml"],
            &["list", "plans"],
            &["--help"],
            &["run", "--nonsense"],
        ] {
            let mut command = hil.command(arguments);
            command.env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE").envs(env.iter().copied());
            let ran = Ran::of(command.output().unwrap());
            let has_escape = ran.out.contains('\u{1b}') || ran.err.contains('\u{1b}');
            if !is_coloured {
                assert!(!has_escape, "{arguments:?} {env:?}: {ran:#?}");
            } else if arguments.contains(&"turn.toml") {
                assert!(has_escape, "{arguments:?} {env:?}: {ran:#?}");
            }
        }
    }
}

#[test]
fn quiet_shows_the_result_alone() {
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--out", "out", "--quiet"]).exits(0);
    assert_eq!(ran.err, "");
    assert!(ran.out.contains("stop_error"), "{}", ran.out);
    let ran = hil.run(&["check", "out", "--plan", "turn.toml", "--quiet"]).exits(0);
    assert_eq!(ran.err, "");
    let told = hil.run(&["run", "turn.toml", "--watch", "--quiet"]).exits(2);
    assert!(told.err.contains("--watch shows"), "{}", told.err);
}
