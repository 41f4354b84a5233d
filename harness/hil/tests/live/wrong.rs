//! Wrong wiring and settings: each has a named error and an exit status, and the record stays complete.

use crate::can::{SIDE, plan};
use crate::{hil, out, record, run, shown, summary};
use skips::in_time;
use std::path::Path;

/// Runs `plan` with this bench; returns the exit status and the output.
fn on_bench(plan: &str, bench: &str, out: &Path) -> (Option<i32>, String) {
    let file = out.with_file_name("bench.toml");
    std::fs::write(&file, bench).unwrap();
    let arguments = ["run", plan, "--clock", "real", "--bench", file.to_str().unwrap()];
    let output = run(&arguments, out);
    (output.status.code(), shown(&output))
}

/// Returns our controller with these arguments.
fn controller(arguments: &[&str]) -> String {
    // In the same folder as `hil`, where the first test has built it.
    let program = Path::new(hil().get_program()).with_file_name("k2a-controller");
    let words: Vec<&str> =
        std::iter::once(program.to_str().unwrap()).chain(arguments.iter().copied()).collect();
    format!("[controller]\ncommand = {words:?}\n")
}

#[test]
fn a_wrong_rate_is_named() {
    in_time(|| {
        let (_folder, out) = out("rate");
        let bench = controller(&["--gyro", "{gyro}:4800", "--base", "none"]);
        let (status, said) = on_bench("live-table-run", &bench, &out);
        assert_eq!(status, Some(3), "{said}");
        let reason = summary(&out)["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains("gyro's port to 4800 baud"), "{reason}");
        assert!(reason.contains("9600"), "{reason}");
        assert!(record(&out).contains("bias"), "what was recorded is kept");
    });
}

/// The gyro's line at the base's port and the base's at the gyro's, at rates that fit the ports.
#[test]
fn crossed_lines_are_no_verdict_on_the_controller() {
    in_time(|| {
        let (_folder, out) = out("crossed");
        let crossed = controller(&[
            "--gyro",
            "{base}:19200",
            "--base",
            "serial:{gyro}:9600",
            "--stream",
            "navigator",
        ]);
        let (status, said) = on_bench("live-side", &crossed, &out);
        assert_eq!(status, Some(3), "{said}");
        let reason = summary(&out)["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains("are the lines crossed?"), "{reason}");
        assert!(!record(&out).is_empty());
    });
}

#[test]
fn two_devices_on_one_line_are_bad_input() {
    let (folder, out) = out("shared");
    let plan = plan(folder.path(), SIDE);
    let bench = "[gyro]\nport = \"/dev/ttyS0\"\n[base]\nport = \"serial:/dev/ttyS0?baud=19200\"\n";
    let (status, said) = on_bench(plan.to_str().unwrap(), bench, &out);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("failed to tell the gyro from the base"), "{said}");
}

#[test]
fn a_base_on_the_other_kind_of_line_is_bad_input() {
    let (folder, out) = out("kind");
    let plan = plan(folder.path(), SIDE);
    let bench = "[base]\nport = \"pty\"\nemulated = true\n";
    let (status, said) = on_bench(plan.to_str().unwrap(), bench, &out);
    assert_eq!(status, Some(2), "{said}");
    assert!(said.contains("has it on CAN"), "{said}");
}

/// A program that sends as the base on a bus where the harness emulates it.
#[test]
fn frames_of_the_base_that_the_harness_did_not_send_are_an_error() {
    in_time(|| {
        let (folder, out) = out("clash");
        let plan = plan(folder.path(), SIDE);
        let script = r"printf 'S6\rO\rt18180000000000000000\r' > {base}; sleep 30";
        let bench = format!("[controller]\ncommand = [\"sh\", \"-c\", {script:?}]\n");
        let (status, said) = on_bench(plan.to_str().unwrap(), &bench, &out);
        assert_eq!(status, Some(3), "{said}");
        let reason = summary(&out)["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains("another node on slcan-pty sends frames of the base"), "{reason}");
    });
}

/// Frames as fast as a pty takes them: the harness's bus drops and counts them.
#[test]
fn a_flood_is_counted_and_the_run_ends_in_order() {
    in_time(|| {
        let (folder, out) = out("flood");
        let plan = plan(folder.path(), SIDE);
        let script = r"printf 'S6\rO\r' > {base}; for i in $(seq 20000); do printf 't7FF0\r'; done > {base}; sleep 30";
        let bench = format!("[controller]\ncommand = [\"sh\", \"-c\", {script:?}]\n");
        let (status, said) = on_bench(plan.to_str().unwrap(), &bench, &out);
        assert_eq!(status, Some(1), "{said}");
        let summary = summary(&out);
        assert!(summary["reason"].as_str().unwrap().contains("said nothing within"), "{summary}");
        let base = summary["ports"].as_array().unwrap().iter().find(|port| port["role"] == "base");
        assert_eq!(base.unwrap()["counters"]["frames_in"], 20_000, "{summary}");
        assert!(!record(&out).is_empty());
    });
}

/// Runs `live-table-run` with this shell script as the controller; returns its status, its reason and its folder.
/// HEALTH in the script is a file with that line: braces in a command are ports.
fn run_with(name: &str, script: &str) -> (Option<i32>, String, tempfile::TempDir) {
    let (folder, out) = out(name);
    let health = folder.path().join("health");
    std::fs::write(&health, HEALTH).unwrap();
    let script = script.replace("HEALTH", health.to_str().unwrap());
    let bench = format!("[controller]\ncommand = [\"sh\", \"-c\", {script:?}]\n");
    let (status, said) = on_bench("live-table-run", &bench, &out);
    let reason = summary(&out)["reason"].as_str().unwrap_or(&said).to_owned();
    let bytes = std::fs::metadata(out.join("record.hilrec")).unwrap().len();
    assert!(bytes < 16_000_000, "a record of {bytes} bytes");
    (status, reason, folder)
}

/// A health report without any state.
const HEALTH: &str = r#"{"at_ns":1,"report":{"health":{"level":"ok","causes":{}}}}
"#;

#[test]
fn a_controller_that_reports_no_state_ends_the_run() {
    in_time(|| {
        let (status, reason, _folder) = run_with("stateless", "cat HEALTH; sleep 60");
        assert_eq!(status, Some(1), "{reason}");
        assert!(reason.contains("reported no state within 10 s"), "{reason}");
    });
}

#[test]
fn a_controller_that_floods_fails_and_fills_no_disk() {
    in_time(|| {
        let (status, reason, _folder) = run_with("talk", r#"exec yes "$(cat HEALTH)""#);
        assert_eq!(status, Some(1), "{reason}");
        assert!(reason.contains("more than 20000 reports within 1 s"), "{reason}");
    });
}

#[test]
fn lines_that_are_no_reports_are_counted_and_not_kept() {
    in_time(|| {
        let (status, reason, folder) =
            run_with("noise", "timeout 1 yes 'this is no report'; exec sleep 60");
        assert_eq!(status, Some(1), "{reason}");
        assert!(reason.contains(" lines that are no reports within 10 s"), "{reason}");
        let shown = record(&folder.path().join("noise"));
        let notes = shown.lines().filter(|line| line.contains("of the device under test:")).count();
        assert_eq!(notes as u64, 500, "the others are counted");
        assert!(shown.contains("that are no reports are not noted"), "{shown}");
    });
}
