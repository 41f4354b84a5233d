//! Measured data: export, identify, predict.

use crate::hil::{Hil, TURN};
use std::fs;
use std::path::{Path, PathBuf};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test-data/measured").join(name)
}

/// Checks that the command wrote nothing to the folder.
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
    let of = |path: &Path| dataset::read(path).unwrap();
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

/// The model lacks what the data need, which shows as soon as they are read: the folder was looked at before.
#[test]
fn a_folder_that_takes_no_findings_is_told_before_the_work() {
    let hil = Hil::new();
    let gyro = shipped("gyro-at-rest-over-temperature");
    fs::write(hil.path("m.toml"), "schema = 1\nkind = \"turns\"\n").unwrap();
    fs::write(hil.path("file"), "mine").unwrap();
    fs::create_dir(hil.path("full")).unwrap();
    for name in ["report.html", "prediction.json"] {
        fs::write(hil.path("full").join(name), "mine").unwrap();
    }
    for command in ["identify", "predict"] {
        for (out, status, said) in [
            ("file", 3, "file"),
            ("file/deep/er", 3, "file"),
            ("full", 2, "another program wrote it"),
        ] {
            let arguments = [command, gyro.to_str().unwrap(), "--model", "m.toml", "--out", out];
            let ran = hil.run(&arguments).exits(status);
            assert!(ran.err.contains(said), "{}", ran.err);
        }
    }
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

/// Table runs in one warm-up, with a bias of 0.0005 deg/s per K: temperature, its rate and time cannot be told apart.
fn one_warm_up(folder: &Path) {
    let field = |name: &str, unit: &str, role: &str| {
        format!(r#"{{ "name": "{name}", "type": "number", "unit": "{unit}", "role": "{role}" }}"#)
    };
    let fields = [
        field("t", "s", "time"),
        field("run", "1", "run"),
        field("way", "1", "direction"),
        field("gyro", "deg", "gyro_angle"),
        field("table", "deg", "reference_angle"),
        field("temperature", "Cel", "temperature"),
        field("duration", "s", "duration"),
    ];
    let package = format!(
        r#"{{ "name": "warm-up", "hil": {{ "kind": "turns" }}, "resources": [ {{ "name": "data",
            "path": "data.csv", "schema": {{ "fields": [ {} ] }} }} ] }}"#,
        fields.join(", ")
    );
    let mut rows = "t,run,way,gyro,table,temperature,duration\n".to_owned();
    for turn in 0..300 {
        let (run, way) = (turn / 2, if turn % 2 == 0 { -1.0 } else { 1.0 });
        let time = 48.0 * f64::from(run) + 34.0 + 14.0 * f64::from(turn % 2);
        let warmth = 18.0 * (1.0 - (-time / 2100.0).exp());
        // Nearly white noise: the fractional parts of multiples of an irrational number.
        let noise = 0.03 * ((f64::from(turn * turn) * 0.618_033_988_75).fract() - 0.5);
        let gyro = 360.0 * way + 14.0 * 5e-4 * warmth + noise;
        rows += &format!("{time},{run},{way},{gyro:.5},{},{:.4},14\n", 360.0 * way, 22.0 + warmth);
    }
    fs::create_dir(folder).unwrap();
    fs::write(folder.join("datapackage.json"), package).unwrap();
    fs::write(folder.join("data.csv"), rows).unwrap();
}

#[test]
fn the_plan_that_would_decide_lies_beside_the_finding() {
    let hil = Hil::new();
    one_warm_up(&hil.path("warm-up"));
    let ran = hil.run(&["identify", "warm-up", "--out", "out"]).exits(0);
    let text = fs::read(hil.path("out/finding.json")).unwrap();
    let finding: identification::finding::Finding = serde_json::from_slice(&text).unwrap();
    let next = finding.next_experiment.unwrap_or_else(|| panic!("{}", ran.out));
    assert!(ran.out.contains(&format!("next: {} tells", next.plan)), "{}", ran.out);
    let plan = fs::read_to_string(hil.path("out").join(&next.plan)).unwrap();
    let plan = plan::Plan::parse(&next.plan, &plan).unwrap();
    assert_eq!(format!("{}.toml", plan.name), next.plan);
}

#[test]
fn a_model_that_lacks_something_is_named_by_its_file() {
    let hil = Hil::new();
    let gyro = shipped("gyro-at-rest-over-temperature");
    let model = "schema = 1\nkind = \"series\"\n[fields]\n[[terms]]\nname = \"bias\"\nterm = \"bias\"\n\
        form = \"constant\"\nparameters = []\n";
    fs::write(hil.path("m.toml"), model).unwrap();
    let ran = hil.run(&["predict", gyro.to_str().unwrap(), "--model", "m.toml"]).exits(2);
    assert!(
        ran.err.contains(" by m.toml") && ran.err.contains("lacks its parameter"),
        "{}",
        ran.err
    );
}
