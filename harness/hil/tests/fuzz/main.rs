//! Almost valid input for every command that reads a file: no panic, no hang, only exit statuses that the help names,
//! no files written outside the folder, no control sequences to the terminal.
//!
//! | variable | meaning |
//! |---|---|
//! | `HIL_FUZZ_CASES` | number of inputs; default 500 |
//! | `HIL_FUZZ_SECONDS` | run for this long instead |
//! | `HIL_FUZZ_SEED` | seed of the inputs; default 1 |
//! | `HIL_FUZZ_CASE` | only this input |
//! | `HIL_FUZZ_COMMAND` | only scenes whose command line contains this text |
//! | `HIL_FUZZ_PROGRAM` | another build of `hil` than the test's |
//!
//! A failing input is shrunk and kept in a folder that the message names.

#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod child;
mod mutate;
mod random;
mod room;
mod scenes;
mod seeds;
mod shrink;
mod statuses;

use child::defect;
use mutate::{Words, mutated};
use random::Random;
use room::Room;
use scenes::Scene;
use seeds::Seeds;
use shrink::shrunk;
use statuses::Statuses;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Takes half a minute on two processors.
const CASES: u64 = 500;

/// The scenes, and the defects found.
struct Hunt {
    seed: u64,
    scenes: Vec<Scene>,
    words: Words,
    statuses: Statuses,
    next: AtomicU64,
    end: End,
    /// Defects by name, each with the message on its first case.
    found: Mutex<BTreeMap<String, String>>,
    /// Where failing input is kept.
    kept: PathBuf,
}

enum End {
    Case(u64),
    At(Instant),
}

#[test]
fn no_input_breaks_a_command() {
    let variable = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let seed = variable("HIL_FUZZ_SEED").unwrap_or(1);
    let only = variable("HIL_FUZZ_CASE");
    let seeds = Seeds::make();
    let words = Words::of(seeds.files().map(|(_, file)| file));
    let mut scenes = scenes::all(&seeds);
    if let Ok(part) = std::env::var("HIL_FUZZ_COMMAND") {
        scenes.retain(|scene| scene.arguments.join(" ").contains(&part));
    }
    let statuses = Statuses::of(scenes.iter().map(Scene::command));
    let end = match (only, variable("HIL_FUZZ_SECONDS")) {
        (Some(case), _) => End::Case(case + 1),
        (None, Some(seconds)) => End::At(now() + Duration::from_secs(seconds)),
        (None, None) => End::Case(variable("HIL_FUZZ_CASES").unwrap_or(CASES)),
    };
    let next = AtomicU64::new(only.unwrap_or(0));
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    let hunt = Hunt { seed, scenes, words, statuses, next, end, found: Mutex::default(), kept };

    // Valid input first: if it were refused, its mutations would test nothing.
    let rooms = tempfile::tempdir().unwrap();
    let room = Room::new(rooms.path().join("good"));
    for scene in &hunt.scenes {
        let line = scene.arguments.join(" ");
        assert_eq!(hunt.defect(&room, scene), None, "{line}");
        let said = room.said("err");
        assert!(!said.starts_with("  x "), "{line}: {said}");
    }
    let workers = std::thread::available_parallelism().map_or(2, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for worker in 0..workers {
            let room = Room::new(rooms.path().join(worker.to_string()));
            let hunt = &hunt;
            scope.spawn(move || hunt.go(&room));
        }
    });
    let count = hunt.next.load(Ordering::Relaxed).saturating_sub(workers as u64);
    println!("seed {seed}: {count} inputs");
    let found = hunt.found.into_inner().unwrap();
    let told: Vec<&str> = found.values().map(String::as_str).collect();
    assert!(told.is_empty(), "seed {seed}: {} defects\n{}", told.len(), told.join("\n"));
}

/// Path of the tested binary.
fn program() -> PathBuf {
    std::env::var_os("HIL_FUZZ_PROGRAM").map_or(env!("CARGO_BIN_EXE_hil").into(), PathBuf::from)
}

#[expect(clippy::disallowed_methods, reason = "somebody has so much time")]
fn now() -> Instant {
    Instant::now()
}

impl Hunt {
    fn go(&self, room: &Room) {
        loop {
            let case = self.next.fetch_add(1, Ordering::Relaxed);
            match self.end {
                End::Case(end) if case >= end => return,
                End::At(end) if now() >= end => return,
                _ => {}
            }
            let (scene, input) = self.case(case);
            if let Some(defect) = self.defect(room, &scene) {
                self.keep(room, case, scene, &input, &defect);
            }
        }
    }

    /// Returns a scene with a mutated file, and the file's name.
    fn case(&self, case: u64) -> (Scene, String) {
        let mut random = Random::of(self.seed, case);
        let mut place = random.below(self.scenes.iter().map(|scene| scene.weight).sum());
        let scene = self.scenes.iter().find(|scene| {
            let is_here = place < scene.weight;
            place = place.wrapping_sub(scene.weight);
            is_here
        });
        let mut scene = scene.unwrap().clone();
        let input = scene.inputs[random.below(scene.inputs.len())].clone();
        let file = scene.files.get_mut(&input).unwrap();
        *file = mutated(&mut random, &input, file, &self.words);
        (scene, input)
    }

    fn defect(&self, room: &Room, scene: &Scene) -> Option<String> {
        room.furnish(&scene.files);
        defect(room, scene, self.statuses.of_command(scene.command()))
    }

    /// Shrinks and keeps the first case of each defect.
    fn keep(&self, room: &Room, case: u64, mut scene: Scene, input: &str, what: &str) {
        let line = scene.arguments.join(" ");
        let known =
            if what.starts_with("panicked") { what.to_owned() } else { format!("{line}: {what}") };
        if self.found.lock().unwrap().contains_key(&known) {
            return;
        }
        self.found.lock().unwrap().insert(known.clone(), known.clone());
        // A slow case would be slow in each attempt.
        let is_slow = what.contains("processor time") || what.contains("within");
        let whole = scene.files[input].clone();
        if !is_slow {
            let least = shrunk(&whole, |less| {
                scene.files.insert(input.to_owned(), less.to_vec());
                self.defect(room, &scene).as_deref() == Some(what)
            });
            scene.files.insert(input.to_owned(), least);
        }
        let folder = Room::new(self.kept.join(format!("{}-{case}", self.seed)));
        folder.furnish(&scene.files);
        std::fs::write(folder.path("whole"), whole).unwrap();
        let stdin = scene.stdin.as_ref().map_or_else(String::new, |name| format!(" < {name}"));
        let told = format!(
            "{known}\n  by {input}: (cd {} && hil {line}{stdin})\n  again: HIL_FUZZ_SEED={} HIL_FUZZ_CASE={case}",
            folder.work().display(),
            self.seed
        );
        // Started by hand it runs for hours: prints at once what it found.
        eprintln!("{told}");
        self.found.lock().unwrap().insert(known, told);
    }
}
