//! `examples/pytest`, as somebody's pytest runs it.

use super::rig::{file, python_with, shown};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A Python that has pytest, and talks to emulated devices.
fn python_of_pytest() -> Option<PathBuf> {
    python_with("import can, cantools, pytest, serial", "pytest, pyserial, python-can and cantools")
}

/// Runs the tests in `folder`.
fn pytest(python: &Path, folder: &Path, runs: &Path) -> Output {
    let junit = runs.join("pytest.xml");
    Command::new(python)
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--junitxml"])
        .arg(junit)
        .current_dir(folder)
        .env("HIL", env!("CARGO_BIN_EXE_hil"))
        .env("HIL_RUNS", runs)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

#[test]
fn pytest_runs_plans_and_talks_to_an_emulated_device() {
    let Some(python) = python_of_pytest() else { return };
    let runs = tempfile::tempdir().unwrap();
    let output = pytest(&python, &file("examples/pytest"), runs.path());
    assert!(output.status.success(), "{}", shown(&output));
    assert!(shown(&output).contains("8 passed"), "{}", shown(&output));

    let all = runs.path().join("all.xml");
    let ours = runs.path().join("settles/junit.xml");
    let mut merge = Command::new(&python);
    merge.arg(file("examples/pytest/merge_junit.py")).arg(&all);
    let merged = merge.arg(runs.path().join("pytest.xml")).arg(ours).output().unwrap();
    assert!(merged.status.success(), "{}", shown(&merged));
    let all = fs::read_to_string(all).unwrap();
    for case in ["test_measurement[temperature_held]", "name=\"temperature_held\""] {
        assert!(all.contains(case), "no {case} in {all}");
    }
}

#[test]
fn a_measurement_out_of_its_band_fails_its_case_and_no_other() {
    let Some(python) = python_of_pytest() else { return };
    let folder = tempfile::tempdir().unwrap();
    let project = folder.path().join("project");
    copy(&file("examples/pytest"), &project);
    fs::remove_file(project.join("test_device.py")).unwrap();
    let plan = project.join("plans/settles.toml");
    let text = fs::read_to_string(&plan).unwrap();
    assert!(text.contains("at_most = 150"), "{text}");
    fs::write(&plan, text.replace("at_most = 150", "at_most = 15")).unwrap();
    let output = pytest(&python, &project, folder.path());
    assert_eq!(output.status.code(), Some(1), "{}", shown(&output));
    let shown = shown(&output);
    assert!(shown.contains("FAILED test_plans.py::test_measurement[time_to_heat]"), "{shown}");
    assert!(!shown.contains("FAILED test_plans.py::test_measurement[temperature_held]"), "{shown}");
}
