//! A shell in a temporary folder, as a reader of a guide has one.

use crate::compare::compare;
use crate::markdown::{Command, Needs};
use crate::python_package::python_path;
use rustix::process::{Pid, Signal, kill_process};
use skips::Vcan0;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;
use tempfile::TempDir;

/// Time limit of a command in seconds, on a machine with other load.
const COMMAND_S_MAX: &str = "300";
/// Time limit for a command in another terminal to print the shown output.
const SAID_WITHIN: Duration = Duration::from_secs(60);

pub struct Session {
    /// Folder of the guide's files.
    folder: TempDir,
    /// Folder for programs and output.
    aside: TempDir,
    within: PathBuf,
    path: String,
    others: Vec<(String, Child)>,
    /// Taken when a command first needs it.
    bus: Option<Vcan0>,
}

impl Session {
    pub fn new() -> Self {
        let (folder, aside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let within = folder.path().to_owned();
        let mut places = Vec::new();
        // The folder of the interpreter identifies a Python environment.
        if let Some(python) = std::env::var_os("HIL_TESTS_PYTHON") {
            places.push(Path::new(&python).parent().unwrap().to_owned());
        }
        let programs = Path::new(env!("CARGO_BIN_EXE_hil")).parent().unwrap();
        places.push(programs.to_owned());
        let known = std::env::var_os("PATH").unwrap_or_default();
        places.extend(std::env::split_paths(&known));
        let path = std::env::join_paths(places).unwrap().into_string().unwrap();
        Self { folder, aside, within, path, others: Vec::new(), bus: None }
    }

    /// Whether the machine lacks something for such commands; prints what.
    pub fn lacks(&mut self, needs: Needs, guide: &str) -> bool {
        match needs {
            Needs::Nothing | Needs::AnotherTerminal => false,
            Needs::NotRun => true,
            Needs::Can => {
                if self.bus.is_none() {
                    self.bus = Vcan0::take("--test guides");
                }
                self.bus.is_none()
            }
            Needs::Python => {
                let mut probe =
                    self.shell("python3 -c 'import can, cantools, serial, pytest, xdist'");
                let has = probe.stderr(Stdio::null()).status().unwrap().success();
                if !has {
                    let why = format!("python3 lacks packages for a part of {guide}");
                    let how = "tests/interop/README.md says how to set HIL_TESTS_PYTHON";
                    skips::skip_unless("HIL_TESTS_NEED_PYTHON", why, how);
                }
                !has
            }
        }
    }

    /// Writes a file of the guide to the shell's folder.
    pub fn write(&self, path: &str, text: &str) {
        let path = self.within.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// Runs a command; returns the difference from the guide.
    pub fn run(&mut self, needs: Needs, command: &Command) -> Result<(), String> {
        if needs == Needs::AnotherTerminal {
            return self.run_beside(command);
        }
        let (printed, place) = (self.aside.path().join("printed"), self.aside.path().join("pwd"));
        let output = File::create(&printed).unwrap();
        let script =
            format!("{}\nstatus=$?; pwd > '{}'; exit $status", command.line, place.display());
        let mut shell = self.shell(&script);
        shell.stdout(output.try_clone().unwrap()).stderr(output);
        let status = shell.status().unwrap().code();
        let printed = String::from_utf8_lossy(&fs::read(&printed).unwrap()).into_owned();
        if status != Some(command.status) {
            let expected = command.status;
            return Err(format!("exit status {status:?}, expected {expected}\n{printed}"));
        }
        self.within = fs::read_to_string(place).unwrap().trim_end().into();
        compare(&command.shown, &printed)
    }

    /// Starts a command that keeps running, and waits until it has printed the shown output.
    fn run_beside(&mut self, command: &Command) -> Result<(), String> {
        let mut shell = self.shell(&format!("exec {}", command.line));
        let mut child = shell.stdout(Stdio::piped()).spawn().unwrap();
        let output = child.stdout.take().unwrap();
        self.others.push((command.line.clone(), child));
        let (tell, told) = mpsc::channel();
        // Reads until the command ends: a closed pipe would end the command.
        thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                let _ = tell.send(line);
            }
        });
        let mut printed = String::new();
        loop {
            let compared = compare(&command.shown, &printed);
            if compared.is_ok() {
                return Ok(());
            }
            match told.recv_timeout(SAID_WITHIN) {
                Ok(line) => printed += &(line + "\n"),
                Err(_) => return compared,
            }
        }
    }

    /// Ends the commands in other terminals with SIGTERM, and checks their exit.
    pub fn end(&mut self) -> Result<(), String> {
        for (line, mut child) in std::mem::take(&mut self.others) {
            kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
            let status = child.wait().unwrap();
            if !status.success() {
                return Err(format!("$ {line}\nended with {status}"));
            }
        }
        Ok(())
    }

    fn shell(&self, script: &str) -> std::process::Command {
        let mut shell = std::process::Command::new("timeout");
        // In a separate process group, so that processes that a command started end with it.
        shell.args(["--kill-after=5", COMMAND_S_MAX, "bash", "-c", script]);
        shell.current_dir(&self.within).env("PATH", &self.path).stdin(Stdio::null());
        shell.env("HOME", self.folder.path()).env("PYTHONDONTWRITEBYTECODE", "1");
        // Hides rigs of other tests.
        shell.env("XDG_RUNTIME_DIR", self.aside.path());
        // As if the wheel were installed.
        let python_path = python_path(&self.aside.path().join("site")).unwrap();
        shell.env("PYTHONPATH", python_path);
        shell.env("HIL_SOURCES", Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
        // A guide shows the output on a terminal. With one of these set, pytest prints whole messages in its summary.
        for name in ["CI", "BUILD_NUMBER", "RUST_LOG", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"] {
            shell.env_remove(name);
        }
        shell
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        for (_, child) in &mut self.others {
            // A killed shell would leave behind the processes that it started.
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
            let _ = child.wait();
        }
    }
}
