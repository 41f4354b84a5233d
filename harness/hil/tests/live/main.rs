//! The live world from outside: real time, real ports, our controller in this process and as a separate process.
//!
//! * [`attach`]: controllers that already run.
//! * [`beside`]: other nodes beside the robot.
//! * [`by_hand`]: actions of a person on real devices.
//! * [`campaign`]: cases on a bench.
//! * [`can`]: a base on CAN, behind an adapter and on an interface of the kernel.
//! * [`commands`]: what a bench does by commands of its own.
//! * [`faults`]: what goes wrong on purpose, and properties.
//! * [`late`]: devices that answer late.
//! * [`lease`]: benches that people share.
//! * [`liars`]: controllers that say what is not so.
//! * [`ports`]: ports that come and go.
//! * [`real_nodes`]: nodes of a rig that a bench has.
//! * [`real_ports`]: real devices of a rig, and what is lost at their ports.
//! * [`repeated`]: runs that are repeated, and what they say of their bench.
//! * [`table`]: an emulated table on a port.
//! * [`wrong`]: wrong wiring and settings.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod attach;
mod beside;
mod by_hand;
mod campaign;
mod can;
mod commands;
mod faults;
mod late;
mod lease;
mod liars;
mod own_device;
mod ports;
mod real_nodes;
mod real_ports;
mod repeated;
mod table;
mod wrong;

use skips::in_time;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn hil() -> Command {
    Command::new(env!("CARGO_BIN_EXE_hil"))
}

fn run(arguments: &[&str], out: &Path) -> Output {
    hil().args(arguments).arg("--out").arg(out).output().unwrap()
}

fn summary(out: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap()
}

/// Returns the whole record as text.
fn record(out: &Path) -> String {
    let shown = hil().arg("show").arg(out).output().unwrap();
    assert!(shown.status.success(), "{}", self::shown(&shown));
    String::from_utf8_lossy(&shown.stdout).into_owned()
}

fn shown(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

fn out(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join(name);
    (folder, out)
}

/// The paper's table run: 20 s of bias test and a turn each way, 50 s of real time.
#[test]
fn a_table_run_with_the_controller_as_a_process() {
    in_time(|| {
        let (_folder, out) = out("table-run");
        let output =
            run(&["run", "live-table-run", "--clock", "real", "--controller", "process"], &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let summary = summary(&out);
        assert_eq!(summary["outcome"], "passed");
        assert_eq!((&summary["clock"], &summary["bus"]), (&"real".into(), &"pty".into()));
        assert_eq!(summary["device_under_test"], "process");
        assert!(summary["simulated_s"].as_f64().unwrap() > 45.0);
        let late = &summary["timing"]["late"];
        assert!(late["count"].as_u64().unwrap() > 100, "{late}");
        assert!(late["p50_ms"].as_f64().unwrap() <= late["p99_ms"].as_f64().unwrap(), "{late}");
        for file in ["record.hilrec", "junit.xml", "report.html", "device-under-test.log"] {
            assert!(out.join(file).is_file(), "{file}");
        }
    });
}

/// One side and one corner of the square over the base's serial line, 40 s of real time.
#[test]
fn a_side_and_a_corner_with_the_controller_in_the_process() {
    in_time(|| {
        let (_folder, out) = out("side");
        let output =
            run(&["run", "live-side", "--clock", "real", "--controller", "in-process"], &out);
        assert_eq!(output.status.code(), Some(0), "{}", shown(&output));
        let summary = summary(&out);
        assert_eq!(summary["measurements"].as_array().unwrap().len(), 7);
        assert!(summary["timing"]["bus_to_command"]["count"].as_u64().unwrap() > 10);
        assert_eq!(summary["timing"]["misses_judged"], 0);
        // Both ends of both lines.
        assert_eq!(summary["ports"].as_array().unwrap().len(), 4);
    });
}

#[test]
fn an_unreachable_port_is_named_and_the_bench_is_broken() {
    in_time(|| {
        let (folder, out) = out("port");
        let bench = folder.path().join("bench.toml");
        std::fs::write(&bench, "[gyro]\nport = \"/dev/there-is-no-such-port\"\n").unwrap();
        let bench = bench.to_str().unwrap();
        for controller in ["process", "in-process"] {
            let output = run(
                &[
                    "run",
                    "live-table-run",
                    "--clock",
                    "real",
                    "--controller",
                    controller,
                    "--bench",
                    bench,
                ],
                &out,
            );
            assert_eq!(output.status.code(), Some(3), "{controller}: {}", shown(&output));
            assert!(shown(&output).contains("/dev/there-is-no-such-port"), "{}", shown(&output));
        }
    });
}

#[test]
fn a_device_under_test_that_ends_or_never_speaks_fails_and_one_that_cannot_start_does_not() {
    in_time(|| {
        let silent = "said nothing within 10 s";
        for (command, status, said) in [
            ("false", 1, "the device under test exited during the run (status 1)"),
            ("no-such-program", 3, "start"),
            ("sleep 60", 1, silent),
        ] {
            let (_folder, out) = out("device");
            let output =
                run(&["run", "live-table-run", "--clock", "real", "--controller", command], &out);
            assert_eq!(output.status.code(), Some(status), "{command}: {}", shown(&output));
            assert!(shown(&output).contains(said), "{command}: {}", shown(&output));
        }
    });
}

/// Ctrl-C in a live run: the base is commanded to stop, and the record is kept.
#[test]
fn an_interrupted_run_keeps_its_record() {
    in_time(|| {
        let (_folder, out) = out("interrupted");
        let mut child = hil()
            .args(["run", "live-side", "--clock", "real", "--quiet", "--out"])
            .arg(&out)
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        // The wait gives a process in real time a chance to run; nothing depends on its exact length.
        #[expect(
            clippy::disallowed_methods,
            reason = "another process needs real time to get going"
        )]
        std::thread::sleep(std::time::Duration::from_secs(4));
        let pid = rustix::process::Pid::from_child(&child);
        rustix::process::kill_process(pid, rustix::process::Signal::INT).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(5));
        assert_eq!(summary(&out)["outcome"], "aborted");
        assert!(record(&out).contains("stop"), "no stop in the record");
    });
}
