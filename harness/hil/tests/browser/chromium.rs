//! A headless Chromium, controlled by its own protocol (Chrome DevTools Protocol) through a pipe.
//!
//! `--remote-debugging-pipe` reads messages from descriptor 3 and writes them to 4, each a JSON text ended by a zero
//! byte. The crates for this protocol bring an HTTP client, a web socket and code for thousands of messages; a dozen
//! are needed.

use serde_json::{Value, json};
use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use tempfile::TempDir;

/// Names of the program in distributions.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Longer than any answer takes on a busy machine.
const ANSWER_MAX: Duration = Duration::from_secs(120);

/// Returns the path of this machine's browser, if there is one.
pub fn program() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let all = NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    all.into_iter().find(|program| program.is_file())
}

/// A browser with one page.
pub struct Browser {
    child: Child,
    to: File,
    said: Receiver<Value>,
    next_id: u64,
    session: Option<String>,
    /// Events since the last request for them.
    events: Vec<Value>,
    _folder: TempDir,
}

impl Browser {
    pub fn start(program: &Path) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [to, from] = ["to", "from"].map(|name| folder.path().join(name));
        for pipe in [&to, &from] {
            let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
            rustix::fs::mknodat(rustix::fs::CWD, pipe, rustix::fs::FileType::Fifo, mode, 0)
                .unwrap();
        }
        // The shell provides the two descriptors. The browser may run as root, where its sandbox does not work; it
        // shows only our own files.
        let child = Command::new("sh")
            .args(["-c", r#"to=$1 from=$2; shift 2; exec "$@" 3<"$to" 4>"$from""#, "sh"])
            .args([&to, &from])
            .arg(program)
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run"])
            .args(["--remote-debugging-pipe", "--disable-dev-shm-usage"])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // In the order in which the shell opens the other ends.
        let to = OpenOptions::new().write(true).open(to).unwrap();
        let from = File::open(from).unwrap();
        let (say, said) = channel();
        std::thread::spawn(move || {
            let mut from = BufReader::new(from);
            let mut message = Vec::new();
            while from.read_until(0, &mut message).is_ok_and(|length| length > 0) {
                message.pop();
                let Ok(value) = serde_json::from_slice(&message) else { return };
                if say.send(value).is_err() {
                    return;
                }
                message.clear();
            }
        });
        let mut browser = Self {
            child,
            to,
            said,
            next_id: 0,
            session: None,
            events: Vec::new(),
            _folder: folder,
        };
        let page = browser.ask("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": page["targetId"], "flatten": true });
        let session = browser.ask("Target.attachToTarget", attach)["sessionId"].clone();
        browser.session = session.as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Sends a command and waits for the answer.
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.next_id += 1;
        let id = self.next_id;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        let mut bytes = message.to_string().into_bytes();
        bytes.push(0);
        self.to.write_all(&bytes).unwrap();
        loop {
            let mut heard = self.hear(method);
            if heard["id"] == id {
                assert!(heard["error"].is_null(), "{method}: {}", heard["error"]);
                return heard["result"].take();
            }
            self.events.push(heard);
        }
    }

    fn hear(&self, what: &str) -> Value {
        self.said.recv_timeout(ANSWER_MAX).unwrap_or_else(|error| panic!("{what}: {error}"))
    }

    /// Opens a file and waits until it is loaded; returns the events meanwhile.
    pub fn open(&mut self, file: &Path) -> Vec<Value> {
        self.events.clear();
        self.ask("Page.navigate", json!({ "url": format!("file://{}", file.display()) }));
        while !self.events.iter().any(|event| event["method"] == "Page.loadEventFired") {
            let heard = self.hear("load");
            self.events.push(heard);
        }
        std::mem::take(&mut self.events)
    }

    /// Evaluates an expression in the page.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true });
        let mut answer = self.ask("Runtime.evaluate", asked);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Sets how the page is displayed from now on.
    pub fn look(&mut self, view: &View) {
        let scheme = json!([{ "name": "prefers-color-scheme", "value": view.scheme }]);
        self.ask("Emulation.setEmulatedMedia", json!({ "media": view.media, "features": scheme }));
        let size = json!({ "width": view.width, "height": view.height, "deviceScaleFactor": 2, "mobile": view.mobile });
        self.ask("Emulation.setDeviceMetricsOverride", size);
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It ends when its pipe closes; killed so that it cannot outlive a test.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A display mode of a page.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub name: &'static str,
    pub media: &'static str,
    pub scheme: &'static str,
    pub width: u32,
    pub height: u32,
    pub mobile: bool,
}

const DESK: View = View {
    name: "light",
    media: "screen",
    scheme: "light",
    width: 1280,
    height: 900,
    mobile: false,
};

/// All display modes in which a page must be legible. The narrow one is that of common phones.
pub const VIEWS: [View; 4] = [
    DESK,
    View { name: "dark", scheme: "dark", ..DESK },
    View { name: "phone", width: 360, height: 780, mobile: true, ..DESK },
    View { name: "dark phone", scheme: "dark", width: 360, height: 780, mobile: true, ..DESK },
];
