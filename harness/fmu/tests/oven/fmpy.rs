//! FMPy as the referee: the same numbers.

use crate::{DEVICE, at, device, folder, run};
use std::process::Command;

fn python() -> Option<String> {
    let python = std::env::var("HIL_TESTS_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let loaded = Command::new(&python).args(["-c", "import fmpy"]).output();
    if loaded.is_ok_and(|loaded| loaded.status.success()) {
        return Some(python);
    }
    let why = format!("{python} has no fmpy");
    let how = "tests/interop/README.md says how to install it";
    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
    None
}

#[test]
fn fmpy_and_a_device_agree() {
    let Some(python) = python() else { return };
    for version in [2, 3] {
        let folder = folder(version);
        let inputs = folder.path().join("inputs.csv");
        std::fs::write(&inputs, "time,power,enabled\n0,400,1\n0.5,1000,1\n2,1000,0\n").unwrap();
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/fmu_rows.py");
        let told = Command::new(&python)
            .arg(script)
            .arg(folder.path().join("oven.fmu"))
            .args(["0.02", "3", "temperature"])
            .arg(&inputs)
            .args(["ambient=18", "load.capacity=250", "load.loss=2"])
            .output()
            .unwrap();
        assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
        let told = String::from_utf8(told.stdout).unwrap();
        let theirs = told.lines().filter_map(|line| line.split_once(',')?.1.parse::<f64>().ok());
        let theirs: Vec<f64> = theirs.collect();
        let ours = run(&mut device(&folder, DEVICE), at(3.0));
        let ours: Vec<f64> = ours
            .iter()
            .map(|(_, bytes)| f64::from_le_bytes(bytes[..8].try_into().unwrap()))
            .collect();
        // The device first sends after its first step.
        assert_eq!(ours.len() + 1, theirs.len());
        for (ours, theirs) in ours.iter().zip(&theirs[1..]) {
            assert!((ours - theirs).abs() <= 1e-12 * theirs.abs(), "{ours} {theirs}");
        }
    }
}
