//! can-utils as a reference: `log2asc` and `asc2log` on files, `canplayer` and `candump` on a bus.

use super::rows::{read, row, rows, sample, write};
use bus_log::{Channel, Entry, Payload};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;
use wire::time::Timestamp;

/// Runs the program and returns its output; `None`, with a message, if it is not installed.
fn run(program: &str, arguments: &[&str]) -> Option<Vec<u8>> {
    let output = Command::new(program).args(arguments).output();
    match output {
        Ok(output) => Some(output.stdout),
        Err(error) => {
            let why = format!("{program}: {error}");
            skips::skip(why, "it is in can-utils: apt-get install can-utils");
            None
        }
    }
}

/// Shifts times to begin at the first entry: `asc2log` reads dates only in its own locale, else the time of day.
fn from_the_first(entries: &[Entry]) -> Vec<Entry> {
    let first = entries[0].at;
    let since = |entry: &Entry| Entry { at: Timestamp::ZERO + entry.at.since(first), ..*entry };
    entries.iter().map(since).collect()
}

#[test]
fn can_utils_convert_as_it_is_done_here() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let text = |name: &str| path(name).to_str().unwrap().to_owned();
    let entries = sample();
    write(&path("ours.log"), &entries);
    write(&path("ours.asc"), &entries);
    let expected = rows(&from_the_first(&entries));

    let Some(asc) = run("log2asc", &["-I", &text("ours.log"), "can0", "can1"]) else { return };
    std::fs::write(path("theirs.asc"), asc).unwrap();
    assert_eq!(rows(&from_the_first(&read(&path("theirs.asc")))), expected);

    let Some(log) = run("asc2log", &["-I", &text("ours.asc")]) else { return };
    std::fs::write(path("theirs.log"), log).unwrap();
    assert_eq!(rows(&from_the_first(&read(&path("theirs.log")))), expected);
}

#[test]
fn a_log_is_played_onto_a_bus_and_logged_again() {
    let Some(_bus) = skips::Vcan0::take("--test scenarios -- a_log_is_played") else { return };
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("ours.log");
    let vcan0 = Channel::new("vcan0").unwrap();
    // Only receivers that ask for error frames get them; candump has an option for that.
    let mut entries = sample();
    entries.retain(|entry| !matches!(entry.payload, Payload::Error(_)));
    entries.iter_mut().for_each(|entry| entry.channel = vcan0);
    write(&path, &entries);

    let candump = Candump::hearing();
    let log = path.to_str().unwrap();
    let played = Command::new("canplayer").args(["-I", log, "vcan0=vcan0"]).status().unwrap();
    assert!(played.success());
    let heard: Vec<_> = entries.iter().map(|_| candump.line() + "\n").collect();

    std::fs::write(dir.path().join("theirs.log"), heard.concat()).unwrap();
    // The bus carries neither the time of logging nor the direction of a frame.
    let frame = |entry: &Entry| {
        let entry = Entry { at: Timestamp::ZERO, direction: None, ..*entry };
        row(&entry)
    };
    let theirs: Vec<_> = read(&dir.path().join("theirs.log")).iter().map(frame).collect();
    let ours: Vec<_> = entries.iter().map(frame).collect();
    assert_eq!(theirs, ours);
}

/// Longer than anything takes on a loaded machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A candump process and its lines; it ends with the test.
struct Candump {
    child: Child,
    lines: mpsc::Receiver<String>,
}

impl Candump {
    /// Starts a candump that receives from the bus.
    fn hearing() -> Self {
        let mut child =
            Command::new("candump").args(["-L", "vcan0"]).stdout(Stdio::piped()).spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = mpsc::channel();
        std::thread::spawn(move || {
            out.lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        let candump = Self { child, lines };
        candump.knock();
        candump
    }

    /// Waits until candump receives. It does not announce that, so frames are sent until it prints one. A frame of
    /// another kind follows the last of them.
    fn knock(&self) {
        let mut knocks = 0;
        for _ in 0..KNOCKS_MAX {
            send("1ABCDEF0#01");
            knocks += 1;
            if self.lines.recv_timeout(Duration::from_millis(100)).is_ok() {
                break;
            }
        }
        send(LAST_KNOCK);
        let heard = (0..=knocks).any(|_| self.line().ends_with(LAST_KNOCK));
        assert!(heard, "candump never heard the bus");
    }

    fn line(&self) -> String {
        self.lines.recv_timeout(PATIENCE).unwrap()
    }
}

impl Drop for Candump {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const KNOCKS_MAX: u32 = 600;
const LAST_KNOCK: &str = "1ABCDEF1#";

fn send(frame: &str) {
    assert!(Command::new("cansend").args(["vcan0", frame]).status().unwrap().success());
}
