//! The coordinator's bookkeeping: cases it waits for, results that arrived early, and results not stored yet.

use super::job::Done;
use super::message::{Came, Report, id_of};
use async_nats::jetstream::Message;
use campaign::WINDOW;
use std::collections::BTreeMap;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// The most results that arrived before they were requested: those of an interrupted campaign. Further ones stay on the
/// server until they are sent again.
const EARLY_MAX: usize = 4 * WINDOW as usize;

pub(super) struct Arrived {
    pub(super) done: Done,
    /// Acknowledged once the result is stored.
    pub(super) message: Message,
}

pub(super) struct Asked {
    /// The task that hands it out; ends when the case is on the stream.
    pub(super) handing_out: JoinHandle<()>,
    /// Its text, to hand it out again.
    pub(super) body: Vec<u8>,
    waiting: Vec<oneshot::Sender<Done>>,
}

#[derive(Default)]
pub(super) struct Tray {
    pub(super) asked: BTreeMap<String, Asked>,
    early: BTreeMap<String, Arrived>,
    /// Passed on, but not stored yet.
    told: BTreeMap<String, Vec<Message>>,
}

pub(super) enum Read {
    /// A result; the requester has it or will get it.
    Taken,
    /// A worker rejects the campaign.
    Refused {
        message: Message,
        worker: String,
        cause: String,
    },
    Unreadable {
        message: Message,
        cause: String,
    },
}

impl Tray {
    /// Requests the result of a case; returns `answer` if it has not been handed out.
    pub(super) fn ask(
        &mut self,
        id: &str,
        answer: oneshot::Sender<Done>,
    ) -> Option<oneshot::Sender<Done>> {
        if let Some(arrived) = self.early.remove(id) {
            self.told.entry(id.to_owned()).or_default().push(arrived.message);
            // The receiver may be gone.
            let _ = answer.send(arrived.done);
            return None;
        }
        match self.asked.get_mut(id) {
            Some(asked) => {
                asked.waiting.push(answer);
                None
            }
            None => Some(answer),
        }
    }

    /// Registers a case that is being handed out.
    pub(super) fn out(
        &mut self,
        id: String,
        body: Vec<u8>,
        handing_out: JoinHandle<()>,
        answer: oneshot::Sender<Done>,
    ) {
        self.asked.insert(id, Asked { handing_out, body, waiting: vec![answer] });
    }

    pub(super) fn arrived(&mut self, message: Message) -> Read {
        let id = id_of(&message.subject).to_owned();
        let report: Report = match serde_json::from_slice(&message.payload) {
            Ok(report) => report,
            Err(error) => return Read::Unreadable { message, cause: error.to_string() },
        };
        let done = match report.came {
            Came::Done(done) => *done,
            Came::Refused(cause) => {
                return Read::Refused { message, worker: report.worker, cause };
            }
        };
        if let Some(asked) = self.asked.remove(&id) {
            asked.handing_out.abort();
            self.told.entry(id).or_default().push(message);
            for waiting in asked.waiting {
                let _ = waiting.send(done.clone());
            }
        } else if let Some(told) = self.told.get_mut(&id) {
            // A duplicate result, which counts once.
            told.push(message);
        } else if self.early.len() < EARLY_MAX {
            self.early.insert(id, Arrived { done, message });
        }
        Read::Taken
    }

    /// The result of a case has been stored: returns its messages, to be acknowledged.
    pub(super) fn kept(&mut self, id: &str) -> Vec<Message> {
        self.told.remove(id).unwrap_or_default()
    }

    pub(super) fn give_up(&mut self) {
        for (_, asked) in std::mem::take(&mut self.asked) {
            asked.handing_out.abort();
            for waiting in asked.waiting {
                let _ = waiting.send(Done::given_up());
            }
        }
    }
}
