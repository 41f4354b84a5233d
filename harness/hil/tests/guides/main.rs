//! Runs every command of the guides (`docs/guides`) as it stands, in the order of the page, in a real shell in a
//! temporary folder, and compares its output with that on the page.
//!
//! Contents of a page, by the first line of a fenced block:
//!
//! | block | action |
//! |---|---|
//! | `console` | runs each `$ command`; the lines below it are its output, with stderr; no lines accept any output |
//! | `console another-terminal` | a command that runs until the page ends; it must first print the lines below it |
//! | `console needs-can` | run if there is a `vcan0`, as under `tests/vcan-guest/run` |
//! | `console needs-python` | run if the packages of `tests/interop/requirements.txt` are installed |
//! | `console not-run` | not run, for lack of hardware or time; `what_is_not_run_is_known` lists it |
//! | `toml FILE`, `python FILE` | the file is written as it stands; without a name it is a fragment |
//! | `rust`, `text` | ignored |
//!
//! * `# exit status N` after a command: its expected exit status; default 0.
//! * A line `...` stands for any number of lines, `...` within a line for anything.
//! * `HIL_SOURCES` is the path of this repository.
//! * Figures that differ from machine to machine count as equal: `compare::CHANGING`.
//! * Code within a sentence that begins with `hil ` must be the beginning of a command that the page runs.
//!
//! Any other block fails the test: untested text soon becomes wrong.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod compare;
mod markdown;
#[path = "../interop/python_package.rs"]
mod python_package;
mod session;
mod wrong;

use markdown::{Block, Guide, Needs};
use session::Session;
use std::path::{Path, PathBuf};

fn guides() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides")
}

fn guide(name: &str) -> Guide {
    let path = guides().join(format!("{name}.md"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    Guide::read(name, &text).unwrap_or_else(|wrong| panic!("{wrong}"))
}

/// Runs a guide from top to end; an error names its location.
fn followed(guide: &Guide) -> Result<(), String> {
    let mut session = Session::new();
    // The guest with a CAN kernel is slow. Runs that need no bus were followed outside of it.
    let only_can = std::env::var_os("HIL_TESTS_ONLY_CAN").is_some();
    let needs_no_bus = |needs: Needs, line: &str| {
        needs != Needs::Can && (line.starts_with("hil run ") || line.starts_with("hil campaign "))
    };
    for block in &guide.blocks {
        match block {
            Block::File { path, text } => session.write(path, text),
            Block::Commands { needs, commands } => {
                if session.lacks(*needs, &guide.name) {
                    continue;
                }
                for command in commands {
                    if only_can && needs_no_bus(*needs, &command.line) {
                        continue;
                    }
                    let at = format!("{}:{}: $ {}", guide.name, command.at, command.line);
                    session.run(*needs, command).map_err(|wrong| format!("{at}\n{wrong}"))?;
                }
            }
        }
    }
    session.end()
}

fn follow(name: &str) {
    if let Err(wrong) = followed(&guide(name)) {
        panic!("{wrong}");
    }
}

/// For a guide that waits for real time.
fn follow_in_time(name: &'static str) {
    skips::in_time(|| follow(name));
}

/// One test per guide: they run in parallel, and a failure names the guide.
macro_rules! guides {
    ($($test:ident: $follow:ident $name:literal,)*) => {
        /// Guides that have a test.
        const FOLLOWED: &[&str] = &[$($name),*];
        $(#[test]
        fn $test() {
            $follow($name);
        })*
    };
}

guides! {
    first_run: follow "first-run",
    your_controller: follow_in_time "your-controller",
    first_bench: follow_in_time "first-bench",
    writing_a_plan: follow "writing-a-plan",
    reading_a_verdict: follow "reading-a-verdict",
    emulating_a_device: follow_in_time "emulating-a-device",
    closing_the_loop: follow "closing-the-loop",
    campaigns: follow "campaigns",
    a_thousand_times: follow "a-thousand-times",
    tests_of_your_own: follow "tests-of-your-own",
    from_python: follow_in_time "from-python",
}

#[test]
fn every_guide_is_followed_and_none_is_long() {
    const LINES_MAX: usize = 130;
    let index = std::fs::read_to_string(guides().join("README.md")).unwrap();
    for entry in std::fs::read_dir(guides()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        if name == "README" {
            continue;
        }
        assert!(FOLLOWED.contains(&name), "{name} is followed by no test");
        assert!(index.contains(&format!("({name}.md)")), "{name} is not in the index");
        let lines = std::fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= LINES_MAX, "{name} has {lines} lines, expected at most {LINES_MAX}");
    }
}

#[test]
fn what_is_not_run_is_known() {
    let mut not_run = String::new();
    for name in FOLLOWED {
        for block in &guide(name).blocks {
            if let Block::Commands { needs: Needs::NotRun, commands } = block {
                for command in commands {
                    not_run += &format!("{name}: {}\n", command.line);
                }
            }
        }
    }
    insta::assert_snapshot!(not_run);
}
