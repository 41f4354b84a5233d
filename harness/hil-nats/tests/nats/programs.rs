//! A program under test in virtual time: workers start it with the command of the rig file, in their working directory.

use crate::hil::{Hil, cases};
use crate::server::Server;

/// The pump that queries its valve, for two seconds.
fn pump() -> Hil {
    let files = [
        ("asks.toml", "", ""),
        ("rigs/pump.toml", "", ""),
        ("devices/valve.toml", "", ""),
        ("devices/pump.dbc", "", ""),
        ("pump.py", "", ""),
    ];
    Hil::with_example("pump", &files)
}

fn campaign(out: &str) -> Vec<&str> {
    let words =
        "campaign ./asks.toml --cases 12 --shrink-max 8 --faults bus_load --seed 2 --json --out";
    words.split(' ').chain([out]).collect()
}

#[test]
fn results_on_workers_are_those_of_one_process() {
    let Some(server) = Server::start() else { return };
    let (hil, url) = (pump(), server.url());
    let alone = hil.start("alone", &campaign("alone")).ends().exits(1);
    let _workers = ["one", "two"].map(|name| hil.worker(name, &url));
    let mut over = campaign("over");
    over.extend(["--nats", &url]);
    let over = hil.start("over", &over).ends().exits(1);
    assert_eq!(over.campaign(), alone.campaign());
    let (over, alone) = (hil.journal("over"), hil.journal("alone"));
    assert_eq!(cases(&over).len(), 12);
    assert_eq!(cases(&over), cases(&alone));
}
