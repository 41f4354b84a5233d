//! A device under test that runs already: under a debugger, on another board, started by somebody else.
//!
//! It takes missions and gives reports as one that the harness starts does, one JSON line each
//! ([`controller::mission`]), but over a socket that it listens on, or over a serial line. Nothing here
//! waits for it: missions that it does not take are refused, reports that are not fetched hold it up.
//!
//! There is one connection a run. A controller that was lost and comes back has lost its heading with
//! the connection or may have; what is measured after that is not what the plan began.

mod link;
mod splitter;
#[cfg(test)]
mod tests;

use crate::process::{line_of, report_of};
use controller::mission::{Mission, ReportLine};
use plan::bench_file::AttachPlace;
use ports::spec::SpecError;
use ports::{BytePort, PortError};
use splitter::Cut;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use wire::serial::SerialSettings;

/// What a serial line of missions is set to where its port does not say: what boards with a USB serial port
/// usually have.
pub const LINE_SETTINGS: SerialSettings = SerialSettings::new_8n1(115_200);
/// Between two tries to connect. Assumption: nobody who starts a program by hand notices.
pub const RETRY: Duration = Duration::from_millis(200);
/// A try to connect is given up after this; a host that is switched off does not refuse.
pub const TRY_MAX: Duration = Duration::from_secs(2);
/// Missions that wait to be taken.
const MISSIONS_MAX: usize = 64;
/// Events that wait to be fetched; then the link fills, and then the controller waits.
const EVENTS_MAX: usize = 1_024;
/// How long missions that were accepted may take to leave, when all is over.
const CLOSE_WAIT: Duration = Duration::from_secs(1);

/// Why there is nothing to wait at.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AttachError {
    /// The port cannot be opened.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    /// The port cannot be made sense of.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Spec(#[from] SpecError),
}

/// What came of an attached device.
#[derive(Debug, Clone, PartialEq)]
pub enum AttachedEvent {
    /// It is not there, and why; it is tried again.
    NotThere(String),
    /// It is connected.
    Connected,
    /// A report. Its time is by its own clock.
    Report(Box<ReportLine>),
    /// A line that is no report.
    BadLine {
        /// Its number, from one.
        number: u64,
        /// What is wrong with it.
        cause: String,
    },
    /// The connection is lost, and why.
    Lost(String),
}

/// A device under test that somebody else has started.
#[derive(Debug)]
pub struct AttachedDevice {
    missions: mpsc::Sender<Vec<u8>>,
    events: mpsc::Receiver<AttachedEvent>,
    task: JoinHandle<()>,
    far_path: Option<String>,
}

impl AttachedDevice {
    /// Begins to connect to `place`; a line is opened at once. Called within a tokio runtime that has IO and
    /// time enabled.
    ///
    /// # Errors
    ///
    /// When the line's port cannot be opened. A socket that nobody listens on is none.
    pub fn begin(place: &AttachPlace) -> Result<Self, AttachError> {
        let (missions, taken) = mpsc::channel(MISSIONS_MAX);
        let (sender, events) = mpsc::channel(EVENTS_MAX);
        let mut far_path = None;
        let task = match place {
            AttachPlace::Unix(path) => tokio::spawn(link::unix(path.clone(), taken, sender)),
            AttachPlace::Tcp(address) => tokio::spawn(link::tcp(address.clone(), taken, sender)),
            AttachPlace::Line(port) => {
                let port = BytePort::open(&port.as_str().parse()?, LINE_SETTINGS)?;
                far_path = port.far_path().map(str::to_owned);
                tokio::spawn(link::line(port, taken, sender))
            }
        };
        Ok(Self { missions, events, task, far_path })
    }

    /// What the controller opens, where the line is a pty.
    pub fn far_path(&self) -> Option<&str> {
        self.far_path.as_deref()
    }

    /// Gives it a mission; `false` when it does not take any.
    pub fn send(&self, mission: &Mission) -> bool {
        line_of(mission).is_some_and(|line| self.missions.try_send(line).is_ok())
    }

    /// Waits for what comes next. May be called off without losing anything. After
    /// [`AttachedEvent::Lost`] nothing else comes.
    pub async fn next_event(&mut self) -> AttachedEvent {
        match self.events.recv().await {
            Some(event) => event,
            None => std::future::pending().await,
        }
    }

    /// Lets missions that were accepted leave, and closes the connection. The controller goes on.
    pub async fn end(mut self) {
        // The task ends once the last mission is written.
        self.missions = mpsc::channel(1).0;
        self.events.close();
        let _ = tokio::time::timeout(CLOSE_WAIT, &mut self.task).await;
    }
}

impl Drop for AttachedDevice {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// What a line from the controller tells; `None` for a blank one.
fn told(number: u64, cut: &Cut) -> Option<AttachedEvent> {
    let report = match cut {
        Cut::Overlong => report_of(None),
        Cut::Line(line) => report_of(Some(line)),
    };
    Some(match report? {
        Ok(report) => AttachedEvent::Report(report),
        Err(cause) => AttachedEvent::BadLine { number, cause },
    })
}
