//! One campaign, in one process and on several machines.

use crate::hil::{Hil, cases};
use crate::server::{Server, say};

const CASES: usize = 400;

fn arguments(out: &str) -> Vec<&str> {
    vec!["campaign", "live-side", "--cases", "400", "--json", "--out", out]
}

#[test]
fn it_is_the_same_though_a_worker_is_killed_and_the_server_restarted() {
    let Some(mut server) = Server::start() else { return };
    let hil = Hil::new();
    let alone = hil.start("alone", &arguments("alone"));
    let url = server.url();
    let mut workers: Vec<_> = ["one", "two", "three"].map(|name| hil.worker(name, &url)).into();
    let mut over = arguments("over");
    over.extend(["--nats", &url]);
    let over = hil.start("over", &over);
    hil.wait_for_cases("over", 60);
    let done_before = hil.journal("over").len();
    workers[0].kill();
    assert!(done_before < CASES / 2, "killed in the middle");
    hil.wait_for_cases("over", done_before + 60);
    server.kill();
    assert!(hil.journal("over").len() < CASES, "restarted in the middle");
    over.wait_until_it_says("the server is away");
    server.start_again();
    over.wait_until_it_says("the server is back");

    // If a property breaks, shrinking uses the server too.
    let (over, alone) = (over.ends(), alone.ends());
    assert!(matches!(alone.status, Some(0 | 1)), "{alone:#?}");
    assert_eq!(over.status, alone.status, "{}", over.err);
    let (over_cases, alone_cases) = (hil.journal("over"), hil.journal("alone"));
    let (over_cases, alone_cases) = (cases(&over_cases), cases(&alone_cases));
    assert_eq!(over_cases.len(), CASES);
    assert_eq!(over_cases, alone_cases);
    assert_eq!(over.campaign(), alone.campaign());
    let stopped: Vec<_> = workers.drain(1..).collect();
    for worker in stopped {
        worker.interrupt();
        let ran = worker.ends().exits(0);
        assert!(ran.err.contains(" cases carried out"), "{}", ran.err);
    }
    let found = alone.campaign()["found"].as_array().unwrap().len();
    assert_eq!(left(&url, found), ["campaigns/result.json", "cases 0", "packages", "results 0"]);
}

/// Lists what a campaign leaves on the server: empty streams, and objects, without the names of the campaign and its
/// package and without the plans of the `found` failing cases.
fn left(url: &str, found: usize) -> Vec<String> {
    use futures_util::StreamExt as _;
    say(async {
        let jetstream = async_nats::jetstream::new(async_nats::connect(url).await.unwrap());
        let mut left = Vec::new();
        for (name, stream) in [("cases", "HIL_CASES"), ("results", "HIL_RESULTS")] {
            let stream = jetstream.get_stream(stream).await.unwrap();
            left.push(format!("{name} {}", stream.cached_info().state.messages));
        }
        let store = jetstream.get_object_store("HIL").await.unwrap();
        let mut objects = store.list().await.unwrap();
        let mut plans = 0;
        while let Some(object) = objects.next().await {
            let name = object.unwrap().name;
            match name.split('/').collect::<Vec<_>>()[..] {
                ["packages", _] => left.push("packages".to_owned()),
                ["campaigns", _, "result.json"] => left.push("campaigns/result.json".to_owned()),
                ["campaigns", _, plan] if plan.ends_with(".toml") => plans += 1,
                _ => left.push(name),
            }
        }
        assert_eq!(plans, found, "failing cases are kept");
        left.sort();
        left
    })
}
