//! Refusals and their messages.

use crate::hil::Hil;
use crate::server::{Server, cases_waiting, say};
use async_nats::jetstream::{self, stream};
use campaign_nats::VERSION;

#[test]
fn without_a_server_it_ends_and_says_what_to_do() {
    let hil = Hil::new();
    // No server listens there: the port is for discarding (RFC 863), and no longer in use.
    let url = "nats://127.0.0.1:9";
    for arguments in [vec!["worker", "--nats", url], vec!["campaign", "live-side", "--nats", url]] {
        let ran = hil.start("none", &arguments).ends().exits(2);
        assert!(ran.err.contains("failed to connect to nats://127.0.0.1:9"), "{}", ran.err);
        assert!(ran.err.contains("nats-server -js -sd FOLDER"), "{}", ran.err);
    }
    let ran = hil.start("bad", &["worker", "--nats", "http://there"]).ends().exits(2);
    assert!(ran.err.contains("such as nats://localhost:4222"), "{}", ran.err);
}

/// Puts a case of version 9.9.9 there, once a worker has created the stream.
fn put_foreign(url: &str, subject: &str) {
    say(async {
        let jetstream = jetstream::new(async_nats::connect(url).await.unwrap());
        let mut headers = async_nats::HeaderMap::new();
        headers.insert("Hil-Format", "3");
        headers.insert("Hil-Version", "9.9.9");
        headers.insert("Hil-Campaign", "c0ffee");
        loop {
            let subject = subject.to_owned();
            let sent = jetstream.publish_with_headers(subject, headers.clone(), "{}".into()).await;
            if let Ok(sent) = sent
                && sent.await.is_ok()
            {
                break;
            }
        }
    });
}

#[test]
fn a_case_that_lies_about_its_version_is_refused_by_name_and_left_to_others() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    let worker = hil.worker("worker", &server.url());
    let url = server.url();
    put_foreign(&url, &format!("hil.cases.virtual.{}.c0ffee.1", VERSION.replace(['.', '+'], "-")));
    let ran = worker.ends().exits(2);
    let ours = format!("this worker is version {VERSION}");
    assert!(ran.err.contains(&ours) && ran.err.contains("9.9.9 (message format 3)"), "{}", ran.err);
    assert!(ran.err.contains("campaign c0ffee"), "{}", ran.err);
    assert_eq!(cases_waiting(&url), 1);
}

#[test]
fn a_case_of_another_build_keeps_no_worker_from_its_work() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    let url = server.url();
    let worker = hil.worker("worker", &url);
    put_foreign(&url, "hil.cases.virtual.9-9-9.c0ffee.1");
    let over = ["campaign", "live-side", "--cases", "3", "--out", "over", "--nats", &url];
    let over = hil.start("over", &over).ends().exits(0);
    assert!(over.err.contains(&format!("workers of version {VERSION}")), "{}", over.err);
    worker.interrupt();
    worker.ends().exits(0);
    assert_eq!(cases_waiting(&url), 1);
}

#[test]
fn streams_of_another_version_are_refused_by_name() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    let url = server.url();
    say(async {
        let jetstream = jetstream::new(async_nats::connect(&url).await.unwrap());
        let config = stream::Config {
            name: "HIL_CASES".to_owned(),
            subjects: vec!["hil.cases.>".to_owned()],
            description: Some("hil, message format 99".to_owned()),
            ..stream::Config::default()
        };
        jetstream.create_stream(config).await.unwrap();
    });
    for arguments in [vec!["worker", "--nats", &url], vec!["campaign", "live-side", "--nats", &url]]
    {
        let ran = hil.start("other", &arguments).ends().exits(2);
        assert!(
            ran.says().contains("is of another version: \"hil, message format 99\""),
            "{}",
            ran.err
        );
    }
}

#[test]
fn a_bench_is_one_workers_until_it_lets_go_or_dies() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    std::fs::write(hil.path("window.toml"), "title = \"The bench by the window\"\n").unwrap();
    let url = server.url();
    let arguments = ["worker", "--nats", &url, "--bench", "window.toml"];
    let mut first = hil.start("first", &arguments);
    first.wait_until_it_says("holds the bench window");
    let second = hil.start("second", &arguments).ends().exits(2);
    let holder = format!("process {}", first.id());
    assert!(second.err.contains("the bench window is held by hil "), "{}", second.err);
    assert!(second.err.contains(&holder), "{}", second.err);

    // A killed worker holds its lease until it expires.
    first.kill();
    let mut patient = arguments.to_vec();
    patient.extend(["--wait", "60"]);
    let third = hil.start("third", &patient);
    third.wait_until_it_says("waiting for it");
    third.wait_until_it_says("holds the bench window");

    // A worker that is asked to end releases its lease at once.
    third.interrupt();
    third.ends().exits(0);
    let fourth = hil.start("fourth", &arguments);
    fourth.wait_until_it_says("holds the bench window");
}

#[test]
fn a_campaign_is_carried_on_by_one_at_a_time() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    let url = server.url();
    let arguments =
        |out| vec!["campaign", "live-side", "--cases", "5", "--nats", &url, "--out", out];
    let first = hil.start("first", &arguments("first"));
    first.wait_until_it_says("waits for workers");
    let second = hil.start("second", &arguments("second"));
    second.wait_until_it_says("this campaign is held by hil ");
    second.ends().exits(2);
    // Without a worker, the campaign reports what it waits for, and can be stopped.
    first.wait_until_it_says("5 cases wait for a worker (virtual time), 0 are being carried out");
    first.interrupt();
    first.ends().exits(5);
}
