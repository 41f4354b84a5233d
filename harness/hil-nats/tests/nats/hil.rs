//! Runs the binary as separate processes, each with its standard error in a file that can be watched.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Longer than anything here takes on a slow machine.
pub const PATIENCE: Duration = Duration::from_secs(120);
const STEP: Duration = Duration::from_millis(10);

#[expect(clippy::disallowed_methods, reason = "waits for another process")]
#[track_caller]
pub fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let mut waited = Duration::ZERO;
    while !done() {
        assert!(waited < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(STEP);
        waited += STEP;
    }
}

/// A folder in which processes run.
pub struct Hil {
    folder: TempDir,
}

/// A running process.
pub struct Running {
    child: Child,
    out: PathBuf,
    err: PathBuf,
}

/// Result of a process.
#[derive(Debug)]
pub struct Ran {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Hil {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// Creates a folder with files of an example, with these replacements.
    pub fn with_example(name: &str, files: &[(&str, &str, &str)]) -> Self {
        let hil = Self::new();
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples").join(name);
        for (file, before, after) in files {
            let text = std::fs::read_to_string(from.join(file)).unwrap();
            assert!(text.contains(before), "{file}: {before}");
            let to = hil.path(file);
            std::fs::create_dir_all(to.parent().unwrap()).unwrap();
            std::fs::write(to, text.replace(before, after)).unwrap();
        }
        hil
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Starts `hil` with these arguments; `name` is the name of its output files.
    pub fn start(&self, name: &str, arguments: &[&str]) -> Running {
        let (out, err) = (self.path(format!("{name}.out")), self.path(format!("{name}.err")));
        let file = |path: &Path| Stdio::from(std::fs::File::create(path).unwrap());
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil-nats"));
        command.args(arguments).current_dir(self.folder.path()).env_remove("RUST_LOG");
        let child = command.stdin(Stdio::null()).stdout(file(&out)).stderr(file(&err)).spawn();
        Running { child: child.unwrap(), out, err }
    }

    /// Starts a worker that waits for cases.
    pub fn worker(&self, name: &str, url: &str) -> Running {
        self.start(name, &["worker", "--nats", url, "--threads", "1"])
    }

    /// Returns the lines of a campaign's journal so far: its head and one per case.
    pub fn journal(&self, campaign: &str) -> Vec<Value> {
        let text = std::fs::read_to_string(self.path(campaign).join("cases.jsonl"));
        let text = text.unwrap_or_default();
        let whole = text.split_inclusive('\n').filter(|line| line.ends_with('\n'));
        whole.map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    #[track_caller]
    pub fn wait_for_cases(&self, campaign: &str, count: usize) {
        wait_for("cases in the journal", || self.journal(campaign).len() > count);
    }
}

impl Running {
    pub fn err(&self) -> String {
        std::fs::read_to_string(&self.err).unwrap()
    }

    #[track_caller]
    pub fn wait_until_it_says(&self, text: &str) {
        wait_for(text, || self.err().contains(text));
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    pub fn kill(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub fn interrupt(&self) {
        kill_process(Pid::from_child(&self.child), Signal::INT).unwrap();
    }

    /// Waits until it ends by itself.
    #[track_caller]
    pub fn ends(mut self) -> Ran {
        let mut status = None;
        wait_for("its end", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        let out = std::fs::read_to_string(&self.out).unwrap();
        Ran { status: status.unwrap().code(), out, err: self.err() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Ran {
    #[track_caller]
    pub fn exits(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:#?}");
        self
    }

    /// Returns its messages, without line breaks.
    pub fn says(&self) -> String {
        self.err.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
    }

    /// Returns the campaign that it printed as JSON, without parts specific to this folder and attempt.
    pub fn campaign(&self) -> Value {
        let mut value: Value = serde_json::from_str(&self.out).unwrap();
        for found in value["found"].as_array_mut().unwrap() {
            found.as_object_mut().unwrap().remove("plan");
        }
        value.as_object_mut().unwrap().remove("resumed");
        value
    }
}

/// Returns results by number, and checks that each case appears once.
#[track_caller]
pub fn cases(journal: &[Value]) -> BTreeMap<u64, &Value> {
    let mut cases = BTreeMap::new();
    for line in &journal[1..] {
        let number = line["number"].as_u64().unwrap();
        assert!(cases.insert(number, line).is_none(), "case {number} is counted twice");
    }
    cases
}
