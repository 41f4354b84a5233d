//! Drives the base around a square with python-can and cantools, using the DBC file.

use super::rig::{Emulated, GUEST, file, number, python, told};
use skips::{Vcan0, in_time};
use std::path::{Path, PathBuf};
use std::process::Command;

const SIDE_M: f64 = 0.5;

fn square(python: PathBuf, folder: &Path, port: &str, interface: &str, channel: &str) {
    let (mut base, _) = Emulated::start(folder, &["base", "--port", port]);
    let driven = told(
        Command::new(python)
            .current_dir(folder)
            .arg(file("tests/interop/drive_base.py"))
            .arg(file("wire/dbc/k2a.dbc"))
            .args([interface, channel, &SIDE_M.to_string()]),
    );
    let truth = base.truth();
    let base_truth = &truth["base"];
    // The base is ideal: what it reports is true, to half a count of the DBC's.
    for (told, true_) in [("x_m", "x_m"), ("y_m", "y_m")] {
        let off = number(&driven[told]) - number(&base_truth[true_]);
        assert!(off.abs() < 1e-4, "{driven} {truth}");
        assert!(number(&driven[told]).abs() < 0.05, "the square did not close: {driven}");
    }
    let off = number(&driven["heading_deg"]) - number(&base_truth["heading_deg"]);
    let wrapped = (off + 180.0).rem_euclid(360.0) - 180.0;
    assert!(wrapped.abs() < 0.01, "{driven} {truth}");
    assert!((number(&driven["path_m"]) - 4.0 * SIDE_M).abs() < 0.01, "{driven}");
    assert!((number(&driven["turned_deg"]) - 360.0).abs() < 1.0, "{driven}");
    assert_eq!(number(&driven["lost"]), 0.0, "{driven}");
    let ended = base.end();
    assert_eq!(number(&ended["counters"]["base"]["device"]["frames_ignored"]), 0.0, "{ended}");
}

#[test]
fn a_square_over_an_adapter_that_is_a_pty() {
    in_time(|| {
        let Some(python) = python() else { return };
        let folder = tempfile::tempdir().unwrap();
        square(python, folder.path(), "slcan-pty:can.pty", "slcan", "can.pty");
    });
}

#[test]
fn guest_a_square_over_a_bus_of_the_kernel() {
    in_time(|| {
        let (Some(_bus), Some(python)) = (Vcan0::take(GUEST), python()) else { return };
        let interface = Vcan0::NAME;
        let folder = tempfile::tempdir().unwrap();
        square(python, folder.path(), &format!("can:{interface}"), "socketcan", interface);
    });
}
