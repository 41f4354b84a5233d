//! Utilisation of workers in a campaign over a local NATS server. Cases take 10 ms each without using a processor, so
//! the benchmark measures the waiting for each other, the server and the coordinator.
//!
//! `cargo bench -p harness --bench nats`. Requires `nats-server` (the Debian package of that name).

use campaign::{Case, CaseResult, Executor, Journal, Search, Settings, WINDOW, run};
use campaign_nats::{
    Credentials, Holder, Package, Place, Remote, RemoteSettings, Server, Stopping, WorkerSettings,
    work,
};
use harness::operator::Answers;
use std::collections::BTreeMap;
use std::net::{TcpListener, TcpStream};
use std::num::NonZeroUsize;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

/// Duration of one case.
const CASE: Duration = Duration::from_millis(10);
/// Number of cases per measurement and worker thread.
const CASES: u64 = 500;

fn main() {
    // `cargo test --benches` only checks that it starts.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let Some(server) = NatsServer::start() else {
        println!("there is no nats-server: apt-get install nats-server");
        return;
    };
    println!(
        "| workers | threads each | cases | busy, % (aim 90) | cases/s |\n|---|---|---|---|---|"
    );
    for (workers, threads) in [(1, 1), (3, 1), (3, 4), (8, 2)] {
        let cases = CASES * (workers * threads) as u64;
        let (busy, took) = measured(&server.url, workers, threads, cases);
        let all = took.as_secs_f64() * (workers * threads) as f64;
        let (share, rate) = (busy.as_secs_f64() / all, cases as f64 / took.as_secs_f64());
        println!("| {workers} | {threads} | {cases} | {:.1} | {rate:.0} |", 100.0 * share);
    }
}

/// Sleeps, and adds up the actual time.
struct Sleeps {
    busy_ns: AtomicU64,
}

impl Executor for Sleeps {
    #[expect(clippy::disallowed_methods, reason = "takes the time of what it measures")]
    fn execute(&self, _: &Case) -> CaseResult {
        let begin = Instant::now();
        sleep(CASE);
        let took = u64::try_from(begin.elapsed().as_nanos()).unwrap_or(u64::MAX);
        self.busy_ns.fetch_add(took, Ordering::Relaxed);
        CaseResult::default()
    }
}

/// Cases that differ only in their seeds.
struct Counting(u64);

impl Search for Counting {
    fn next(&mut self) -> Case {
        self.0 += 1;
        Case { seed: self.0, ..Case::default() }
    }

    fn learn(&mut self, _: &Case, _: &CaseResult) {}
}

/// Total busy time of all workers, and the duration of the campaign.
#[expect(clippy::disallowed_methods, reason = "takes the time of what it measures")]
fn measured(url: &str, workers: usize, threads: usize, cases: u64) -> (Duration, Duration) {
    let server = Server::new(&[url.to_owned()], Credentials::default()).expect("an address");
    let sleeps = Arc::new(Sleeps { busy_ns: AtomicU64::new(0) });
    let stop = AtomicBool::new(false);
    let took = scope(|scope| {
        for number in 0..workers {
            let (server, sleeps, stop) = (&server, Arc::clone(&sleeps), &stop);
            scope.spawn(move || {
                let settings = WorkerSettings {
                    place: Place::Virtual,
                    threads: NonZeroUsize::new(threads).expect("some"),
                    holder: Holder::named(format!("worker {number}")),
                    version: record::VERSION.to_owned(),
                    patience: Duration::ZERO,
                };
                let maker = Arc::new(move |_: &Package, _: Stopping| {
                    let executor = Arc::clone(&sleeps) as Arc<dyn Executor + Send + Sync>;
                    Ok(("sleeps".to_owned(), executor))
                });
                let stop = || stop.load(Ordering::Relaxed);
                work(server, &settings, maker, Arc::new(|_| ()), stop).expect("a worker");
            });
        }
        let package = Package::of("live-side", &Answers::default()).expect("a shipped plan");
        let settings = RemoteSettings {
            what: format!("{workers} workers with {threads} threads each"),
            place: Place::Virtual,
            holder: Holder::named("the benchmark"),
        };
        let remote = Remote::open(&server, &package, settings, Local, Arc::new(|_| ()), || false)
            .expect("a campaign");
        // The first cases wait for connections and the package; the start of a worker is not measured.
        for seed in 0..4 * (workers * threads) as u64 {
            let case = Case { seed: u64::MAX - seed, ..Case::default() };
            remote.execute(&case);
            remote.kept(&case);
        }
        sleeps.busy_ns.store(0, Ordering::Relaxed);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("cases.jsonl");
        let mut journal = Journal::open(&path, "benchmark").expect("a journal");
        let settings = Settings {
            cases,
            threads: NonZeroUsize::new(WINDOW as usize).expect("some"),
            shrink_max: 0,
        };
        let states = BTreeMap::new();
        let begin = Instant::now();
        let done = run(&remote, &mut Counting(0), &states, &settings, &mut journal, &mut |_| true);
        let took = begin.elapsed();
        assert_eq!(done.expect("a journal").tally.cases, cases);
        remote.finish(Vec::new()).expect("the end");
        stop.store(true, Ordering::Relaxed);
        took
    });
    (Duration::from_nanos(sleeps.busy_ns.load(Ordering::Relaxed)), took)
}

/// The coordinator's machine carries out no cases.
struct Local;

impl Executor for Local {
    fn execute(&self, case: &Case) -> CaseResult {
        unreachable!("{case:?}")
    }
}

struct NatsServer {
    child: Child,
    url: String,
    _store: tempfile::TempDir,
}

impl NatsServer {
    #[expect(clippy::disallowed_methods, reason = "waits for another process")]
    fn start() -> Option<Self> {
        let debian = std::path::Path::new("/usr/sbin/nats-server");
        let program = if debian.is_file() { debian } else { "nats-server".as_ref() };
        let store = tempfile::tempdir().ok()?;
        let port = TcpListener::bind("127.0.0.1:0").ok()?.local_addr().ok()?.port();
        let child = Command::new(program)
            .args(["--jetstream", "--addr", "127.0.0.1", "--port", &port.to_string()])
            .arg("--store_dir")
            .arg(store.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        while TcpStream::connect(("127.0.0.1", port)).is_err() {
            sleep(Duration::from_millis(10));
        }
        Some(Self { child, url: format!("nats://127.0.0.1:{port}"), _store: store })
    }
}

impl Drop for NatsServer {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
