//! Measured data: export, identify, predict.

use crate::hil::{Hil, TURN};
use std::fs;
use std::path::{Path, PathBuf};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../test-data/measured").join(name)
}

/// Everything in the folder, but what was there before.
fn nothing_written(hil: &Hil) {
    assert!(
        !hil.path("findings").exists() && !hil.path("out").exists() && !hil.path("data").exists()
    );
}

#[test]
fn a_run_is_exported_and_read_again() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run", "--quiet"]).exits(0);
    let ran = hil.run(&["export", "run"]).exits(0);
    assert!(ran.out.starts_with("data/turn-seed1-series: "), "{}", ran.out);
    let package = hil.path("data/turn-seed1-series");
    let text = fs::read_to_string(package.join("datapackage.json")).unwrap();
    assert!(text.contains("\"kind\": \"series\""), "{text}");
    let packed =
        hil.run(&["export", "run", "--kind", "series", "--gzip", "--out", "packed"]).exits(0);
    assert!(hil.path("packed/data.csv.gz").is_file(), "{}", packed.out);
    let of = |path: &Path| harness::dataset::read(path).unwrap();
    assert_eq!(format!("{:?}", of(&package)), format!("{:?}", of(&hil.path("packed"))));
    let turns = hil.run(&["export", "run", "--kind", "turns", "--out", "out"]).exits(2);
    assert!(turns.err.contains("run holds no turns"), "{}", turns.err);
    assert!(!hil.path("out").exists());
}

#[test]
fn bad_data_are_named_and_nothing_is_written() {
    let hil = Hil::new();
    let ran = hil.run(&["identify", "nowhere"]).exits(2);
    assert!(ran.err.contains("no data in nowhere"), "{}", ran.err);
    let gyro = shipped("gyro-at-rest-over-temperature");
    fs::create_dir(hil.path("set")).unwrap();
    let text = fs::read_to_string(gyro.join("datapackage.json")).unwrap();
    fs::write(hil.path("set/datapackage.json"), text.replace("rad/s", "dps")).unwrap();
    for arguments in
        [&["identify", "set", "--out", "out"][..], &["predict", "set", "--model", "m.toml"]]
    {
        fs::write(hil.path("m.toml"), "schema = 1\nkind = \"series\"\n").unwrap();
        let ran = hil.run(arguments).exits(2);
        assert!(ran.err.contains("set/datapackage.json, field gyro_x: unit `dps`"), "{}", ran.err);
        assert!(ran.err.contains("\"unit\": \"dps\""), "the place is shown: {}", ran.err);
    }
    nothing_written(&hil);
}

#[test]
fn what_is_found_is_the_same_again_to_the_byte() {
    let hil = Hil::with_plan(TURN);
    hil.run(&["run", "turn.toml", "--out", "run", "--quiet"]).exits(0);
    hil.run(&["export", "run", "--out", "set"]).exits(0);
    for out in ["out", "again"] {
        hil.run(&["identify", "set", "--out", out]).exits(0);
    }
    for name in ["finding.json", "model.toml", "report.html"] {
        let of = |out: &str| fs::read(hil.path(out).join(name)).unwrap();
        assert!(!of("out").is_empty() && of("out") == of("again"), "{name}");
    }
    let page = fs::read_to_string(hil.path("out/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.contains("What was found"));
}

#[test]
fn a_bad_model_is_shown_in_its_place() {
    let hil = Hil::new();
    let gyro = shipped("gyro-at-rest-over-temperature");
    fs::write(hil.path("m.toml"), "schema = 1\nkind = \"serie\"\n").unwrap();
    for command in ["identify", "predict"] {
        let ran = hil.run(&[command, gyro.to_str().unwrap(), "--model", "m.toml"]).exits(2);
        assert!(ran.err.contains("m.toml:2") && ran.err.contains("serie"), "{}", ran.err);
    }
    let ran = hil.run(&["identify", gyro.to_str().unwrap(), "--max-effects", "65"]).exits(2);
    assert!(ran.err.contains("65 is not in 0..=64"), "{}", ran.err);
    nothing_written(&hil);
}
