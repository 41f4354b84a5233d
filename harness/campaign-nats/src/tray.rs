//! What the coordinator waits for, what arrived before it was asked for, and what is not kept yet.

use super::job::Done;
use super::message::{Came, Report, id_of};
use async_nats::jetstream::Message;
use campaign::WINDOW;
use std::collections::BTreeMap;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// Results that nobody has asked for yet, at most: those of a campaign that was interrupted. What is beyond stays on the
/// server until it is sent again.
const EARLY_MAX: usize = 4 * WINDOW as usize;

/// A result that arrived.
pub(super) struct Arrived {
    pub(super) done: Done,
    /// To be acknowledged once the result is kept.
    pub(super) message: Message,
}

/// A case that is out.
pub(super) struct Asked {
    /// How it is handed out; ends when the case is on the stream.
    pub(super) handing_out: JoinHandle<()>,
    /// Its case, to be handed out again.
    pub(super) body: Vec<u8>,
    waiting: Vec<oneshot::Sender<Done>>,
}

/// Cases by name.
#[derive(Default)]
pub(super) struct Tray {
    pub(super) asked: BTreeMap<String, Asked>,
    early: BTreeMap<String, Arrived>,
    /// Told of, and not kept yet.
    told: BTreeMap<String, Vec<Message>>,
}

/// What a message turned out to be.
pub(super) enum Read {
    /// Whoever asked has it, or will.
    Taken,
    /// A worker refuses the campaign.
    Refused { message: Message, worker: String, cause: String },
    /// It cannot be read.
    Unreadable { message: Message, cause: String },
}

impl Tray {
    /// Somebody wants what comes of a case.
    pub(super) fn ask(&mut self, id: &str, answer: oneshot::Sender<Done>) -> Asking {
        if let Some(arrived) = self.early.remove(id) {
            self.told.entry(id.to_owned()).or_default().push(arrived.message);
            // Who asked may have gone.
            let _ = answer.send(arrived.done);
            return Asking::Known;
        }
        match self.asked.get_mut(id) {
            Some(asked) => {
                asked.waiting.push(answer);
                Asking::Known
            }
            None => Asking::New(answer),
        }
    }

    /// It is being handed out.
    pub(super) fn out(
        &mut self,
        id: String,
        body: Vec<u8>,
        handing_out: JoinHandle<()>,
        answer: oneshot::Sender<Done>,
    ) {
        self.asked.insert(id, Asked { handing_out, body, waiting: vec![answer] });
    }

    /// A result arrived.
    pub(super) fn arrived(&mut self, message: Message) -> Read {
        let id = id_of(&message.subject).to_owned();
        let report: Report = match serde_json::from_slice(&message.payload) {
            Ok(report) => report,
            Err(error) => return Read::Unreadable { message, cause: error.to_string() },
        };
        let done = match report.came {
            Came::Done(done) => done,
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
            // It came a second time, and counts once.
            told.push(message);
        } else if self.early.len() < EARLY_MAX {
            self.early.insert(id, Arrived { done, message });
        }
        Read::Taken
    }

    /// The result of a case is kept: its messages may go.
    pub(super) fn kept(&mut self, id: &str) -> Vec<Message> {
        self.told.remove(id).unwrap_or_default()
    }

    /// Nobody waits any longer.
    pub(super) fn give_up(&mut self) {
        for (_, asked) in std::mem::take(&mut self.asked) {
            asked.handing_out.abort();
            for waiting in asked.waiting {
                let _ = waiting.send(Done::given_up());
            }
        }
    }
}

/// Whether a case is new.
pub(super) enum Asking {
    /// It is out already, or its result is here.
    Known,
    /// It has to be handed out.
    New(oneshot::Sender<Done>),
}
