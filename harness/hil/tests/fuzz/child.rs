//! Runs one command on one input, with limits, and detects defects.

use crate::room::Room;
use crate::scenes::{End, Scene};
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process_group, prlimit};
use std::fs::{self, File};
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Limit of processor time, which does not depend on the load of the machine.
const PROCESSOR_S_MAX: u64 = 10;

/// Limit of wall time, for a command that waits for something that never happens.
const WALL_MAX: Duration = Duration::from_secs(120);

/// The work of a plan may take for ever; after this time the command is asked to end.
const PATIENCE_S: f64 = 1.0;

const MEMORY_BYTES_MAX: u64 = 2 << 30;
const FILE_BYTES_MAX: u64 = 256 << 20;

/// A defect, with the same text for the same defect.
pub type Defect = String;

/// Runs the scene in the room; returns its defect, if any.
pub fn defect(room: &Room, scene: &Scene, statuses: &[i32]) -> Option<Defect> {
    let (status, asked) = match ended(room, scene) {
        Ok(ended) => ended,
        Err(defect) => return Some(defect),
    };
    let (out, err) = (room.said("out"), room.said("err"));
    if let Some(at) = err.lines().find(|line| line.contains("panicked at ")) {
        let place = at.split("panicked at ").nth(1).unwrap_or_default();
        return Some(format!("panicked at {place}"));
    }
    match (status.code(), status.signal()) {
        // A command that is asked before it has installed its handler ends at once.
        (None, Some(15)) if asked && matches!(scene.end, End::After(_)) => {}
        (None, Some(24)) => return Some(format!("ran for {PROCESSOR_S_MAX} s of processor time")),
        (None, Some(25)) => return Some(format!("wrote more than {FILE_BYTES_MAX} bytes")),
        (None, signal) => {
            let last = err.lines().last().unwrap_or_default();
            return Some(format!("killed by signal {}: {last}", signal.unwrap_or_default()));
        }
        (Some(code), _) if !statuses.contains(&code) => {
            return Some(format!("undocumented exit status {code}"));
        }
        (Some(2), _) if err.trim().is_empty() => return Some("refused without a word".to_owned()),
        _ => {}
    }
    if scene.arguments.iter().any(|argument| argument == "--json")
        && !out.is_empty()
        && serde_json::from_str::<serde_json::Value>(&out).is_err()
    {
        return Some("said something else than JSON".to_owned());
    }
    if let Some(wild) = [&out, &err].into_iter().find_map(|said| wild(said)) {
        return Some(format!("a terminal hears {wild:?}"));
    }
    room.trespass(scene)
}

/// Returns a control character other than a line end, a tab or part of a colour.
fn wild(said: &str) -> Option<char> {
    let mut rest = said;
    while let Some(at) = rest.find(|c: char| c.is_control() && !matches!(c, '\n' | '\t')) {
        let found = rest[at..].chars().next()?;
        let behind = rest[at..].strip_prefix("\u{1b}[")?;
        let end = behind.find(|c: char| !c.is_ascii_digit() && c != ';').unwrap_or(behind.len());
        if !behind[end..].starts_with('m') {
            return Some(found);
        }
        rest = &behind[end..];
    }
    None
}

/// Returns how it ended, and whether it was asked to.
fn ended(room: &Room, scene: &Scene) -> Result<(ExitStatus, bool), Defect> {
    let stdin = scene.stdin.as_ref().and_then(|name| File::open(room.work().join(name)).ok());
    let file = |name| File::create(room.path(name)).unwrap();
    let mut command = Command::new(crate::program());
    command.args(&scene.arguments).current_dir(room.work()).process_group(0);
    command.stdin(stdin.map_or_else(Stdio::null, Stdio::from));
    command.stdout(file("out")).stderr(file("err"));
    command.env_clear().env("PATH", std::env::var_os("PATH").unwrap_or_default());
    command.env("HOME", room.path("home")).env("TMPDIR", room.path("tmp"));
    command.env("XDG_RUNTIME_DIR", room.path("runtime"));
    let mut child = command.spawn().unwrap();
    let pid = Pid::from_child(&child);
    let limit = |most: u64| Rlimit { current: Some(most), maximum: Some(most) };
    for (resource, most) in
        [(Resource::As, MEMORY_BYTES_MAX), (Resource::Fsize, FILE_BYTES_MAX), (Resource::Core, 0)]
    {
        // The process may have ended.
        let _ = prlimit(Some(pid), resource, limit(most));
    }
    // The soft limit signals, the hard limit kills.
    let cpu = Rlimit { current: Some(PROCESSOR_S_MAX), maximum: Some(PROCESSOR_S_MAX + 2) };
    let _ = prlimit(Some(pid), Resource::Cpu, cpu);
    let ended = wait(&mut child, pid, &scene.end);
    // Also ends the programs that it started.
    let _ = kill_process_group(pid, Signal::KILL);
    ended
}

#[expect(clippy::disallowed_methods, reason = "waits for another process")]
fn wait(child: &mut Child, pid: Pid, end: &End) -> Result<(ExitStatus, bool), Defect> {
    let began = Instant::now();
    let mut asked = false;
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return Ok((status, asked));
        }
        let waited = began.elapsed();
        if waited > WALL_MAX {
            let _ = kill_process_group(pid, Signal::KILL);
            let _ = child.wait();
            return Err(format!("did not end within {} s", WALL_MAX.as_secs()));
        }
        let is_due = match end {
            End::ByItself => false,
            End::Asked => waited.as_millis() > 200 && processor_s(pid) > PATIENCE_S,
            End::After(span) => waited > *span,
        };
        if is_due && !asked {
            let _ = rustix::process::kill_process(pid, Signal::TERM);
            asked = true;
        }
        let is_young = waited.as_millis() < 50;
        std::thread::sleep(Duration::from_millis(if is_young { 1 } else { 10 }));
    }
}

/// Returns the processor time used by the process.
fn processor_s(pid: Pid) -> f64 {
    let path = format!("/proc/{}/stat", pid.as_raw_nonzero());
    let stat = fs::read_to_string(path).unwrap_or_default();
    // After the name, which may contain anything, the 12th and 13th fields are ticks of 10 ms.
    let behind = stat.rsplit(')').next().unwrap_or_default();
    let ticks = behind.split_whitespace().skip(11).take(2);
    ticks.filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / 100.0
}
