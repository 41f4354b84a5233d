//! A shell in a folder of its own, as somebody who follows a guide has one.

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

/// Seconds that one command may take, on a machine that others use too.
const COMMAND_S_MAX: &str = "300";
/// How long a command in another terminal may take to say what is shown.
const SAID_WITHIN: Duration = Duration::from_secs(60);

pub struct Session {
    /// Where the guide's files are.
    folder: TempDir,
    /// What goes beside them: programs, what was printed.
    aside: TempDir,
    within: PathBuf,
    path: String,
    others: Vec<(String, Child)>,
    /// Once a command has needed it.
    bus: Option<Vcan0>,
}

impl Session {
    pub fn new() -> Self {
        let (folder, aside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let within = folder.path().to_owned();
        let mut places = Vec::new();
        // A Python environment is known by where its programs are.
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

    /// What the machine lacks for such commands; said aloud.
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

    /// Writes a file of the guide where the shell is.
    pub fn write(&self, path: &str, text: &str) {
        let path = self.within.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// Runs a command; what is not as the guide says.
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

    /// Starts a command that goes on, and waits until it has said what is shown.
    fn run_beside(&mut self, command: &Command) -> Result<(), String> {
        let mut shell = self.shell(&format!("exec {}", command.line));
        let mut child = shell.stdout(Stdio::piped()).spawn().unwrap();
        let output = child.stdout.take().unwrap();
        self.others.push((command.line.clone(), child));
        let (tell, told) = mpsc::channel();
        // It reads until the command ends: who stops reading would stop the command.
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

    /// Ends what goes on in other terminals, by a request to terminate; all of it ends well.
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
        // In a process group of its own, so that what a command started ends with it.
        shell.args(["--kill-after=5", COMMAND_S_MAX, "bash", "-c", script]);
        shell.current_dir(&self.within).env("PATH", &self.path).stdin(Stdio::null());
        shell.env("HOME", self.folder.path()).env("PYTHONDONTWRITEBYTECODE", "1");
        // Rigs of other tests are not to be found.
        shell.env("XDG_RUNTIME_DIR", self.aside.path());
        // As if the wheel were installed.
        let python_path = python_path(&self.aside.path().join("site")).unwrap();
        shell.env("PYTHONPATH", python_path);
        shell.env("HIL_SOURCES", Path::new(env!("CARGO_MANIFEST_DIR")).join("../.."));
        // A guide shows what a terminal shows. pytest prints whole messages in its summary where one of these is set.
        for name in ["CI", "BUILD_NUMBER", "RUST_LOG", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"] {
            shell.env_remove(name);
        }
        shell
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        for (_, child) in &mut self.others {
            // Killed outright, it would leave behind what it started.
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
            let _ = child.wait();
        }
    }
}
