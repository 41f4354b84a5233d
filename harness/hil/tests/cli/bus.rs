//! Bus logs exported from runs, and imported as runs.

use crate::hil::Hil;
use std::fs;

/// Two straight lines and a corner, judged by the traffic on the CAN bus.
const LINES: &str = r#"
name = "lines"
title = "There and back"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { repeat = { times = 2, steps = [
        { straight = { distance_m = 1 } },
        { turn = { angle_deg = 90 } },
        { straight = { distance_m = -0.5 } },
    ] } },
]

[[measurement]]
name = "stop_error"
doc = "Travelled minus commanded distance"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [-0.002, 0.002] }
paper = "none"

[[measurement]]
name = "second_round"
doc = "The same on the way there, in the second round"
quantity = "straight.stop_error"
where = { run = 2 }
unit = "m"
check = { all_within = [-0.002, 0.002] }
paper = "none"

[[measurement]]
name = "retries"
doc = "Pose downloads that were tried again"
quantity = "pose_write.retries"
unit = "1"
check = { all_within = [0, 0] }
paper = "none"
"#;

/// A folder with the plan and a full record of its run.
fn recorded() -> Hil {
    let hil = Hil::new();
    fs::write(hil.path("lines.toml"), LINES).unwrap();
    hil.run(&["run", "lines.toml", "--out", "run", "--record", "full"]).exits(0);
    hil
}

/// Value and number of observations of each measurement.
fn figures(hil: &Hil, run: &str) -> Vec<(String, Option<f64>, u64)> {
    let summary = fs::read(hil.path(run).join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
    let measurements = summary["measurements"].as_array().unwrap().iter();
    measurements
        .map(|one| {
            let name = one["name"].as_str().unwrap().to_owned();
            (name, one["value"].as_f64(), one["observations"].as_u64().unwrap())
        })
        .collect()
}

#[test]
fn a_log_of_a_run_is_judged_as_the_run_was() {
    let hil = recorded();
    for end in ["log", "asc", "pcapng", "trc", "blf", "mf4"] {
        let log = &format!("bus.{end}");
        let exported = hil.run(&["export", "run", "--bus", log]).exits(0);
        assert!(exported.out.starts_with(&format!("{log}: ")), "{}", exported.out);
        let only_pcapng = exported.out.contains("packets of serial lines left out");
        assert_eq!(only_pcapng, end != "pcapng", "{}", exported.out);
        let arguments = ["import", log, "--plan", "lines.toml", "--out", "again"];
        let imported = hil.run(&arguments).exits(0);
        assert!(imported.err.contains("can0: ") && imported.err.contains(" 6 moves"));
        // Equal within the displacement's step of 0.1 mm.
        for (run, again) in figures(&hil, "run").iter().zip(&figures(&hil, "again")) {
            assert_eq!((&run.0, run.2), (&again.0, again.2), "{log}");
            let (was, is) = (run.1.unwrap(), again.1.unwrap());
            assert!((was - is).abs() <= 0.000_101, "{log} {}: {was} {is}", run.0);
        }
        let checked = hil.run(&["check", "again", "--plan", "lines.toml"]).exits(0);
        assert_eq!(checked.out, imported.out);
    }
    let shown = hil.run(&["show", "again", "--device", "base"]).exits(0);
    let count = |what| shown.out.lines().filter(|line| line.contains(what)).count();
    assert_eq!((count("note a straight line of "), count("note a turn by 87.0 deg")), (4, 2));
}

#[test]
fn logs_are_converted_there_and_back() {
    let hil = recorded();
    hil.run(&["export", "run", "--bus", "a.log"]).exits(0);
    let convert = |from, to| hil.run(&["log", "convert", from, to]).exits(0);
    convert("a.log", "b.pcapng");
    convert("b.pcapng", "c.asc");
    convert("c.asc", "f.trc");
    convert("f.trc", "g.blf");
    convert("g.blf", "h.mf4");
    convert("h.mf4", "d.log");
    let read = |name| fs::read_to_string(hil.path(name)).unwrap();
    assert_eq!(read("a.log"), read("d.log"));
    assert!(read("a.log").lines().count() > 1_000);

    hil.run(&["log", "convert", "a.log", "e.txt"]).exits(2);
    hil.run(&["log", "convert", "a.log", "e.txt", "--to", "asc"]).exits(0);
    assert_eq!(read("c.asc"), read("e.txt"));
    std::fs::hard_link(hil.path("a.log"), hil.path("linked.log")).unwrap();
    for other in ["./a.log", "linked.log"] {
        let itself = hil.run(&["log", "convert", "a.log", other]).exits(2);
        assert!(itself.err.contains("written over itself"), "{}", itself.err);
    }
    let wrong = hil.run(&["log", "convert", "c.asc", "f.log", "--from", "candump"]).exits(2);
    assert!(wrong.err.contains("c.asc as candump: line 1: expected a time"), "{}", wrong.err);

    // A file that ends in the middle of its last line.
    let whole = read("a.log");
    fs::write(hil.path("cut.log"), &whole[..whole.trim_end().rfind('#').unwrap()]).unwrap();
    let cut = hil.run(&["log", "convert", "cut.log", "kept.log"]).exits(2);
    let kept = whole.lines().count() - 1;
    assert!(cut.err.contains(&format!("kept.log: {kept} entries before the error")), "{}", cut.err);
    assert!(
        cut.err.contains("the file seems to be cut short") && !cut.err.contains("--from"),
        "{}",
        cut.err
    );
    assert_eq!(read("kept.log").lines().count(), kept);
    fs::write(hil.path("empty.log"), "").unwrap();
    let empty = hil.run(&["log", "convert", "empty.log", "none.asc"]).exits(0);
    assert!(empty.err.contains("empty.log: it has no entries"), "{}", empty.err);
}

#[test]
fn what_a_log_cannot_say_is_told() {
    let hil = recorded();
    hil.run(&["export", "run", "--bus", "bus.log"]).exits(0);
    let arguments = ["import", "bus.log", "--plan", "straight-accuracy"];
    let imported = hil.run(&arguments).exits(1);
    assert!(imported.err.contains("heading_held cannot be judged by a log"), "{}", imported.err);
    assert!(imported.out.contains("does not follow the plan"), "{}", imported.out);
    assert_eq!(hil.outcome("runs/straight-accuracy-bus"), "failed");
    let table = hil.run(&["import", "bus.log", "--plan", "verification", "--out", "t"]).exits(2);
    assert!(table.err.contains("none of its steps moves the base"), "{}", table.err);
    let other = ["import", "bus.log", "--plan", "lines.toml", "--out", "t", "--channel", "can1"];
    let other = hil.run(&other).exits(2);
    assert!(other.err.contains("the log has no channel `can1`"), "{}", other.err);
    assert!(!hil.path("t").exists(), "a log without a base makes no folder");
}

#[test]
fn a_run_without_frames_has_no_log() {
    let hil = Hil::new();
    fs::write(hil.path("lines.toml"), LINES).unwrap();
    hil.run(&["run", "lines.toml", "--out", "run"]).exits(0);
    let none = hil.run(&["export", "run", "--bus", "bus.log"]).exits(2);
    assert!(none.err.contains("--record full"), "{}", none.err);
    assert!(!hil.path("bus.log").exists());
    let name = hil.run(&["export", "run", "--bus", "bus.txt"]).exits(2);
    assert!(name.err.contains(".log, .asc, .pcapng, .trc, .blf or .mf4"), "{}", name.err);
}
