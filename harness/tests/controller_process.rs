//! `k2a-controller` as a process in virtual time does the same as the controller in the process: the record is the same,
//! byte for byte.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![cfg(feature = "programs")]

use harness::run::{Options, Prepared, run_to_folder};
use plan::library::{Kind, Library, names};
use plan::made::Made;
use record::run_folder::RunFolder;
use record::sink::Level;
use rig::hosted::{ControllerProgram, Hosting};
use rig::operator::Answers;
use std::num::NonZero;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// `k2a-controller` is beside this test's program; a test of the whole workspace has built it already.
fn build_controller() {
    static BUILT: OnceLock<()> = OnceLock::new();
    BUILT.get_or_init(|| {
        let own = std::env::current_exe().unwrap();
        let folder = own.parent().and_then(Path::parent).unwrap();
        if !folder.join("k2a-controller").is_file() {
            let mut build = Command::new(env!("CARGO"));
            build.args(["build", "--offline", "--package", "hil", "--bins"]);
            if !cfg!(debug_assertions) {
                build.arg("--release");
            }
            assert!(build.status().unwrap().success(), "failed to build the controller");
        }
    });
}

/// The bytes of the record of a run, and how it ended.
fn record(prepared: &Prepared, hosting: Hosting) -> (Vec<u8>, String) {
    let folder = tempfile::tempdir().unwrap();
    let (seed, answers) = (1, Answers::default());
    let options = Options { seed, out: folder.path(), level: Level::Full, answers };
    let prepared = Prepared { hosting, ..prepared.clone() };
    let done = run_to_folder(&prepared, &options, &mut |_| true, &|| 0.0).unwrap();
    let ended = format!("{:?}: {:?}", done.summary.outcome, done.summary.reason);
    // Whatever a plan has a controller do, its record is read to its end.
    for record in RunFolder::open(folder.path()).unwrap().records().unwrap() {
        record.unwrap_or_else(|error| panic!("{}: {error}", prepared.plan.name.as_str()));
    }
    (std::fs::read(folder.path().join("record.hilrec")).unwrap(), ended)
}

fn is_the_same_in_a_process(prepared: &Prepared) {
    build_controller();
    let name = prepared.plan.name.as_str();
    let (here, how) = record(prepared, Hosting::default());
    let (there, how_there) = record(prepared, Hosting::program(ControllerProgram::Ours));
    assert_eq!(how, how_there, "{name}");
    let first = here.iter().zip(&there).position(|(here, there)| here != there);
    let lengths = (here.len(), there.len());
    assert!(here == there, "{name}: {lengths:?} bytes, first difference {first:?}, {how}");
}

/// Behind a plan whose own measurements are of no matter.
const MEASUREMENT: &str = r#"
[[measurement]]
name = "health"
doc = "A plan must measure something"
quantity = "health.degraded"
unit = "1"
check = { all_within = { at_least = -1e9 } }
"#;

/// A plan with each repetition once, a minute of each wait, and each different step once before a model is used and once
/// after it: all that a plan asks of a controller, and little of its time.
fn shortened(text: &str) -> String {
    let mut plan: toml::Table = text.parse().unwrap();
    let mut seen = Vec::new();
    once(plan["steps"].as_array_mut().unwrap(), &mut seen);
    // Some measurements are on steps that are left out.
    plan.remove("measurement");
    format!("{plan}{MEASUREMENT}")
}

fn once(steps: &mut Vec<toml::Value>, seen: &mut Vec<toml::Table>) {
    steps.retain_mut(|step| {
        let step = step.as_table_mut().unwrap();
        if let Some(repeat) = step.get_mut("repeat") {
            repeat["times"] = 1.into();
            let inner = repeat["steps"].as_array_mut().unwrap();
            once(inner, seen);
            return !inner.is_empty();
        }
        if step.contains_key("use_model") {
            seen.clear();
        }
        if let Some(duration) = step.iter_mut().find_map(|(_, what)| what.get_mut("duration_s"))
            && duration.as_integer() == Some(7200)
        {
            *duration = 60.into();
        }
        let mut bare = step.clone();
        bare.remove("label");
        let known = seen.contains(&bare);
        seen.push(bare);
        !known
    });
}

fn compare(change: impl Fn(&str) -> String, left_out: &[&str]) {
    let library = Library::shipped();
    let names = names(Kind::Plan).into_iter().filter(|name| !left_out.contains(&name.as_str()));
    let prepared = names.map(|name| {
        let mut source = library.open(Kind::Plan, &name).unwrap();
        source.text = change(&source.text);
        let prepared = Prepared::of_source(&library, &source, &Made::default());
        prepared.unwrap_or_else(|error| panic!("{name}: {error}"))
    });
    // Others have no controller.
    let prepared: Vec<_> = prepared.filter(|prepared| prepared.rig.robot.is_some()).collect();
    assert!(prepared.len() >= 17 - left_out.len(), "{} plans ship", prepared.len());
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(prepared) = prepared.get(next.fetch_add(1, Ordering::Relaxed)) {
                    is_the_same_in_a_process(prepared);
                }
            });
        }
    });
}

#[test]
fn shipped_plans_give_the_same_record_once_through() {
    // Each differs from a plan that takes part in the noise of its devices or in a calibration alone: it asks a controller
    // nothing else.
    let asks_the_same = [
        "correction-factors",
        "laps-mounted",
        "laps-observed-anew",
        "laps-observed-correlated",
        "laps-observed-later",
        "laps-observed-noisier",
        "straight-accuracy-mounted",
    ];
    compare(shortened, &asks_the_same);
}

/// Its machine is not scheduled, and its clock jumps there and back, in rest and in motion.
#[test]
fn faults_of_its_machine_are_the_same() {
    let plan = r#"
name = "struck"
title = "The machine of the controller is struck"
devices = "DEVICES"
steps = [
    { bias_test = { duration_s = 3 } },
    { place = { x_m = 0, y_m = 0, heading_deg = 0 } },
    { lap = { direction = "cw", side_m = 0.5 } },
]

[[fault]]
target = "host"
what = { scheduler_stall = { for_s = 0.03 } }
when = { at_s = 1.234 }

[[fault]]
target = "host"
what = { clock_step = { step_s = 0.03 } }
when = { at_s = 2.5 }
duration_s = 0.3

[[fault]]
target = "host"
what = { scheduler_stall = { for_s = 0.04 } }
when = { at_s = 5 }

[[fault]]
target = "host"
what = { clock_step = { step_s = -0.3 } }
when = { at_s = 7 }
duration_s = 1
"#;
    for devices in ["paper", "paper-serial"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("struck.toml");
        let text = plan.replace("DEVICES", devices) + MEASUREMENT;
        std::fs::write(&path, text).unwrap();
        let prepared = Prepared::load(path.to_str().unwrap(), &Made::default()).unwrap();
        is_the_same_in_a_process(&prepared);
    }
}

/// `cargo test -p harness --release --test controller_process -- --ignored`.
#[test]
#[ignore = "minutes"]
fn shipped_plans_give_the_same_record() {
    compare(str::to_owned, &[]);
}
