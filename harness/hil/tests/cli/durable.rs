//! A killed run loses nothing, files of others are not replaced, and a slow reader blocks nothing.
#![cfg(unix)]

use crate::hil::{ENDLESS, Hil, Ran, TURN};
use record::reader::RecordError;
use record::run_folder::{RECORD, RunFolder};
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use skips::in_time;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(60);
const STEP: Duration = Duration::from_millis(20);

#[expect(clippy::disallowed_methods, reason = "waits for another process")]
fn pause(time: Duration) {
    thread::sleep(time);
}

fn wait_for(what: &str, mut done: impl FnMut() -> bool) {
    let mut waited = Duration::ZERO;
    while !done() {
        assert!(waited < PATIENCE, "waited in vain for {what}");
        pause(STEP);
        waited += STEP;
    }
}

fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |about| about.len())
}

fn start(hil: &Hil, arguments: &[&str]) -> Child {
    let mut command = hil.command(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Bench time of a killed run's last record, s; checks that the records are in order.
fn last_s(run: &Path) -> f64 {
    let mut last = 0.0;
    for record in RunFolder::open(run).unwrap().records().unwrap() {
        match record {
            Ok(record) => last = record.at.as_secs_f64(),
            Err(RecordError::CutShort { .. }) => {}
            Err(error) => panic!("{error}"),
        }
    }
    last
}

/// Number of runs to kill; `HIL_KILLS` overrides it.
fn kills() -> u64 {
    std::env::var("HIL_KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(6)
}

#[test]
fn a_run_that_is_killed_leaves_a_record_and_the_same_command_works_again() {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
    let record = hil.path("run").join(RECORD);
    let mut random = u64::from(std::process::id());
    for _ in 0..kills() {
        let mut child = start(&hil, &["run", "endless.toml", "--record", "full", "--out", "run"]);
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        pause(Duration::from_millis((random >> 33) % 1_500));
        child.kill().unwrap();
        child.wait().unwrap();
        // A run killed at once may not have begun.
        if length(&record) > 0 {
            last_s(&hil.path("run"));
        }
    }
    let ran = hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
    assert!(ran.out.contains("passed"), "{}", ran.out);
}

#[test]
fn a_run_in_real_time_that_is_killed_lacks_at_most_a_second() {
    in_time(|| {
        let hil = Hil::new();
        fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
        let arguments = ["run", "endless.toml", "--clock", "real", "--controller", "in-process"];
        let arguments = [&arguments[..], &["--record", "full", "--out", "run"]].concat();
        let mut child = start(&hil, &arguments);
        let record = hil.path("run").join(RECORD);
        wait_for("the record", || length(&record) > 0);
        wait_for("records", || {
            RunFolder::open(hil.path("run"))
                .is_ok_and(|run| run.records().is_ok_and(|all| all.count() > 1))
        });
        let (seen_s, ran) = (last_s(&hil.path("run")), Duration::from_secs(4));
        pause(ran);
        child.kill().unwrap();
        child.wait().unwrap();
        let last_s = last_s(&hil.path("run"));
        assert!(
            last_s > seen_s + ran.as_secs_f64() - 1.0,
            "{last_s} s, {seen_s} s were seen before {ran:?}"
        );
    });
}

#[test]
fn two_runs_do_not_share_a_folder() {
    let hil = Hil::with_plan(TURN);
    fs::write(hil.path("endless.toml"), ENDLESS).unwrap();
    let child = start(&hil, &["run", "endless.toml", "--out", "run"]);
    let record = hil.path("run").join(RECORD);
    wait_for("the record", || length(&record) > 0);
    let second = hil.run(&["run", "turn.toml", "--out", "run"]).exits(2);
    assert!(second.err.contains("a run is going on there"), "{}", second.err);
    // Its verdict would be on a part of the run, and would stand if the run were killed.
    let checked = hil.run(&["check", "run"]).exits(2);
    assert!(checked.err.contains("a run is going on there"), "{}", checked.err);
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    Ran::of(child.wait_with_output().unwrap()).exits(5);
    assert_eq!(hil.outcome("run"), "aborted");
    let records = RunFolder::open(hil.path("run")).unwrap().records().unwrap();
    assert_eq!(records.header().plan, "endless");
    assert!(records.into_iter().all(|record| record.is_ok()), "the record is whole");
}

/// Found by a user: two campaigns wrote to one journal, and the report counted 69 of 40 cases.
#[test]
fn two_campaigns_do_not_share_a_folder() {
    let hil = Hil::new();
    hil.run(&["new", "oven"]).exits(0);
    let campaign = ["campaign", "oven/settles.toml", "--out", "campaign", "--cases"];
    let first = start(&hil, &[&campaign[..], &["1000000"]].concat());
    wait_for("the journal", || length(&hil.path("campaign/cases.jsonl")) > 0);
    let second = hil.run(&[&campaign[..], &["4"]].concat()).exits(2);
    assert!(second.err.contains("a campaign is going on there"), "{}", second.err);
    kill_process(Pid::from_child(&first), Signal::INT).unwrap();
    Ran::of(first.wait_with_output().unwrap()).exits(5);
    let after = hil.run(&[&campaign[..], &["1"]].concat());
    assert!(!after.err.contains("refused"), "{}", after.err);
}

/// Enough requests, and answers, to fill a pipe many times over.
const REQUESTS: usize = 20_000;

#[test]
fn an_emulator_whose_answers_nobody_reads_serves_on() {
    let hil = Hil::new();
    let mut command = hil.command(&["emulate", "gyro", "--pty", "gyro"]);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let (said, all_said) = mpsc::channel();
    let asking = thread::spawn(move || {
        let asked = (0..REQUESTS).try_for_each(|_| input.write_all(b"{\"get\":\"truth\"}\n"));
        // The receiver may have given up.
        let _ = said.send(asked.is_ok());
        input
    });
    assert_eq!(all_said.recv_timeout(PATIENCE), Ok(true), "whoever asks is not held up");
    kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
    wait_for("the end", || child.try_wait().unwrap().is_some());
    assert!(child.wait().unwrap().success());
    drop(asking.join().unwrap());
}

/// Found by a user: whoever opened the port at a wrong rate read everything, and nothing said that a real line would be noise.
#[test]
fn an_emulator_tells_of_a_wrong_rate_at_its_pty() {
    let hil = Hil::new();
    let mut child = start(&hil, &["emulate", "gyro", "--pty", "gyro"]);
    let mut ready = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut ready).unwrap();
    let port = File::options().read(true).write(true).open(hil.path("gyro")).unwrap();
    let set = |rate: u32| {
        let mut settings = tcgetattr(&port).unwrap();
        settings.set_speed(rate).unwrap();
        tcsetattr(&port, OptionalActions::Now, &settings).unwrap();
    };
    set(4_800);
    let mut warnings = BufReader::new(child.stderr.take().unwrap());
    let mut warned = String::new();
    warnings.read_line(&mut warned).unwrap();
    let told = "the other side has set the gyro's port to 4800 baud, and the gyro speaks 9600";
    assert!(warned.contains(told), "{warned}");
    kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
    assert!(child.wait().unwrap().success());
    // Once is enough.
    warned.clear();
    warnings.read_to_string(&mut warned).unwrap();
    assert_eq!(warned, "");
}

#[test]
fn a_parameter_that_is_misspelt_or_out_of_range_is_found_at_once() {
    let hil = Hil::new();
    for (step, message) in [
        (
            "{ set_parameter = { parameter = \"gyro.ambient_celcius\", value = 20 } }",
            "did you mean `ambient_celsius`",
        ),
        (
            "{ set_parameter = { parameter = \"gyro.ambient_celsius\", value = 2000 } }",
            "is not within",
        ),
        (
            "{ set_parameter = { parameter = \"gyros.ambient_celsius\", value = 20 } }",
            "no `gyros` on this bench",
        ),
        (
            "{ sweep = { parameter = \"base.odd\", values = [1, 2], steps = [{ bias_test = {} }] } }",
            "no parameter `odd`",
        ),
    ] {
        let plan = ENDLESS.replace("steps = [\n", &format!("steps = [\n    {step},\n"));
        fs::write(hil.path("plan.toml"), plan).unwrap();
        for command in ["run", "campaign"] {
            let ran = hil.run(&[command, "plan.toml"]).exits(2);
            assert!(ran.err.contains(message), "{command} {step}: {}", ran.err);
        }
    }
}

#[test]
fn a_log_that_no_controller_can_fill_is_refused() {
    let hil = Hil::new();
    let plan = ENDLESS.replace(
        "{ bias_test = { duration_s = 5 } }",
        "{ log = { duration_s = 9, interval_s = 0.1 } }",
    );
    fs::write(hil.path("plan.toml"), plan).unwrap();
    let ran = hil.run(&["run", "plan.toml"]).exits(2);
    assert!(ran.err.contains("interval_s = 0.1, expected at least 1"), "{}", ran.err);
}

#[test]
fn a_name_that_nothing_has_is_shown_where_the_plan_says_it() {
    let hil = Hil::new();
    for (from, to, name) in [
        ("devices = \"paper\"", "devices = \"papre\"", "papre"),
        ("{ bias_test = { duration_s = 5 } }", "{ use_calibration = \"wram\" }", "wram"),
    ] {
        fs::write(hil.path("plan.toml"), ENDLESS.replace(from, to)).unwrap();
        let ran = hil.run(&["run", "plan.toml"]).exits(2);
        assert!(ran.err.contains(&format!("is called \"{name}\"")), "{}", ran.err);
        assert!(ran.err.contains("plan.toml:"), "{}", ran.err);
    }
}

/// A command refuses to replace a file of another origin.
#[test]
fn files_of_somebody_else_are_not_replaced() {
    let plan = TURN.replace("steps = [", "steps = [\n    { use_calibration = \"temperature\" },");
    let hil = Hil::with_plan(&plan);
    hil.run(&["run", "turn.toml", "--out", "run"]).exits(0);
    for (file, arguments) in [
        ("report.html", &["campaign", "turn.toml", "--cases", "2", "--out", "mine"][..]),
        ("datapackage.json", &["export", "run", "--kind", "series", "--out", "mine"]),
        ("states.csv", &["export", "run", "--tables", "mine", "--format", "csv"]),
    ] {
        let path = hil.path("mine").join(file);
        fs::create_dir(hil.path("mine")).unwrap();
        fs::write(&path, "{}").unwrap();
        let ran = hil.run(arguments).exits(2);
        let refused = ran.err.contains("refused to") && ran.err.contains("mine: it holds files");
        assert!(refused, "{}", ran.err);
        assert_eq!(fs::read_to_string(&path).unwrap(), "{}");
        assert_eq!(fs::read_dir(hil.path("mine")).unwrap().count(), 1, "nothing beside it");
        fs::remove_dir_all(hil.path("mine")).unwrap();
    }
}

#[test]
fn nothing_in_a_file_reaches_the_terminal_but_text() {
    let hil = Hil::new();
    let title = "No end";
    let plan = ENDLESS.replace(title, "\\u001b]0;mine\\u0007\\u001b[2J");
    fs::write(hil.path("plan.toml"), plan.replace("endless", "no such name\\u001b[2J")).unwrap();
    for arguments in [&["run", "plan.toml"][..], &["list", "plans"]] {
        let ran = hil.run(arguments);
        for text in [&ran.out, &ran.err] {
            assert!(!text.contains("\u{1b}[2J") && !text.contains("\u{1b}]0"), "{text:?}");
        }
    }
}
