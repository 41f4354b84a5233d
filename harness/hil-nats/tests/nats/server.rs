//! A NATS server for one test, with its own port and store.

use super::hil::{PATIENCE, wait_for};
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead as _, BufReader};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// If set, a missing server is a failure.
const REQUIRED: &str = "HIL_TESTS_NEED_NATS";

/// A server that is stopped with the test.
pub struct Server {
    store: TempDir,
    port: u16,
    arguments: Vec<String>,
    child: Option<Child>,
}

impl Server {
    /// Starts a server, or skips the test if no server is installed.
    pub fn start() -> Option<Self> {
        Self::start_with(&[])
    }

    /// Starts a server with more arguments.
    pub fn start_with(arguments: &[&str]) -> Option<Self> {
        if Command::new(program()).arg("--version").stdout(Stdio::null()).status().is_err() {
            skips::skip_unless(
                REQUIRED,
                "there is no nats-server",
                "apt-get install nats-server, then cargo test -p hil-nats",
            );
            return None;
        }
        let free = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
        let arguments = arguments.iter().map(|&argument| argument.to_owned()).collect();
        let store = tempfile::tempdir().unwrap();
        let mut server = Self { store, port, arguments, child: None };
        server.start_again();
        Some(server)
    }

    /// Starts it again with its store.
    pub fn start_again(&mut self) {
        let child = Command::new(program())
            .args(["--jetstream", "--addr", "127.0.0.1", "--port", &self.port.to_string()])
            .arg("--store_dir")
            .arg(self.store.path())
            .args(&self.arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        self.child = Some(child.unwrap());
        wait_for("the server", || self.answers());
    }

    fn answers(&self) -> bool {
        let Ok(stream) = TcpStream::connect(("127.0.0.1", self.port)) else { return false };
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).is_ok() && line.starts_with("INFO ")
    }

    /// Kills it: it cannot clean up.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            child.kill().unwrap();
            child.wait().unwrap();
        }
    }

    /// Stops it in order.
    pub fn stop(&mut self) {
        if let Some(mut child) = self.child.take() {
            kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
            child.wait().unwrap();
        }
    }

    /// Returns host and port.
    pub fn address(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn url(&self) -> String {
        format!("nats://{}", self.address())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Runs requests to the server without `hil`.
#[track_caller]
pub fn say<T>(said: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let said = runtime.unwrap().block_on(async { tokio::time::timeout(PATIENCE, said).await });
    said.expect("the server answers")
}

/// Returns the number of cases on the stream, waiting or taken.
pub fn cases_waiting(url: &str) -> u64 {
    messages(url, "HIL_CASES")
}

pub fn messages(url: &str, stream: &str) -> u64 {
    say(async {
        let jetstream = async_nats::jetstream::new(async_nats::connect(url).await.unwrap());
        let stream = jetstream.get_stream(stream).await.unwrap();
        stream.cached_info().state.messages
    })
}

fn program() -> std::ffi::OsString {
    let debian = "/usr/sbin/nats-server";
    // The folder of servers is not in every user's path.
    if std::path::Path::new(debian).is_file() { debian.into() } else { "nats-server".into() }
}
