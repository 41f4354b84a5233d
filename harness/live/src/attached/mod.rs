//! A device under test that runs already: under a debugger, on another board, or started by the user.
//!
//! It takes missions and reports like a device started by the harness, one JSON line each ([`controller::mission`]),
//! but over a socket on which it listens, or over a serial line. Nothing here blocks on it: missions that it does not
//! take are refused, and unfetched reports hold it up.
//!
//! There is one connection per run. A controller that was lost and returns has, or may have, lost its heading, so what
//! is measured after that no longer belongs to what the plan began.

mod link;
#[cfg(test)]
mod tests;

use crate::process::{ReportedLine, line_of};
use controller::mission::Mission;
use plan::bench_file::AttachPlace;
use ports::spec::SpecError;
use ports::{BytePort, PortError};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use wire::serial::SerialSettings;

/// Default settings of a serial line of missions, which boards with a USB serial port usually have.
pub const LINE_SETTINGS: SerialSettings = SerialSettings::new_8n1(115_200);
/// Time between two attempts to connect. Assumption: too short for a user who starts a program by hand to notice.
pub const RETRY: Duration = Duration::from_millis(200);
/// Time limit of an attempt to connect; a host that is switched off does not refuse.
pub const TRY_MAX: Duration = Duration::from_secs(2);
const MISSIONS_MAX: usize = 64;
/// Most events that wait to be fetched; beyond that the link fills, and then the controller waits.
const EVENTS_MAX: usize = 1_024;
/// Time for accepted missions to leave at the end.
const CLOSE_WAIT: Duration = Duration::from_secs(1);

#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AttachError {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Spec(#[from] SpecError),
}

#[derive(Debug, Clone, PartialEq)]
pub enum AttachedEvent {
    /// It is not there, with the reason; the connection is retried.
    NotThere(String),
    Connected,
    Line(ReportedLine),
    /// It closed the connection, with the reason.
    Ended(String),
    /// The port to it is lost, with the reason.
    Lost(String),
}

/// A device under test that was not started by the harness.
#[derive(Debug)]
pub struct AttachedDevice {
    missions: mpsc::Sender<Vec<u8>>,
    events: mpsc::Receiver<AttachedEvent>,
    task: JoinHandle<()>,
    far_path: Option<String>,
}

impl AttachedDevice {
    /// Begins to connect to `place`; opens a line at once. Needs a tokio runtime with IO and time enabled.
    ///
    /// # Errors
    /// When the line's port cannot be opened. A socket without a listener is no error.
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

    /// Path that the controller opens, if the line is a pty.
    pub fn far_path(&self) -> Option<&str> {
        self.far_path.as_deref()
    }

    /// Sends a mission; `false` if the device does not take it.
    pub fn send(&self, mission: &Mission) -> bool {
        line_of(mission).is_some_and(|line| self.missions.try_send(line).is_ok())
    }

    /// Waits for the next event. Cancel-safe. After [`AttachedEvent::Lost`] no more events come.
    pub async fn next_event(&mut self) -> AttachedEvent {
        match self.events.recv().await {
            Some(event) => event,
            None => std::future::pending().await,
        }
    }

    /// Lets accepted missions leave and closes the connection. The controller goes on.
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
