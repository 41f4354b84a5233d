//! Campaigns on a worker's bench, in real time: emulated devices on ptys, the controller in the worker.

use crate::away::{Told, remote_at, server};
use crate::hil::{Hil, Ran, cases, wait_for};
use crate::server::{Server, cases_waiting, say};
use campaign::{Case, CaseResult, Executor};
use campaign_nats::VERSION;
use campaign_nats::{Holder, Package, Place, Stopping, WorkerSettings, work};
use serde_json::Value;
use skips::in_time;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::thread::scope;
use std::time::Duration;

/// Some seconds of real time, and a property that enough wheel slip breaks.
const PLAN: &str = include_str!("../../../hil/tests/short.toml");

/// Our controller, in the worker's process. The lateness of a busy machine has no influence here.
const BENCH: &str = "title = \"The bench by the window\"\n[controller]\nin_process = true\n\
                     [timing]\nlate_ms_max = 10000\n";

/// Creates a folder with the plan and the bench file that all processes share.
fn there(bench: &str) -> Hil {
    let hil = Hil::new();
    std::fs::write(hil.path("short.toml"), PLAN).unwrap();
    std::fs::write(hil.path("window.toml"), bench).unwrap();
    hil
}

/// Arguments of a campaign whose second case breaks `done_is_done`.
fn slips<'a>(out: &'a str, rest: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["campaign", "./short.toml", "--clock", "real", "--json", "--out", out];
    arguments.extend(["--bench", "window.toml", "--faults", "wheel_slip", "--faults-max", "1"]);
    arguments.extend(["--cases", "2", "--seed", "2", "--shrink-max", "1"]);
    arguments.extend(["--repeat", "2", "--confidence", "0.7"]);
    arguments.extend(rest);
    arguments
}

fn worker<'a>(url: &'a str, bench: &'a str) -> [&'a str; 7] {
    ["worker", "--nats", url, "--bench", bench, "--wait", "30"]
}

/// What a failure of a case did when it was repeated, by property.
const REPEATED: &str = ".found.result.repeated.";

/// Collects the names of all fields at any depth, which do not depend on durations.
fn form(value: &Value, at: &str, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) => {
            for (name, value) in members {
                form(value, &format!("{at}.{name}"), names);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| form(value, at, names)),
        _ => drop(names.insert(at.to_owned())),
    }
}

/// Checks the document of a campaign of [`slips`]: its failures were repeated afresh.
#[track_caller]
fn said(ran: &Ran) -> (BTreeSet<String>, Value) {
    let end = ran.campaign();
    let mut names = BTreeSet::new();
    form(&end, "", &mut names);
    // The outcomes of the runs, the smallest severity and what else breaks depend on the machine: wheels that grip again
    // while the robot moves speed it up beyond its limits, and whether it moves then is a matter of real time.
    let is_here_alone = |name: &str| {
        name.starts_with(".outcomes")
            || name.contains(".smallest")
            || name.starts_with(".unconfirmed")
            || (name.starts_with(REPEATED) && !name.contains("done_is_done"))
    };
    names.retain(|name| !is_here_alone(name));
    let found = &end["found"][0];
    assert_eq!(found["property"], "done_is_done", "{end}");
    assert_eq!(found["repeated"]["of"], 2, "{end}");
    (names, end)
}

#[test]
fn what_breaks_on_a_workers_bench_is_what_breaks_on_ones_own() {
    in_time(|| {
        let Some(server) = Server::start() else { return };
        let hil = there(BENCH);
        let url = server.url();
        let first = hil.start("first", &worker(&url, "window.toml"));
        first.wait_until_it_says("holds the bench window");
        let over = hil.start("over", &slips("over", &["--nats", &url]));

        // A worker that is asked to end breaks off its case, and the next worker begins it anew.
        first.wait_until_it_says(": short");
        first.interrupt();
        let first = first.ends().exits(0);
        assert!(first.err.contains("0 cases carried out"), "{}", first.err);
        let second = hil.start("second", &worker(&url, "./window.toml"));
        second.wait_until_it_says("holds the bench window");

        // One after the other: both are in real time.
        let over = over.ends().exits(1);
        let alone = hil.start("alone", &slips("alone", &[])).ends().exits(1);
        let ((there, end), (here, _)) = (said(&over), said(&alone));
        assert_eq!(there, here, "the same is said wherever the bench is");
        assert_eq!((&end["confidence"], &end["stopped"]), (&0.7.into(), &false.into()));
        assert_eq!(cases_waiting(&url), 0);
        second.interrupt();
        second.ends().exits(0);
    });
}

#[test]
fn a_coordinator_that_was_killed_goes_on_with_the_same_cases() {
    in_time(|| {
        let Some(server) = Server::start() else { return };
        let hil = there(BENCH);
        let url = server.url();
        let _worker = hil.start("worker", &worker(&url, "window.toml"));
        let mut arguments =
            vec!["campaign", "./short.toml", "--clock", "real", "--json", "--out", "over"];
        arguments.extend(["--bench", "window.toml", "--faults", "drop,wheel_slip", "--cases", "3"]);
        arguments.extend([
            "--shrink-max",
            "0",
            "--repeat",
            "2",
            "--confidence",
            "0.7",
            "--nats",
            &url,
        ]);
        let mut first = hil.start("first", &arguments);
        hil.wait_for_cases("over", 1);
        first.kill();
        let done = hil.journal("over").len() - 1;
        assert!(done < 3, "killed in the middle");
        let second = hil.start("second", &arguments).ends();
        assert!(matches!(second.status, Some(0 | 1)), "{second:#?}");
        let end: Value = serde_json::from_str(&second.out).unwrap();
        // A run without faults never takes the same time: the cases are those of the first run nevertheless.
        assert!(end["resumed"].as_u64().unwrap() >= done as u64, "{end}");
        assert_eq!(cases(&hil.journal("over")).len(), 3);
    });
}

#[test]
fn a_bench_that_does_not_come_up_ends_its_worker_and_no_case() {
    let Some(server) = Server::start() else { return };
    let hil = there("[controller]\ncommand = [\"./there-is-no-such-program\"]\n");
    let url = server.url();
    let over = hil.start("over", &slips("over", &["--nats", &url]));
    over.wait_until_it_says("waits for workers");
    // More attempts than a case that ends its workers gets.
    for attempt in 0..10 {
        let name = format!("worker{attempt}");
        let ran = hil.start(&name, &worker(&url, "window.toml")).ends().exits(3);
        assert!(ran.err.contains("there-is-no-such-program"), "{}", ran.err);
    }
    assert_eq!(cases_waiting(&url), 1);
    // A stopped campaign leaves no case for a bench.
    over.interrupt();
    over.ends().exits(5);
    assert_eq!(cases_waiting(&url), 0);
}

#[test]
fn another_bench_file_of_that_name_is_refused_by_name() {
    let Some(server) = Server::start() else { return };
    let hil = there(BENCH);
    std::fs::create_dir(hil.path("other")).unwrap();
    std::fs::write(hil.path("other/window.toml"), BENCH.replace("window", "door")).unwrap();
    let url = server.url();
    let other = hil.start("other", &worker(&url, "other/window.toml"));
    let ran = hil.start("over", &slips("over", &["--nats", &url])).ends().exits(3);
    let why = "cannot carry out this campaign: the worker's bench file window is another";
    assert!(ran.says().contains(why), "{}", ran.err);
    other.wait_until_it_says("the worker's bench file window is another than the campaign's");

    // The right worker carries on.
    other.interrupt();
    other.ends().exits(0);
    let right = hil.start("right", &worker(&url, "window.toml"));
    let _over = hil.start("over", &slips("over", &["--nats", &url]));
    right.wait_until_it_says(": short");
}

/// A run that continues until it is broken off.
struct Endless(Stopping);

impl Executor for Endless {
    fn execute(&self, _: &Case) -> CaseResult {
        wait_for("a stop", || self.0.is_so());
        CaseResult { outcome: "aborted".to_owned(), ..CaseResult::default() }
    }
}

#[test]
fn a_run_is_broken_off_where_the_bench_is_anothers() {
    let Some(there) = Server::start() else { return };
    let (url, told) = (there.url(), Arc::<Told>::default());
    let place = || Place::bench("window").unwrap();
    let settings = |name: &str| WorkerSettings {
        place: place(),
        threads: NonZeroUsize::MIN,
        holder: Holder::named(name),
        version: VERSION.to_owned(),
        patience: Duration::from_secs(30),
    };
    let remote = remote_at(place(), &url, &told);
    scope(|scope| {
        let asking = scope.spawn(|| remote.execute(&Case::default()));
        let worker = scope.spawn(|| {
            let maker = Arc::new(move |_: &Package, stopping: Stopping| {
                let executor: Arc<dyn Executor + Send + Sync> = Arc::new(Endless(stopping));
                Ok(("endless".to_owned(), executor))
            });
            work(&server(&url), &settings("the worker"), maker, told.teller(), || false)
        });
        told.wait_for(": endless");
        say(async {
            let jetstream = async_nats::jetstream::new(async_nats::connect(&url).await.unwrap());
            let leases = jetstream.get_key_value("HIL_LEASES").await.unwrap();
            leases.put("bench.window", "somebody else".into()).await.unwrap();
        });
        let lost = worker.join().unwrap().unwrap_err();
        let by = "the lease on the bench window is lost to somebody else";
        assert_eq!(lost.to_string(), by);
        // The next holder of the bench has to carry out the case, or to refuse it.
        assert_eq!(cases_waiting(&url), 1);
        let maker = Arc::new(move |_: &Package, _: Stopping| Err("no plan".to_owned()));
        let answered = || asking.is_finished();
        work(&server(&url), &settings("another"), maker, told.teller(), answered).unwrap();
        assert!(asking.join().unwrap().is_given_up());
        assert!(remote.failure().unwrap().to_string().contains("another cannot carry out"));
    });
}

/// Arguments and settings that would contradict the worker's bench file.
#[test]
fn the_bench_file_says_all_of_a_bench_elsewhere() {
    let hil = there(BENCH);
    let real = ["campaign", "./short.toml", "--clock", "real", "--nats", "nats://127.0.0.1:9"];
    let cases: [(&[&str], &str); 3] = [
        (&[], "which bench carries the cases out?"),
        (
            &["--bench", "window.toml", "--controller", "./mine"],
            "--controller does not reach a worker",
        ),
        (&["--bench", "window.toml", "--repeat", "2"], "--repeat 5 is the least"),
    ];
    for (rest, says) in cases {
        let ran = hil.start("refused", &[&real[..], rest].concat()).ends().exits(2);
        assert!(ran.err.contains(says), "{}", ran.err);
    }
}
