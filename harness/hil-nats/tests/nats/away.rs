//! Servers, coordinators and workers that disappear, seen from inside: how often a case is carried out.

use crate::hil::{Hil, cases, wait_for};
use crate::server::{Server, cases_waiting, messages, say};
use campaign::{Case, CaseResult, Executor};
use campaign_nats::VERSION;
use campaign_nats::{
    Credentials, Holder, News, Package, Place, Remote, RemoteSettings, Stopping, WorkerSettings,
    work,
};
use futures_util::StreamExt as _;
use harness::operator::Answers;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::scope;
use std::time::Duration;

/// Executor whose result of each case contains the seed of that case.
struct Echo {
    begun: AtomicU64,
    /// No case ends before this is set.
    gate: AtomicBool,
}

impl Echo {
    fn new(is_open: bool) -> Arc<Self> {
        Arc::new(Self { begun: AtomicU64::new(0), gate: AtomicBool::new(is_open) })
    }

    fn result(case: &Case) -> CaseResult {
        let reached = [case.seed.to_string()].into();
        CaseResult { outcome: "passed".to_owned(), reached, passed: true, ..CaseResult::default() }
    }
}

impl Executor for Echo {
    fn execute(&self, case: &Case) -> CaseResult {
        self.begun.fetch_add(1, Ordering::Relaxed);
        wait_for("the gate", || self.gate.load(Ordering::Relaxed));
        Self::result(case)
    }
}

pub fn server(url: &str) -> campaign_nats::Server {
    campaign_nats::Server::new(&[url.to_owned()], Credentials::default()).unwrap()
}

/// News as text.
#[derive(Default)]
pub struct Told(Mutex<Vec<String>>);

impl Told {
    pub fn teller(self: &Arc<Self>) -> Arc<dyn Fn(&News) + Send + Sync> {
        let told = Arc::clone(self);
        Arc::new(move |news| told.0.lock().unwrap().push(news.to_string()))
    }

    pub fn wait_for(&self, text: &str) {
        wait_for(text, || self.0.lock().unwrap().iter().any(|told| told.contains(text)));
    }
}

/// The coordinator's own executor, which is never used.
pub struct Nobody;

impl Executor for Nobody {
    fn execute(&self, case: &Case) -> CaseResult {
        unreachable!("{case:?}")
    }
}

fn remote(url: &str, told: &Arc<Told>) -> Remote<Nobody> {
    remote_at(Place::Virtual, url, told)
}

pub fn remote_at(place: Place, url: &str, told: &Arc<Told>) -> Remote<Nobody> {
    remote_until(|| false, place, url, told)
}

fn remote_until(
    stop: impl Fn() -> bool + Send + 'static,
    place: Place,
    url: &str,
    told: &Arc<Told>,
) -> Remote<Nobody> {
    let package = Package::of("live-side", &Answers::default()).unwrap();
    let settings = RemoteSettings {
        what: "echoes".to_owned(),
        place,
        holder: Holder::named("the coordinator"),
    };
    Remote::open(&server(url), &package, settings, Nobody, told.teller(), stop).unwrap()
}

fn carry_out(url: &str, echo: &Arc<Echo>, told: &Arc<Told>, stop: &AtomicBool) -> u64 {
    let settings = WorkerSettings {
        place: Place::Virtual,
        threads: NonZeroUsize::MIN,
        holder: Holder::named("the worker"),
        version: VERSION.to_owned(),
        patience: Duration::ZERO,
    };
    let echo = Arc::clone(echo);
    let maker = Arc::new(move |_: &Package, _: Stopping| {
        Ok(("echo".to_owned(), Arc::clone(&echo) as Arc<dyn Executor + Send + Sync>))
    });
    let stop = || stop.load(Ordering::Relaxed);
    work(&server(url), &settings, maker, told.teller(), stop).unwrap()
}

#[test]
fn a_worker_goes_on_without_the_server_and_reports_when_it_is_back() {
    let Some(mut server) = Server::start() else { return };
    let url = server.url();
    let (echo, stop) = (Echo::new(false), AtomicBool::new(false));
    let (by_worker, by_coordinator) = (Arc::<Told>::default(), Arc::<Told>::default());
    scope(|scope| {
        let worker = scope.spawn(|| carry_out(&url, &echo, &by_worker, &stop));
        let asking = scope.spawn(|| {
            let remote = remote(&url, &by_coordinator);
            remote.execute(&Case { seed: 7, ..Case::default() })
        });
        wait_for("the case", || echo.begun.load(Ordering::Relaxed) == 1);
        server.stop();
        by_worker.wait_for("the server is away");
        by_coordinator.wait_for("the server is away");
        // The case ends while the server is away.
        echo.gate.store(true, Ordering::Relaxed);
        server.start_again();
        by_worker.wait_for("the server is back");
        let result = asking.join().unwrap();
        assert_eq!(result, Echo::result(&Case { seed: 7, ..Case::default() }));
        stop.store(true, Ordering::Relaxed);
        assert_eq!(worker.join().unwrap(), 1);
    });
    assert_eq!(echo.begun.load(Ordering::Relaxed), 1, "nobody carried it out again");
}

#[test]
fn a_result_that_comes_after_the_end_is_not_left_on_the_server() {
    let Some(server) = Server::start() else { return };
    let url = server.url();
    let (echo, stop) = (Echo::new(false), AtomicBool::new(false));
    let told = Arc::<Told>::default();
    let gives_up = Arc::new(AtomicBool::new(false));
    let is_to_give_up = Arc::clone(&gives_up);
    let give_up = move || is_to_give_up.load(Ordering::Relaxed);
    let remote = remote_until(give_up, Place::Virtual, &url, &told);
    scope(|scope| {
        let worker = scope.spawn(|| carry_out(&url, &echo, &told, &stop));
        scope.spawn(|| remote.execute(&Case::default()));
        wait_for("the case", || echo.begun.load(Ordering::Relaxed) == 1);
        remote.finish(Vec::new()).unwrap();
        assert_eq!(cases_waiting(&url), 0);
        echo.gate.store(true, Ordering::Relaxed);
        stop.store(true, Ordering::Relaxed);
        assert_eq!(worker.join().unwrap(), 1);
        gives_up.store(true, Ordering::Relaxed);
        assert_eq!(messages(&url, "HIL_RESULTS"), 0);
    });
}

/// Longer than a silent worker may keep a case.
const LONG: Duration = Duration::from_secs(8);

#[test]
fn a_case_that_takes_long_stays_with_its_worker() {
    struct Slow(AtomicU64);
    impl Executor for Slow {
        #[expect(clippy::disallowed_methods, reason = "a case that takes long")]
        fn execute(&self, case: &Case) -> CaseResult {
            self.0.fetch_add(1, Ordering::Relaxed);
            std::thread::sleep(LONG);
            Echo::result(case)
        }
    }
    let Some(server_there) = Server::start() else { return };
    let url = server_there.url();
    let (slow, stop) = (Arc::new(Slow(AtomicU64::new(0))), AtomicBool::new(false));
    let told = Arc::<Told>::default();
    scope(|scope| {
        for name in ["one", "other"] {
            let (slow, stop, told, url) = (Arc::clone(&slow), &stop, &told, &url);
            scope.spawn(move || {
                let settings = WorkerSettings {
                    place: Place::Virtual,
                    threads: NonZeroUsize::MIN,
                    holder: Holder::named(name),
                    version: VERSION.to_owned(),
                    patience: Duration::ZERO,
                };
                let maker = Arc::new(move |_: &Package, _: Stopping| {
                    Ok(("slow".to_owned(), Arc::clone(&slow) as Arc<dyn Executor + Send + Sync>))
                });
                let stop = || stop.load(Ordering::Relaxed);
                work(&server(url), &settings, maker, told.teller(), stop).unwrap();
            });
        }
        remote(&url, &told).execute(&Case::default());
        stop.store(true, Ordering::Relaxed);
    });
    assert_eq!(slow.0.load(Ordering::Relaxed), 1);
}

#[test]
fn a_case_that_nobody_survives_is_given_up_by_name() {
    let Some(server) = Server::start() else { return };
    let url = server.url();
    let (told, stop) = (Arc::<Told>::default(), AtomicBool::new(false));
    let echo = Echo::new(true);
    scope(|scope| {
        let asking = scope.spawn(|| {
            let remote = remote(&url, &told);
            let poison = remote.execute(&Case { seed: 13, ..Case::default() });
            (poison, remote.execute(&Case { seed: 14, ..Case::default() }))
        });
        // Takes the case and disappears, eight times.
        say(async {
            let jetstream = async_nats::jetstream::new(async_nats::connect(&url).await.unwrap());
            let queue = format!("virtual-{}", VERSION.replace(['.', '+'], "-"));
            let mut taken = 0;
            while taken < 8 {
                let found = jetstream.get_consumer_from_stream(&queue, "HIL_CASES").await;
                let Ok::<async_nats::jetstream::consumer::PullConsumer, _>(consumer) = found else {
                    // The coordinator creates it.
                    tokio::time::sleep(Duration::from_millis(20)).await;
                    continue;
                };
                let request = consumer.batch().max_messages(1).expires(Duration::from_secs(1));
                let mut batch = request.messages().await.unwrap();
                while let Some(Ok(message)) = batch.next().await {
                    let back = async_nats::jetstream::AckKind::Nak(None);
                    message.ack_with(back).await.unwrap();
                    taken += 1;
                }
            }
        });
        let worker = scope.spawn(|| carry_out(&url, &echo, &told, &stop));
        let (poison, next) = asking.join().unwrap();
        assert_eq!((poison.outcome.as_str(), poison.passed), ("worker_lost", false));
        assert_eq!(next, Echo::result(&Case { seed: 14, ..Case::default() }));
        told.wait_for("was handed out 8 times and never came back: given up");
        stop.store(true, Ordering::Relaxed);
        worker.join().unwrap();
    });
    assert_eq!(echo.begun.load(Ordering::Relaxed), 1);
}

#[test]
fn a_coordinator_that_was_killed_goes_on_where_it_stopped() {
    let Some(server) = Server::start() else { return };
    let hil = Hil::new();
    let url = server.url();
    let arguments = |out| vec!["campaign", "live-side", "--cases", "250", "--json", "--out", out];
    let alone = hil.start("alone", &arguments("alone"));
    let _worker = hil.worker("worker", &url);
    let mut over = arguments("over");
    over.extend(["--nats", &url]);
    let mut first = hil.start("first", &over);
    hil.wait_for_cases("over", 80);
    first.kill();
    let done = hil.journal("over").len() - 1;
    assert!(done < 250, "killed in the middle");
    let (second, alone) = (hil.start("second", &over).ends(), alone.ends());
    assert_eq!(second.status, alone.status, "{}", second.err);
    let resumed: serde_json::Value = serde_json::from_str(&second.out).unwrap();
    // A line that was incomplete when the coordinator was killed is done again.
    assert!(resumed["resumed"].as_u64().unwrap() >= done as u64, "{resumed}");
    let journal = hil.journal("over");
    assert_eq!(cases(&journal).len(), 250);
    assert_eq!(second.campaign(), alone.campaign());
}
