//! Somebody's program under test in virtual time: workers start it by the words of the rig, in the folder in which they run.

use crate::hil::{Hil, cases};
use crate::server::Server;

/// The pump that asks its valve, for two seconds.
fn pump() -> Hil {
    let files = [
        ("asks.toml", "duration_s = 10", "duration_s = 2"),
        ("rigs/pump.toml", "", ""),
        ("devices/valve.toml", "", ""),
        ("devices/pump.dbc", "", ""),
        ("pump.py", "", ""),
    ];
    Hil::with_example("pump", &files)
}

fn campaign(out: &str) -> Vec<&str> {
    let words = "campaign ./asks.toml --cases 24 --faults bus_load --seed 2 --json --out";
    words.split(' ').chain([out]).collect()
}

#[test]
fn its_cases_come_to_the_same_as_in_one_process() {
    let Some(server) = Server::start() else { return };
    let (hil, url) = (pump(), server.url());
    let alone = hil.start("alone", &campaign("alone")).ends().exits(1);
    let _workers = ["one", "two"].map(|name| hil.worker(name, &url));
    let mut over = campaign("over");
    over.extend(["--nats", &url]);
    let over = hil.start("over", &over).ends().exits(1);
    assert_eq!(over.campaign(), alone.campaign());
    let (over, alone) = (hil.journal("over"), hil.journal("alone"));
    assert_eq!(cases(&over).len(), 24);
    assert_eq!(cases(&over), cases(&alone));
}

/// A worker that has no such program says so, and is no finding about it.
#[test]
fn a_worker_without_the_program_is_named() {
    let Some(server) = Server::start() else { return };
    let (hil, elsewhere, url) = (pump(), Hil::new(), server.url());
    let _worker = elsewhere.worker("one", &url);
    let mut over = campaign("over");
    over.extend(["--nats", &url]);
    let ran = hil.start("over", &over).ends();
    panic!("{ran:#?}");
}
