//! Programs in the place of the paper's controller that say too little or too much, in virtual time.

use super::hil::{Hil, Ran, TURN};
use std::fs;

/// A health report, without any state.
const HEALTH: &str = "{\"at_ns\":1,\"report\":{\"health\":{\"level\":\"ok\",\"causes\":{}}}}\n";

/// Runs a plan with this shell script in the place of its controller.
fn with_script(script: &str) -> (Hil, Ran) {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("health"), HEALTH).unwrap();
    fs::write(hil.path("many"), HEALTH.repeat(1_000)).unwrap();
    fs::write(hil.path("talk.sh"), script).unwrap();
    let ran = hil.run(&["run", "turn.toml", "--controller", "sh ./talk.sh", "--out", "run"]);
    (hil, ran)
}

/// Found by a user: each waited for the time limit of the plan.
#[test]
fn a_controller_that_reports_no_state_ends_the_run_after_ten_seconds() {
    for (script, why) in [
        ("exec sleep 1000", "said nothing within 10 s"),
        ("cat health; exec sleep 1000", "reported no state within 10 s"),
        ("echo no report; exec sleep 1000", "said one line that is no report within 10 s"),
    ] {
        let (hil, ran) = with_script(script);
        assert_eq!(ran.status, Some(1), "{ran:?}");
        assert!(ran.out.contains(&format!("the device under test {why}")), "{}", ran.out);
        let summary = fs::read_to_string(hil.path("run/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        // The base is given 5 s to come to rest.
        assert!(summary["simulated_s"].as_f64().unwrap() <= 15.0, "{summary}");
    }
}

/// As a program of a rig: what is under test has failed if it exits, and the bench is broken if it cannot start.
#[test]
fn a_controller_that_exits_fails_and_one_that_cannot_start_is_an_error() {
    let (hil, ran) = with_script("echo out of coffee >&2; exit 7");
    assert_eq!(ran.status, Some(1), "{ran:?}");
    let why =
        "the device under test exited during the run (status 7); its last words: out of coffee";
    assert!(ran.out.contains(why), "{}", ran.out);

    let ran = hil.run(&["run", "turn.toml", "--controller", "./no-such-program", "--out", "none"]);
    assert_eq!(ran.status, Some(3), "{ran:?}");
    assert!(ran.out.contains("no-such-program"), "{}", ran.out);

    let campaign = ["campaign", "turn.toml", "--controller", "sh ./talk.sh", "--cases", "2"];
    let ran = hil.run(&[&campaign[..], &["--out", "campaign"]].concat());
    assert_eq!(ran.status, Some(2), "{ran:?}");
    assert!(ran.err.contains("breaks the property keeps_running without any fault"), "{}", ran.err);
}

/// Found by a user: 334 MB of health reports.
#[test]
fn a_controller_that_floods_fails_and_fills_no_disk() {
    for line in ["cat many", "sed s/at_ns/no/ many"] {
        let script = format!("while :; do for i in $(seq 30); do {line}; sleep 0.01; done; done");
        let (hil, ran) = with_script(&script);
        assert_eq!(ran.status, Some(1), "{ran:?}");
        assert!(ran.out.contains("more than 20000 reports within 1 s"), "{}", ran.out);
        let bytes = fs::metadata(hil.path("run/record.hilrec")).unwrap().len();
        assert!(bytes < 4_000_000, "a record of {bytes} bytes");
    }
}
