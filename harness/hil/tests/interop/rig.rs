//! A running `hil emulate`, and its client programs.

use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Output, Stdio};

/// If set, a missing Python package is a failure.
const PYTHON_REQUIRED: &str = "HIL_TESTS_NEED_PYTHON";
/// Tests that need a bus of the kernel.
pub const GUEST: &str = "--test interop -- guest_";

/// Path of a file in the repository.
pub fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

fn skip<T>(required: &str, why: &str, how: &str) -> Option<T> {
    skips::skip_unless(required, why, how);
    None
}

/// Returns a Python with the packages for emulated devices.
pub fn python() -> Option<PathBuf> {
    python_with("import can, cantools, serial", "pyserial, python-can and cantools")
}

/// Returns a Python with these packages of `tests/interop/requirements.txt`.
pub fn python_with(imports: &str, packages: &str) -> Option<PathBuf> {
    let python = std::env::var_os("HIL_TESTS_PYTHON").unwrap_or_else(|| "python3".into());
    match Command::new(&python).args(["-c", imports]).output() {
        Ok(output) if output.status.success() => Some(python.into()),
        _ => skip(
            PYTHON_REQUIRED,
            &format!("{} has no {packages}", python.display()),
            "python3 -m venv target/interop && target/interop/bin/pip install -r \
             tests/interop/requirements.txt, then HIL_TESTS_PYTHON=$PWD/target/interop/bin/python",
        ),
    }
}

/// `hil emulate` as a process.
pub struct Emulated {
    child: Child,
    stdin: Option<ChildStdin>,
    stdout: BufReader<ChildStdout>,
    asked: u64,
}

impl Emulated {
    /// Starts it in `folder` and waits until its ports are open; returns its message on the first.
    pub fn start(folder: &Path, arguments: &[&str]) -> (Self, Value) {
        let mut child = Command::new(env!("CARGO_BIN_EXE_hil"))
            .arg("emulate")
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let stdin = child.stdin.take();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        let mut emulated = Self { child, stdin, stdout, asked: 0 };
        let ready = emulated.line();
        assert!(ready["ready"].is_string(), "{ready}");
        (emulated, ready)
    }

    /// Reads the next line of its output.
    pub fn line(&mut self) -> Value {
        let mut line = String::new();
        self.stdout.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line:?}: {error}"))
    }

    /// Sends a request with an added `id`, and returns the answer.
    pub fn ask(&mut self, mut request: Value) -> Value {
        self.asked += 1;
        request["id"] = self.asked.into();
        writeln!(self.stdin.as_mut().unwrap(), "{request}").unwrap();
        let answer = self.line();
        assert_eq!(answer["id"], self.asked, "{answer}");
        answer
    }

    /// Returns the current truth.
    pub fn truth(&mut self) -> Value {
        self.ask(serde_json::json!({ "get": "truth" }))["ok"].take()
    }

    /// Asks it to terminate, and returns the final line of counters.
    pub fn end(mut self) -> Value {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
        let ended = self.line();
        assert_eq!(self.child.wait().unwrap().code(), Some(0));
        ended["ended"].clone()
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // It has ended already, or the test has failed.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Runs a program to its end and returns its standard output.
pub fn said(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", shown(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// Parses the last line of a program's output as JSON.
pub fn told(command: &mut Command) -> Value {
    let said = said(command);
    serde_json::from_str(said.lines().last().unwrap_or_default())
        .unwrap_or_else(|error| panic!("{said:?}: {error}"))
}

/// Returns all output of a program.
pub fn shown(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

/// Returns a JSON number.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}
