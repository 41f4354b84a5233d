//! Devices that answer late: a real robot whose line gets a buffer in the middle of a side.

use crate::attach::appears;
use crate::can::plan;
use crate::{hil, out, record, shown, summary};
use serde_json::{Value, json};
use skips::in_time;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Output, Stdio};
use std::time::{Duration, Instant};

/// Time limit of every wait, on a machine with other load.
const LIMIT: Duration = Duration::from_secs(60);

const SIDE: &str = r#"
name = "side"
title = "A side of the square"
devices = "paper-serial"
steps = [
    { bias_test = { duration_s = 3 } },
    { straight = { distance_m = 3, speed_m_per_s = 0.4 } },
]

[[measurement]]
name = "stop_error"
doc = "Travelled minus commanded distance, at rest"
quantity = "straight.stop_error"
unit = "m"
check = { all_within = [-0.02, 0.02] }
"#;

/// `hil emulate bench` on ptys, with commands that switch faults on.
struct Robot {
    child: Child,
    stdin: ChildStdin,
    stdout: BufReader<ChildStdout>,
}

impl Robot {
    fn start(folder: &Path) -> Self {
        let mut robot = hil();
        robot.args(["emulate", "bench", "--devices", "paper-serial"]);
        robot.args(["--gyro", "pty:./gyro.pty", "--base", "pty:./base.pty"]).current_dir(folder);
        let mut child = robot.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (stdin, stdout) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let mut robot = Self { child, stdin, stdout: BufReader::new(stdout) };
        // One line per port reports that it is open.
        for _ in 0..2 {
            assert!(robot.line()["ready"].is_string());
        }
        robot
    }

    fn line(&mut self) -> Value {
        let mut line = String::new();
        self.stdout.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"))
    }

    fn ask(&mut self, request: &Value) -> Value {
        writeln!(self.stdin, "{request}").unwrap();
        let mut answer = self.line();
        assert!(answer["error"].is_null(), "{answer}");
        answer["ok"].take()
    }

    /// Waits until it moves.
    #[expect(clippy::disallowed_methods, reason = "a robot drives in real time")]
    fn drives(&mut self) {
        let deadline = Instant::now() + LIMIT;
        let truth = json!({ "get": "truth" });
        while self.ask(&truth)["base"]["x_m"].as_f64().unwrap().abs() < 0.1 {
            assert!(Instant::now() < deadline, "it never drove");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        // It is no longer needed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Runs with the output of `device` held back on the way and then delivered all at once; returns its output, summary
/// and record.
fn late(device: &str) -> (Output, Value, String) {
    let (folder, out) = out("late");
    let mut robot = Robot::start(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    appears(Path::new(&at("base.pty")));
    let bench = format!(
        "[gyro]\nport = \"{}\"\n[base]\nport = \"{}\"\n[controller]\nin_process = true\n\
         [timing]\nlate_ms_max = 1000\n",
        at("gyro.pty"),
        at("base.pty")
    );
    std::fs::write(folder.path().join("bench.toml"), bench).unwrap();
    let mut run = hil();
    run.args(["run", plan(folder.path(), SIDE).to_str().unwrap(), "--clock", "real"]);
    run.arg("--bench").arg(folder.path().join("bench.toml")).args(["--record", "full", "--out"]);
    let run = run.arg(&out).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    robot.drives();
    let stall = json!({ "stall": { "for_s": 0.6 } });
    robot.ask(&json!({ "fault": stall, "device": device, "toward": "host" }));
    let output = run.wait_with_output().unwrap();
    let counters = robot.ask(&json!({ "get": "counters" }));
    assert!(counters["faults_acted"].as_u64().unwrap() > 0, "{counters}");
    (output, summary(&out), record(&out))
}

/// Checks that the record contains the reason, followed by the input that came too late for the controller. The reason
/// may have a second clause: a controller that hears late from the base may not see in time that it stands.
fn kept_to_the_end(record: &str, reason: &str, device: &str) {
    let clauses = reason.split_once("; ").or_else(|| reason.split_once(". "));
    let (broke_off, then) = clauses.unwrap_or((reason, ""));
    let Some((_, after)) = record.split_once(broke_off) else {
        panic!("the record does not give the reason, {reason}:\n{record}")
    };
    let kept = |line: &&str| line.contains(device) && line.contains("bytes ");
    assert!(after.lines().any(|line| kept(&line)), "{after}");
    assert!(after.contains(then), "{reason}:\n{after}");
}

/// Its answers arrive after the controller's time-out: the controller must break off, and does.
#[test]
fn a_base_that_answers_late_is_named_and_every_answer_kept() {
    in_time(|| {
        let (output, summary, record) = late("base");
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("straight") && reason.contains("base"), "{reason}");
        kept_to_the_end(&record, reason, "base");
    });
}

/// A buffer on the gyro's line: for a moment nothing arrives, then everything, late.
#[test]
fn a_gyro_that_is_held_up_is_named_and_every_sample_kept() {
    in_time(|| {
        let (output, summary, record) = late("gyro");
        assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
        let reason = summary["reason"].as_str().unwrap();
        assert!(reason.contains("straight") && reason.contains("gyro"), "{reason}");
        kept_to_the_end(&record, reason, "gyro");
    });
}
