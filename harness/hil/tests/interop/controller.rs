//! A controller in Python as the device under test, correct and with a sign error.

use super::rig::{file, python, shown};
use serde_json::Value;
use skips::in_time;
use std::path::Path;
use std::process::{Command, Output};

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

/// Names of the measurements with this verdict.
fn with_verdict<'a>(summary: &'a Value, verdict: &str) -> Vec<&'a str> {
    let measurements = summary["measurements"].as_array().unwrap();
    let of = measurements.iter().filter(|measurement| measurement["verdict"] == verdict);
    of.map(|measurement| measurement["name"].as_str().unwrap()).collect()
}

#[test]
fn somebody_elses_controller_drives_a_square() {
    let Some(python) = python() else { return };
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let (output, summary) = run(&python, &folder.path().join("run"), &[]);
        assert_eq!(output.status.code(), Some(0), "{}{summary:#}", shown(&output));
        assert!(with_verdict(&summary, "fail").is_empty(), "{summary:#}");
    });
}

/// The same program, started outside the harness, takes its missions over a socket.
#[test]
fn somebody_elses_controller_is_attached_to() {
    let Some(python) = python() else { return };
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let (output, summary) = attached(&python, folder.path());
        assert_eq!(output.status.code(), Some(0), "{}{summary:#}", shown(&output));
        let device = summary["device_under_test"].as_str().unwrap();
        assert!(device.starts_with("attached at tcp:127.0.0.1:"), "{device}");
    });
}

/// A run on ptys, whose controller starts once they exist.
fn attached(python: &Path, folder: &Path) -> (Output, Value) {
    // A port that was free a moment ago.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let at = |name: &str| folder.join(name).display().to_string();
    let bench = format!(
        "[gyro]\nport = \"pty:{}\"\nemulated = true\n[base]\nport = \"pty:{}\"\nemulated = true\n\
         [controller]\nattach = \"tcp:127.0.0.1:{port}\"\n",
        at("gyro"),
        at("base")
    );
    let (file_name, out) = (folder.join("bench.toml"), at("run"));
    std::fs::write(&file_name, bench).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_hil"))
        .arg("run")
        .arg(file("tests/interop/plans/square.toml"))
        .args(["--clock", "real", "--bench"])
        .arg(file_name)
        .args(["--out", &out])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut start = Command::new("sh");
    // It opens its ports at once, so they must exist.
    let script = "while [ ! -e \"$2\" ] || [ ! -e \"$3\" ]; do sleep 0.05; done; exec \"$0\" \"$1\" \
                  --gyro \"$2\" --base \"$3\" --listen \"$4\"";
    start.args(["-c", script]).arg(python);
    start.arg(file("tests/interop/python_controller/controller.py"));
    start.args([at("gyro"), at("base"), format!("tcp:127.0.0.1:{port}")]);
    let mut controller = start.spawn().unwrap();
    let output = run.wait_with_output().unwrap();
    // It ends with its client; if there was none, it is killed here.
    let _ = controller.kill();
    let _ = controller.wait();
    let summary = std::fs::read(Path::new(&out).join("summary.json"))
        .unwrap_or_else(|error| panic!("{error}: {}", shown(&output)));
    (output, serde_json::from_slice(&summary).unwrap())
}

/// The controller trusts its own estimate: only the absolute measurement shows that its square goes the other way
/// round.
#[test]
fn a_sign_that_has_slipped_is_found() {
    let Some(python) = python() else { return };
    in_time(|| {
        let folder = tempfile::tempdir().unwrap();
        let slip = ["--slip", "clockwise-positive"];
        let (output, summary) = run(&python, &folder.path().join("run"), &slip);
        assert_eq!(output.status.code(), Some(1), "{}{summary:#}", shown(&output));
        assert_eq!(summary["outcome"], "failed");
        assert!(with_verdict(&summary, "fail").contains(&"corner_heading"), "{summary:#}");
        assert!(with_verdict(&summary, "pass").contains(&"return_x"), "{summary:#}");
    });
}
