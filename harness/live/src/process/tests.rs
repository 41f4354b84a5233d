//! Shell scripts stand in for devices under test, well-behaved and otherwise.

use super::super::lines::Places;
use super::{
    DeviceProcess, EndedBy, LOG_BYTES_MAX, ProcessEvent, ReportedLine, SpawnError, log_file,
};
use controller::mission::{Command, Mission};
use std::future::Future;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;

const LIMIT: Duration = Duration::from_secs(20);

const REPORT: &str = r#"{"at_ns":5,"report":{"refused":{"id":1,"reason":"busy"}}}"#;

fn run<T>(test: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async { tokio::time::timeout(LIMIT, test).await.expect("the test ends") })
}

fn spawn(words: &[String], log: &Path) -> Result<DeviceProcess, SpawnError> {
    DeviceProcess::spawn(words, &Places::new(), log_file(log, false)?, true)
}

fn words(script: &str) -> Vec<String> {
    ["/bin/sh", "-c", script].map(str::to_owned).to_vec()
}

struct Bench {
    _folder: TempDir,
    log: PathBuf,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("device-under-test.log");
        Self { _folder: folder, log }
    }

    fn start(&self, script: &str) -> DeviceProcess {
        spawn(&words(script), &self.log).unwrap()
    }
}

fn stop(id: u32) -> Mission {
    Mission { id, command: Command::Stop }
}

/// All events until the process has ended by itself, the exit last.
async fn all_events(process: &mut DeviceProcess) -> Vec<ProcessEvent> {
    let mut events = Vec::new();
    loop {
        events.push(process.next_event().await);
        if matches!(events.last(), Some(ProcessEvent::Exited(_))) {
            return events;
        }
    }
}

#[test]
fn missions_go_in_and_reports_come_out() {
    run(async {
        let bench = Bench::new();
        let mut process = bench.start(&format!(
            "read line; echo \"$line\" >&2; echo '{REPORT}'; cat > /dev/null; echo bye >&2"
        ));
        assert!(process.send(&stop(7)));
        assert!(matches!(process.next_event().await, ProcessEvent::Line(ReportedLine::Report(_))));
        let end = process.end(|event| panic!("{event:?}")).await;
        assert_eq!(end.by, EndedBy::StdinClosed);
        assert!(end.exit.is_success());
        let log = std::fs::read_to_string(&bench.log).unwrap();
        assert_eq!(log, "{\"id\":7,\"command\":\"stop\"}\nbye\n");
    });
}

#[test]
fn an_exit_is_told_after_everything_that_was_written() {
    run(async {
        let bench = Bench::new();
        let script = format!("echo '{REPORT}'; echo nonsense; echo no port >&2; exit 3");
        let mut process = bench.start(&script);
        let events = all_events(&mut process).await;
        let [
            ProcessEvent::Line(ReportedLine::Report(_)),
            ProcessEvent::Line(ReportedLine::Bad { number: 2, .. }),
            last,
        ] = &events[..]
        else {
            panic!("{events:?}")
        };
        let ProcessEvent::Exited(exit) = last else { panic!("{last:?}") };
        assert_eq!(exit.to_string(), "exit status: 3");
        assert_eq!(exit.in_words(), "exited during the run (status 3)");
        assert_eq!(process.next_event().await, *last);
        assert_eq!(process.last_words(), "no port");
        assert_eq!(process.end(|_| ()).await.by, EndedBy::Itself);
    });
}

#[test]
fn a_killed_process_is_told_by_its_signal() {
    run(async {
        let bench = Bench::new();
        let mut process = bench.start("kill -SEGV $$");
        let ProcessEvent::Exited(exit) = process.next_event().await else { panic!("no exit") };
        assert!(exit.to_string().contains("SIGSEGV"), "{exit}");
        let words = exit.in_words();
        assert!(words.starts_with("was ended during the run by signal 11 (SIGSEGV)"), "{words}");
        assert!(!exit.is_success());
    });
}

#[test]
fn one_that_ignores_its_stdin_is_terminated_and_one_that_ignores_that_is_killed() {
    run(async {
        let bench = Bench::new();
        let deaf = bench.start("exec sleep 600");
        let stubborn_bench = Bench::new();
        let stubborn = stubborn_bench.start("trap '' TERM; while :; do sleep 0.1; done");
        let (deaf, stubborn) = tokio::join!(deaf.end(|_| ()), stubborn.end(|_| ()));
        assert_eq!(deaf.by, EndedBy::Terminated);
        assert!(deaf.exit.to_string().contains("SIGTERM"), "{}", deaf.exit);
        assert_eq!(stubborn.by, EndedBy::Killed);
    });
}

#[test]
fn what_it_started_ends_with_it() {
    run(async {
        let bench = Bench::new();
        // The sleeper holds stdout and stderr open.
        let mut process = bench.start("sleep 600 & echo $! >&2; exit 0");
        let events = all_events(&mut process).await;
        assert!(matches!(events[..], [ProcessEvent::Exited(_)]), "{events:?}");
        let sleeper = process.last_words();
        process.end(|_| ()).await;
        let status = format!("/proc/{sleeper}/status");
        // Waits until it is gone or is a zombie; the test has a time limit.
        while std::fs::read_to_string(&status).is_ok_and(|text| !text.contains("State:\tZ")) {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    });
}

#[test]
fn one_that_takes_nothing_costs_missions_and_no_time() {
    run(async {
        let bench = Bench::new();
        let mut process = bench.start("exec sleep 600");
        let sent = (0..100_000).filter(|id| process.send(&stop(*id))).count();
        assert!(sent < 100_000);
        assert_eq!(process.missions_lost(), 100_000 - sent as u64);
        drop(process);
    });
}

#[test]
fn one_that_floods_is_bounded_and_still_heard() {
    run(async {
        let bench = Bench::new();
        let mut process = bench.start(&format!(
            "head -c 20000000 /dev/zero >&2; yes '{REPORT}' | head -n 5000; echo done >&2"
        ));
        let events = all_events(&mut process).await;
        assert_eq!(events.len(), 5_001);
        process.end(|_| ()).await;
        let length = std::fs::metadata(&bench.log).unwrap().len();
        assert!((LOG_BYTES_MAX as u64..LOG_BYTES_MAX as u64 + 100).contains(&length), "{length}");
    });
}

#[test]
fn one_that_closes_stdout_is_watched_until_it_ends() {
    run(async {
        let bench = Bench::new();
        let mut process = bench.start("exec >&-; sleep 0.2; exit 4");
        let ProcessEvent::Exited(exit) = process.next_event().await else { panic!("no exit") };
        assert_eq!(exit.to_string(), "exit status: 4");
    });
}

#[test]
fn a_program_that_is_not_there_is_named() {
    run(async {
        let bench = Bench::new();
        let words = ["/no/such/program".to_owned()];
        let error = spawn(&words, &bench.log).unwrap_err();
        assert!(error.to_string().contains("/no/such/program"), "{error}");
        assert!(matches!(error, SpawnError::Program { advice, .. } if advice.contains("PATH")));
        let error = spawn(&[], &bench.log).unwrap_err();
        assert!(matches!(error, SpawnError::Program { .. }));
        let error = spawn(&words, "/no/folder/x".as_ref()).unwrap_err();
        assert!(matches!(error, SpawnError::Log { .. }));
    });
}
