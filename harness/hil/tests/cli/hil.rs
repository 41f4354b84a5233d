//! Runs the binary in a temporary folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// Half a year of bench time: no run ends before it is killed.
pub const ENDLESS: &str = r#"
name = "endless"
title = "No end"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { turn = { angle_deg = 90 } },
    { repeat = { times = 2000, steps = [{ wait = { duration_s = 7200 } }] } },
]

[[measurement]]
name = "stop_error"
doc = "Turned minus commanded angle"
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-5, 5] }
"#;

/// A plan that takes 24 s of bench time and passes.
pub const TURN: &str = r#"
name = "turn"
title = "One turn"
devices = "paper"
steps = [
    { bias_test = { duration_s = 5 } },
    { turn = { angle_deg = 90 } },
]

[[measurement]]
name = "stop_error"
doc = "Turned minus commanded angle"
quantity = "turn.stop_error"
unit = "deg"
check = { all_within = [-5, 5] }
paper = "none"
"#;

/// A temporary folder in which the binary runs.
pub struct Hil {
    dir: TempDir,
}

impl Hil {
    pub fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    /// Creates the folder with a plan in `turn.toml`.
    pub fn with_plan(text: &str) -> Self {
        let hil = Self::new();
        fs::write(hil.path("turn.toml"), text).unwrap();
        hil
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.dir.path().join(name)
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command.args(arguments).current_dir(self.dir.path()).stdin(Stdio::null());
        for name in ["RUST_LOG", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"] {
            command.env_remove(name);
        }
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).output().unwrap())
    }

    pub fn outcome(&self, run: &str) -> String {
        let summary = fs::read(self.path(run).join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        summary["outcome"].as_str().unwrap().to_owned()
    }
}

/// Result of a process.
#[derive(Debug)]
pub struct Ran {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Ran {
    pub fn of(output: Output) -> Self {
        Self {
            status: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    #[track_caller]
    pub fn exits(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:#?}");
        self
    }
}
