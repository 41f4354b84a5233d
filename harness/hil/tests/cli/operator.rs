//! Questions of a plan to a person: at a real terminal, from a file, and with no one to answer.
#![cfg(unix)]

use crate::hil::{Hil, Ran};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::process::{Child, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(60);

const GAP: &str = r#"
name = "gap"
title = "Something to do, and something to read off"
devices = "paper-table"
steps = [
    { operator_prompt = { text = "Put the table on the floor" } },
    { operator_prompt = { text = "How wide is the gap?", answer = { name = "gap", unit = "mm", range = [-2, 2] } } },
]

[[measurement]]
name = "gap"
doc = "The gap"
quantity = "operator.gap"
unit = "mm"
check = { all_within = [1, 2] }
"#;

const LIVE: [&str; 8] =
    ["run", "gap.toml", "--clock", "real", "--controller", "in-process", "--out", "out"];

fn hil() -> Hil {
    let hil = Hil::new();
    fs::write(hil.path("gap.toml"), GAP).unwrap();
    hil
}

/// The binary at a pty, and its output so far.
struct Conversation {
    child: Child,
    keyboard: File,
    shown: String,
    screen: Receiver<Vec<u8>>,
}

impl Conversation {
    fn begin(hil: &Hil, arguments: &[&str]) -> Self {
        let keyboard = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&keyboard).unwrap();
        unlockpt(&keyboard).unwrap();
        let path = ptsname(&keyboard, Vec::new()).unwrap();
        let flags = OFlags::RDWR | OFlags::NOCTTY;
        let terminal = File::from(rustix::fs::open(path, flags, Mode::empty()).unwrap());
        let mut command = hil.command(arguments);
        let stdio = || Stdio::from(terminal.try_clone().unwrap());
        let child = command.stdin(stdio()).stderr(stdio()).stdout(Stdio::piped()).spawn().unwrap();
        let keyboard = File::from(keyboard);
        let mut output = keyboard.try_clone().unwrap();
        let (sender, screen) = channel();
        thread::spawn(move || {
            let mut buffer = [0; 4_096];
            // The terminal hangs up with an error once the binary has ended.
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { child, keyboard, shown: String::new(), screen }
    }

    /// Waits until `text` is on the screen, and drops everything up to it.
    #[track_caller]
    fn sees(&mut self, text: &str) {
        loop {
            if let Some(at) = self.shown.find(text) {
                self.shown.drain(..at + text.len());
                return;
            }
            match self.screen.recv_timeout(PATIENCE) {
                Ok(bytes) => self.shown += &String::from_utf8_lossy(&bytes),
                Err(_) => panic!("waited in vain for {text:?}, saw {:?}", self.shown),
            }
        }
    }

    fn types(&mut self, text: &str) {
        self.keyboard.write_all(text.as_bytes()).unwrap();
    }

    fn ends(self) -> Ran {
        Ran::of(self.child.wait_with_output().unwrap())
    }
}

#[test]
fn a_conversation_at_a_terminal() {
    let hil = hil();
    let mut person = Conversation::begin(&hil, &[&LIVE[..], &["--operator", "Jane Doe"]].concat());
    person.sees("Put the table on the floor");
    person.sees("press Enter when it is done");
    person.types("\n");
    person.sees("How wide is the gap?");
    person.sees("gap: a number in mm, -2 to 2");
    person.sees("> ");
    for (typed, said) in [
        ("1.5\n", "no unit, expected a number in mm such as \"1.5 mm\""),
        ("1,5 mm\n", "a comma in \"1,5 mm\""),
        ("3 mm\n", "3 mm is out of range, expected -2 to 2 mm (2 tries left)"),
    ] {
        person.types(typed);
        person.sees(said);
        person.sees("> ");
    }
    person.types("0.15 cm\n");
    let ran = person.ends().exits(0);
    assert!(ran.out.contains("1.5 mm"), "{}", ran.out);
    assert_eq!(hil.outcome("out"), "passed");
    let shown = hil.run(&["show", "out"]).exits(0);
    assert!(shown.out.contains("reply gap = 1.5 mm by Jane Doe at the terminal, unix time "));
    assert!(shown.out.contains("reply done by Jane Doe at the terminal"), "{}", shown.out);
}

#[test]
fn a_person_who_never_says_a_number_ends_the_run() {
    let hil = hil();
    let mut person = Conversation::begin(&hil, &LIVE);
    person.sees("press Enter");
    person.types("\n");
    person.sees("gap: a number");
    for _ in 0..5 {
        person.sees("> ");
        person.types("wide\n");
    }
    let ran = person.ends().exits(3);
    assert!(ran.out.contains("no usable answer \"gap\" in 5 tries"), "{}", ran.out);
}

#[test]
fn a_terminal_that_is_closed_ends_the_run() {
    let hil = hil();
    let mut person = Conversation::begin(&hil, &LIVE);
    person.sees("> ");
    // Ctrl-D on an empty line ends the input.
    person.types("\u{4}");
    let ran = person.ends().exits(3);
    assert!(ran.out.contains("the terminal was closed before"), "{}", ran.out);
}

#[test]
fn a_file_answers_where_nobody_is() {
    let hil = hil();
    fs::write(hil.path("bench.toml"), "[answers]\nfile = \"read-off.toml\"\n").unwrap();
    let answers = "by = \"Jane Doe\"\ndone = true\n[answers]\ngap = \"1.5 mm\"\n";
    fs::write(hil.path("read-off.toml"), answers).unwrap();
    for file in [["--answers", "read-off.toml"], ["--bench", "bench.toml"]] {
        hil.run(&[&LIVE[..], &file].concat()).exits(0);
        let shown = hil.run(&["show", "out"]).exits(0);
        assert!(shown.out.contains("reply gap = 1.5 mm by Jane Doe in a file"), "{}", shown.out);
        assert!(shown.out.contains("reply done by Jane Doe in a file"), "{}", shown.out);
    }
    // Also in virtual time, with the same bytes each time.
    let record = || {
        hil.run(&["run", "gap.toml", "--answers", "read-off.toml", "--out", "virtual"]).exits(0);
        fs::read(hil.path("virtual/record.hilrec")).unwrap()
    };
    assert_eq!(record(), record());
}

#[test]
fn with_nobody_there_all_that_is_missing_is_said_before_the_run() {
    let hil = hil();
    let ran = hil.run(&LIVE).exits(2);
    for said in [
        "1 answer is missing and 1 thing has to be done",
        "Put the table on the floor",
        "gap = \"... mm\"",
    ] {
        assert!(ran.err.contains(said), "{said}: {}", ran.err);
    }
    assert!(!hil.path("out").exists());
}
