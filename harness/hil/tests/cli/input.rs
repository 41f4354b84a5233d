//! Valid and invalid input.

use crate::hil::{Hil, TURN};

#[test]
fn what_ships_is_listed() {
    let files = Hil::new().run(&["list"]).exits(0);
    let all = Hil::new().run(&["list", "--json"]).exits(0);
    for name in ["laps-observed", "paper-table"] {
        assert!(files.out.contains(name) && all.out.contains(name), "{name}: {}", files.out);
    }
    for name in ["lap.gyro_error", "gyro.ambient_celsius"] {
        assert!(!files.out.contains(name) && all.out.contains(name), "{name}: {}", all.out);
    }
    assert!(
        files.out.ends_with("hil list steps|checks|quantities|parameters|faults\n"),
        "{}",
        files.out
    );
    let plans = Hil::new().run(&["list", "plans"]).exits(0);
    assert!(plans.out.contains("umbmark") && !plans.out.contains("lap.gyro_error"));
}

#[test]
fn an_unknown_plan_is_bad_input() {
    let hil = Hil::new();
    let ran = hil.run(&["run", "varification"]).exits(2);
    assert!(ran.err.contains("no plan is called \"varification\""), "{}", ran.err);
    assert!(ran.err.is_ascii(), "plain where it is no terminal: {}", ran.err);
    assert!(!hil.path("runs").exists());
}

#[test]
fn an_unknown_key_is_shown_in_its_place() {
    let hil = Hil::with_plan(&TURN.replace("angle_deg", "angel_deg"));
    // The plan before it does not run either.
    let ran = hil.run(&["run", "straight-accuracy", "./turn.toml"]).exits(2);
    assert!(ran.err.contains("angel_deg") && ran.err.contains("turn.toml:7"), "{}", ran.err);
    assert!(!hil.path("runs").exists());
}

#[test]
fn arguments_that_do_not_go_together_are_bad_input() {
    let hil = Hil::with_plan(TURN);
    for (arguments, why) in [
        (&["--bus", "pty"][..], "it is on CAN, and a pty carries bytes"),
        (&["--bus", "slcan", "--seeds", "3"], "--seeds needs the memory bus"),
        (&["--clock", "real", "--bus", "memory"], "the real clock needs the pty bus"),
        (
            &["--controller", "process", "--seeds", "3"],
            "--seeds needs the controller in the process",
        ),
        (&["--bench", "mine.toml"], "a bench file needs the real clock"),
        (&["--clock", "real", "--seeds", "3"], "--seeds needs the virtual clock"),
        (&["--controller", "sh -c 'exit 1'"], "put the command into a script"),
        (&["--answer", "mass=1"], "no plan asks for mass"),
        (&["--answer", "mass"], "expected NAME=VALUE"),
        (&["--seeds", "0"], "0 is not in 1..="),
        (&["--seeds", "2", "--out", "x"], "cannot be used with"),
        (&["./turn.toml"], "two of the plans are called turn"),
    ] {
        let ran = hil.run(&[&["run", "turn.toml"][..], arguments].concat()).exits(2);
        assert!(ran.err.contains(why), "{arguments:?}: {}", ran.err);
    }
    assert!(!hil.path("runs").exists());
}

#[test]
fn exit_statuses_are_documented() {
    for arguments in [&["--help"][..], &["run", "--help"], &["check", "--help"]] {
        let help = Hil::new().run(arguments).exits(0).out;
        for status in ["0  passed", "1  failed", "2  bad input", "3  the bench", "4  timeout"] {
            assert!(help.contains(status), "{help}");
        }
    }
}

#[cfg(not(feature = "nats"))]
#[test]
fn a_build_without_campaigns_over_a_server_says_how_to_make_one_with_them() {
    let hil = Hil::new();
    for arguments in
        [&["worker", "--nats", "nats://h"][..], &["campaign", "x", "--nats", "nats://h"]]
    {
        let ran = hil.run(arguments).exits(2);
        assert!(ran.err.contains("--features nats"), "{}", ran.err);
    }
}

#[test]
fn a_folder_that_is_not_ours_is_refused() {
    let hil = Hil::with_plan(TURN);
    let ran = hil.run(&["run", "turn.toml", "--out", "."]).exits(2);
    assert!(ran.err.contains("refused to replace ."), "{}", ran.err);
    let ran = hil.run(&["run", "turn.toml", "--out", "turn.toml"]).exits(2);
    assert!(ran.err.contains("it is a file and no folder"), "{}", ran.err);
    for command in ["check", "report", "show"] {
        let ran = hil.run(&[command, "."]).exits(2);
        assert!(ran.err.contains("no run in ."), "{command}: {}", ran.err);
    }
}

#[test]
fn the_doctor_says_what_lacks_and_exits_accordingly() {
    let hil = Hil::new();
    let ran = hil.run(&["doctor"]).exits(0);
    for subject in ["CAN", "serial ports", "ptys", "clock", "k2a-controller", "exit status 0"] {
        assert!(
            ran.out.contains(subject) || ran.out.contains("/dev/tty"),
            "{subject}: {}",
            ran.out
        );
    }
    // No machine has this port and this interface.
    let bench = "[gyro]\nport = \"/dev/there-is-no-such-port\"\n[base]\nport = \"can:can-none\"\n";
    std::fs::write(hil.path("bench.toml"), bench).unwrap();
    let ran = hil.run(&["doctor", "--bench", "bench.toml"]).exits(3);
    for lacking in ["/dev/there-is-no-such-port, for the gyro", "can-none, for the base"] {
        assert!(ran.out.contains(lacking), "{lacking}: {}", ran.out);
    }
    let json = hil.run(&["doctor", "laps-corrected", "--json"]).exits(0);
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(json["outcome"], "passed");
    assert!(hil.run(&["doctor", "varification"]).exits(3).out.contains("no plan is called"));
}

#[test]
fn the_doctor_sees_a_vcan() {
    let Some(_bus) = skips::Vcan0::take("--test cli -- the_doctor") else { return };
    let ran = Hil::new().run(&["doctor", "laps-corrected", "--bench", "vcan", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let findings = json["findings"].as_array().unwrap();
    for (subject, what) in
        [("CAN", "the kernel has"), ("interface vcan0", "up"), ("module vcan", "")]
    {
        let finding = findings.iter().find(|finding| finding["subject"] == subject);
        let finding = finding.unwrap_or_else(|| panic!("nothing about {subject}: {}", ran.out));
        assert_eq!(finding["status"], "good", "{finding}");
        assert!(finding["what"].as_str().unwrap().starts_with(what), "{finding}");
    }
}

#[test]
fn a_title_without_end_is_cut_in_tables_and_whole_in_json() {
    let title = "t".repeat(100_000);
    let hil = Hil::with_plan(&TURN.replace("One turn", &title));
    let listed = hil.run(&["list", "plans"]).exits(0).out;
    assert!(listed.contains("turn.toml") || listed.contains("ttt"), "{}", listed.len());
    assert!(listed.matches('t').count() < 10_000, "{}", listed.len());
    assert!(hil.run(&["list", "plans", "--json"]).exits(0).out.contains(&title));
}

#[test]
fn a_campaign_leaves_a_folder_of_others_alone() {
    let plan = TURN.replace("steps = [", "steps = [\n    { use_calibration = \"temperature\" },");
    let hil = Hil::with_plan(&plan);
    let ran = hil.run(&["campaign", "./turn.toml", "--cases", "1", "--out", "."]).exits(2);
    assert!(ran.err.contains("refused to write to .: it holds files of others"), "{}", ran.err);
    assert!(!hil.path("cases.jsonl").exists() && !hil.path("report.html").exists());
    hil.run(&["campaign", "./turn.toml", "--cases", "1", "--shrink-max", "0", "--out", "found"]);
    assert!(hil.path("found/cases.jsonl").is_file(), "a new folder");
    hil.run(&["campaign", "./turn.toml", "--cases", "1", "--shrink-max", "0", "--out", "found"]);
    assert!(hil.path("found/report.html").is_file(), "its own folder again");
}
