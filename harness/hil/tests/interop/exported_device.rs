//! A device that `hil export` wrote as an FMU says in FMPy what it says in a run.

use super::rig::{file, python_with};
use described::{Description, Sender};
use record::RecordKind;
use record::run_folder::RunFolder;
use std::path::Path;
use std::process::Command;

/// The device alone: on a bus, commands take time. It cools down to its setpoint and holds that.
const IDLE: &str = r#"
name = "idle"
title = "The oven for half a minute"
device = "oven"
steps = [{ wait = { duration_s = 30 } }]
[[measurement]]
name = "temperature"
doc = "Of the oven"
quantity = "signal.Temperature"
unit = "degC"
check = { all_within = [0, 100] }
"#;

fn hil(folder: &Path, arguments: &[&str]) -> std::process::Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    command.args(arguments).current_dir(folder).output().unwrap()
}

fn done(folder: &Path, arguments: &[&str]) {
    let output = hil(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {output:?}");
}

/// A new project with the plan, and its folder.
fn oven() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["new", "oven", "--quiet"]);
    let oven = folder.path().join("oven");
    std::fs::write(oven.join("idle.toml"), IDLE).unwrap();
    let device = oven.join("devices/oven.toml");
    let mut text = std::fs::read_to_string(&device).unwrap();
    // The noise of a run depends on the plan's name, too.
    for (from, to) in [
        ("start = \"ambient\"", "start = 80"),
        ("Setpoint = 20, Enable = 0", "Setpoint = 79, Enable = 1"),
        ("\nnoise = ", "\n# "),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(device, text).unwrap();
    (folder, oven)
}

/// The temperatures that the device sends in a run.
fn sent(oven: &Path) -> Vec<f64> {
    done(oven, &["run", "idle.toml", "--record", "full", "--out", "run"]);
    let text = std::fs::read_to_string(oven.join("devices/oven.toml")).unwrap();
    let mut beside = |name: &str| {
        std::fs::read_to_string(oven.join("devices").join(name)).map_err(|error| error.to_string())
    };
    let device = Description::parse("oven.toml", &text, &mut beside).unwrap();
    let (status, place) = device.layout().signal("Temperature").unwrap();
    let mut decoder = device.layout().decoder_for(Sender::Device);
    let mut found = Vec::new();
    for record in RunFolder::open(oven.join("run")).unwrap().records().unwrap() {
        let RecordKind::Frame(frame) = record.unwrap().kind else { continue };
        let decoded = decoder.frame(&frame).filter(|decoded| decoded.message == status);
        found.extend(decoded.and_then(|decoded| decoded.values[place]));
    }
    found
}

#[test]
fn fmpy_gets_what_a_run_records() {
    let Some(python) = python_with("import fmpy", "fmpy") else { return };
    let (_folder, oven) = oven();
    let sent = sent(&oven);
    assert!(sent.len() >= 299 && sent[0] > 79.9 && *sent.last().unwrap() < 79.1, "{sent:?}");
    for version in ["2", "3"] {
        done(&oven, &["export", "devices/oven.toml", "--fmu", "oven.fmu", "--fmi", version]);
        let mut command = Command::new(&python);
        command.arg(file("tests/interop/fmu_rows.py"));
        let name = "Status.Temperature";
        command.args(["oven.fmu", "0.1", "30", name]).current_dir(&oven);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        let told = String::from_utf8(output.stdout).unwrap();
        let theirs = told.lines().skip(1);
        let theirs = theirs.map(|line| line.split_once(',').unwrap().1.parse().unwrap());
        let theirs: Vec<f64> = theirs.collect();
        assert_eq!(theirs[..sent.len()], sent, "FMI {version}");
        // The same files give the same bytes.
        done(&oven, &["export", "devices/oven.toml", "--fmu", "again.fmu", "--fmi", version]);
        let [one, other] =
            ["oven.fmu", "again.fmu"].map(|name| std::fs::read(oven.join(name)).unwrap());
        assert!(one == other);
    }
}

#[test]
fn what_cannot_be_exported_is_named() {
    let (_folder, oven) = oven();
    let refused = |arguments: &[&str], expected: &str| {
        let output = hil(&oven, arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(expected), "{told}");
    };
    let device = "devices/oven.toml";
    refused(&["export", "devices/none.toml", "--fmu", "x.fmu"], "none.toml");
    refused(
        &["export", device, "--fmu", "x.fmu", "--library", "none.so"],
        "failed to read none.so",
    );
    refused(&["export", device, "--fmi", "2"], "--fmu");
    let text = std::fs::read_to_string(oven.join(device)).unwrap();
    std::fs::write(oven.join("own.toml"), format!("{text}\n[fmu]\nfile = \"x.fmu\"\n")).unwrap();
    std::fs::copy(oven.join("devices/oven.dbc"), oven.join("oven.dbc")).unwrap();
    refused(&["export", "own.toml", "--fmu", "x.fmu"], "cannot have an FMU of its own");
    assert!(!oven.join("x.fmu").exists());
}
