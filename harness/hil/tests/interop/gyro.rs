//! Each stream, read with pyserial and decoded by independent code.

use super::rig::{Emulated, file, number, python, told};
use serde_json::json;
use skips::in_time;
use std::process::Command;

/// Maximum error of a stream's mean: half a count of the coarsest.
const RATE_OFF_MAX_DEG_PER_S: f64 = 0.002;

fn decoded(stream: &str, frames: u32, nominal_hz: f64) {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (mut gyro, ready) =
        Emulated::start(folder.path(), &["gyro", "--stream", stream, "--pty", "gyro.pty"]);
    assert_eq!((&ready["ready"], &ready["link"]), (&json!("gyro"), &json!("gyro.pty")));
    assert!(ready["port"].as_str().unwrap().starts_with("/dev/pts/"), "{ready}");
    gyro.ask(json!({ "set": { "temperature_degC": 31.25 } }));
    gyro.ask(json!({ "rate_deg_per_s": -12.5 }));
    let read = told(Command::new(python).arg(file("tests/interop/read_gyro.py")).args([
        folder.path().join("gyro.pty").to_str().unwrap(),
        stream,
        &frames.to_string(),
    ]));
    assert_eq!((&read["good"], &read["bad"]), (&json!(frames), &json!(0)), "{read}");
    // Frames from before the request may have waited in the port.
    let rate = number(&read["rate_deg_per_s"]);
    assert!((rate + 12.5).abs() < RATE_OFF_MAX_DEG_PER_S, "{read}");
    if stream == "navigator" {
        assert!((number(&read["temperature_celsius"]) - 31.25).abs() < 0.011, "{read}");
    }
    let hz = f64::from(frames) / number(&read["took_s"]);
    assert!((0.8..1.25).contains(&(hz / nominal_hz)), "{hz} Hz instead of {nominal_hz}");
    let ended = gyro.end();
    assert!(number(&ended["ports"]["gyro"]["bytes_out"]) > 0.0, "{ended}");
}

#[test]
fn navigator() {
    in_time(|| {
        decoded("navigator", 300, 100.0);
    });
}

#[test]
fn ecore2000() {
    in_time(|| {
        decoded("ecore2000", 300, 100.0);
    });
}

#[test]
fn dsp3000_ascii() {
    in_time(|| {
        decoded("dsp3000-ascii", 300, 100.0);
    });
}

#[test]
fn dsp3000_binary() {
    in_time(|| {
        decoded("dsp3000-binary", 3_000, 1_000.0);
    });
}
