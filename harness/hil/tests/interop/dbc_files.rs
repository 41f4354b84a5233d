//! DBC files as they come: of those of your own folder (`HIL_TESTS_DBC_FILES`), a project for each node, and one for
//! all but each, passes at once. `described/tests/dbc_files.rs` compares their frames with cantools.

use described::{Dbc, dbc_text};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs `hil` in a folder; returns its output if it failed.
fn hil(folder: &Path, arguments: &[&str]) -> Result<(), String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    let said = || String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    if output.status.success() { Ok(()) } else { Err(format!("{arguments:?}: {}", said())) }
}

#[test]
fn a_project_of_any_dbc_runs_green_at_once() {
    let Some(folder) = std::env::var_os("HIL_TESTS_DBC_FILES").map(PathBuf::from) else {
        skips::skip("no folder of DBC files", "HIL_TESTS_DBC_FILES names one");
        return;
    };
    let mut files: Vec<PathBuf> = Vec::new();
    let mut folders = vec![folder];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => folders.push(path),
                false if path.extension().is_some_and(|kind| kind == "dbc") => files.push(path),
                false => {}
            }
        }
    }
    files.sort();
    let room = tempfile::tempdir().unwrap();
    let (mut counts, mut failed) = (BTreeMap::<_, usize>::new(), Vec::new());
    for (number, path) in files.iter().enumerate() {
        let shown = path.display().to_string();
        let bytes = std::fs::read(path).unwrap();
        let mut nodes = Dbc::parse(&shown, &dbc_text(&bytes)).unwrap().nodes().to_vec();
        nodes.retain(|node| node.messages > 0);
        *counts.entry("files").or_default() += 1;
        if nodes.is_empty() {
            *counts.entry("files without a message").or_default() += 1;
        }
        for (which, node) in nodes.iter().enumerate() {
            let mut made = |kind: &str, option: &str, plan: &str| {
                let name = format!("{kind}-{number}-{which}");
                let new = ["new", &name, "--dbc", &shown, option, &node.name];
                let run = || hil(&room.path().join(&name), &["run", plan, "--out", "run"]);
                if let Err(why) = hil(room.path(), &new).and_then(|()| run()) {
                    failed.push(format!("{shown}, {option} {}: {why}", node.name));
                }
            };
            made("node", "--node", "talks.toml");
            *counts.entry("projects of a node").or_default() += 1;
            if nodes.len() > 1 {
                made("rest", "--except", "rest.toml");
                *counts.entry("rigs of all nodes but one").or_default() += 1;
            }
        }
    }
    println!("{counts:#?}");
    assert!(failed.is_empty(), "{} failed:\n{}", failed.len(), failed.join("\n"));
    assert!(counts.contains_key("projects of a node"));
}
