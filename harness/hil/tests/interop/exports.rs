//! Exports of a run, read by pandas, pyarrow, asammdf and the official reader of MCAP, and by the examples that we ship.

use super::rig::{file, number, python_with, told};
use plan::observation::Observation;
use record::run_folder::RunFolder;
use record::{Record, RecordKind};
use std::path::{Path, PathBuf};
use std::process::Command;
use wire::can::{Id, StandardId};

const LAPS: &str = r#"
name = "two-laps"
title = "A lap each way round"
devices = "paper"
steps = [
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { bias_test = { duration_s = 20 } },
    { lap = { direction = "cw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { lap = { direction = "ccw", side_m = 1, speed_m_per_s = 0.4, turn_rate_deg_per_s = 30 } },
]

[[measurement]]
name = "gyro_return"
doc = "Heading after a lap"
quantity = "lap.gyro_error"
unit = "deg"
check = { all_within = [-20, 20] }
paper = "within +-1.0 deg (Fig. 5)"
"#;

fn python() -> Option<PathBuf> {
    python_with("import mcap, pandas, pyarrow", "pandas, pyarrow and mcap")
}

fn hil(folder: &Path, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {output:?}");
}

/// Creates a run with every byte and frame, and its exports.
fn exported(folder: &Path) -> RunFolder {
    std::fs::write(folder.join("two-laps.toml"), LAPS).unwrap();
    hil(folder, &["run", "two-laps.toml", "--out", "run", "--record", "full"]);
    hil(folder, &["export", "run", "--tables", "tables"]);
    hil(folder, &["export", "run", "--tables", "csv", "--format", "csv"]);
    hil(folder, &["export", "run", "--mcap", "run.mcap"]);
    RunFolder::open(folder.join("run")).unwrap()
}

#[test]
fn pandas_and_the_official_reader_find_what_was_recorded() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = exported(folder.path());
    let script = file("tests/interop/read_exports.py");
    let mut command = Command::new(&python);
    command.arg(script).args(["tables", "csv", "run.mcap"]).current_dir(folder.path());
    let read = told(&mut command);

    let kinds: Vec<RecordKind> =
        run.records().unwrap().map(|record| record.unwrap().kind).collect();
    let count = |is: fn(&RecordKind) -> bool| kinds.iter().filter(|kind| is(kind)).count() as f64;
    let frames = count(|kind| matches!(kind, RecordKind::Frame(_)));
    let packets = count(|kind| matches!(kind, RecordKind::Bytes(_)));
    let truths = count(|kind| matches!(kind, RecordKind::Truth { .. }));
    let observed = count(|kind| matches!(kind, RecordKind::Observation(_)));
    assert!(frames > 100.0 && packets > 1_000.0 && observed > 5.0);
    for (table, topic, expected) in [
        ("frames", "/can/frames", frames),
        ("packets", "/serial/packets", packets),
        ("truth", "/base/true_pose", truths),
    ] {
        assert_eq!(number(&read["rows"][table]), expected, "{table}");
        assert_eq!(number(&read["topics"][topic]), expected, "{topic}");
    }
    assert_eq!(number(&read["rows"]["observations"]), observed);
    assert_eq!(read["differ"], serde_json::json!([]), "Parquet and CSV differ");
    assert_eq!(read["ascending"], true);
    assert_eq!(read["units"]["states"]["heading_deg"], "deg");
    assert_eq!(read["facts"]["hil"]["outcome"], "passed");
    assert!(number(&read["attached"]["summary.json"]) > 100.0, "{read}");
}

/// MOTION of `wire/dbc/k2a.dbc`.
const MOTION: u16 = 0x181;

/// Imports it as the scripts in `tests/interop` do.
const ASAMMDF: &str =
    "import sys; sys.path.append(sys.prefix + '/apart'); import asammdf, canmatrix";

#[test]
fn asammdf_decodes_the_frames_of_a_run_by_a_dbc() {
    let Some(python) = python_with(ASAMMDF, "asammdf") else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = exported(folder.path());
    hil(folder.path(), &["export", "run", "--bus", "run.mf4"]);
    let mut command = Command::new(&python);
    command.arg(file("tests/interop/read_bus_logging.py"));
    command.arg("run.mf4").arg(file("wire/dbc/k2a.dbc")).current_dir(folder.path());
    let signals = told(&mut command);
    let motion = Id::from(StandardId::new(MOTION).unwrap());
    let is_motion = |record: &Record| match &record.kind {
        RecordKind::Frame(frame) => frame.id() == motion,
        _ => false,
    };
    let frames = run.records().unwrap().filter(|record| is_motion(record.as_ref().unwrap()));
    let count = frames.count() as f64;
    assert!(count > 100.0, "{count} frames of motion");
    assert_eq!(number(&signals["DISPLACEMENT"]["values"]), count, "{signals}");
    assert_eq!(signals["DISPLACEMENT"]["unit"], "m");
}

/// Output of `read_channels.py` for the run in `folder/run`; the script also compares with the run's tables.
fn channels(python: &Path, folder: &Path) -> serde_json::Value {
    hil(folder, &["export", "run", "--tables", "csv", "--format", "csv"]);
    hil(folder, &["export", "run", "--mf4", "run.mf4"]);
    let mut command = Command::new(python);
    command.arg(file("tests/interop/read_channels.py")).args(["run.mf4", "csv"]);
    told(command.current_dir(folder))
}

#[test]
fn asammdf_finds_in_channels_what_is_in_tables() {
    let imports = format!("{ASAMMDF}, pandas");
    let Some(python) = python_with(&imports, "asammdf and pandas") else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = exported(folder.path());
    let read = channels(&python, folder.path());
    assert_eq!(read["differ"], serde_json::json!([]), "channels and tables differ");
    let truths = run.records().unwrap();
    let is_truth = |record: &Record| matches!(record.kind, RecordKind::Truth { .. });
    let truths = truths.filter(|record| is_truth(record.as_ref().unwrap())).count() as f64;
    assert!(truths > 100.0, "{truths} truths");
    assert_eq!(number(&read["rows"]["truth"]), truths, "{read}");
    assert_eq!(number(&read["rows"]["measurements"]), 1.0);
    assert_eq!(number(&read["rows"]["observations/lap.gyro_error"]), 2.0);
    assert!(number(&read["rows"]["messages/base.MOTION"]) > 100.0, "{read}");
    assert_eq!(read["units"]["states"]["time_s"], "s");
    assert_eq!(read["units"]["states"]["gyro_heading_deg"], "deg");
    assert_eq!(read["units"]["messages/base.MOTION"]["DISPLACEMENT"], "m");
    assert_eq!(read["facts"]["plan"], "two-laps");
    assert_eq!(read["facts"]["outcome"], "passed");
}

#[test]
fn asammdf_names_values_as_the_dbc_does() {
    let imports = format!("{ASAMMDF}, pandas");
    let Some(python) = python_with(&imports, "asammdf and pandas") else { return };
    let folder = tempfile::tempdir().unwrap();
    hil(folder.path(), &["new", "oven"]);
    let folder = folder.path().join("oven");
    let dbc = folder.join("devices/oven.dbc");
    let named = std::fs::read_to_string(&dbc).unwrap() + "VAL_ 257 HeaterOn 0 \"off\" 1 \"on\" ;\n";
    std::fs::write(dbc, named).unwrap();
    hil(&folder, &["run", "safe-alone.toml", "--out", "run", "--record", "full"]);
    let read = channels(&python, &folder);
    assert_eq!(read["differ"], serde_json::json!([]), "channels and tables differ");
    let names = &read["names"]["messages/device.Status.HeaterOn"];
    assert_eq!(*names, serde_json::json!(["off", "on"]), "{read}");
}

#[test]
fn the_examples_say_what_the_run_came_to() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = exported(folder.path());
    let said = |script: &str, argument: &str| {
        let mut command = Command::new(&python);
        let output = command.arg(file(script)).arg(argument).current_dir(folder.path()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let parquet = said("examples/python/read_run.py", "tables");
    assert_eq!(parquet, said("examples/python/read_run.py", "csv"));
    let is_error = |one: &Observation| one.quantity == "lap.gyro_error";
    for record in run.records().unwrap() {
        let RecordKind::Observation(observation) = record.unwrap().kind else { continue };
        if is_error(&observation) {
            // With one lap each way, the median is the lap's error.
            let way = if observation.tags["direction"] > 0.0 { "ccw" } else { "cw" };
            let line = parquet.lines().find(|line| line.split(' ').next() == Some(way)).unwrap();
            let median: f64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
            assert!((median - observation.value).abs() < 1e-5, "{line}: {}", observation.value);
        }
    }
    assert!(parquet.contains("paper: within +-1.0 deg (Fig. 5)"), "{parquet}");
    let summary = said("examples/python/read_summary.py", "run");
    assert!(summary.starts_with("two-laps seed 1 passed\ngyro_return "), "{summary}");
}
