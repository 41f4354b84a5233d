//! SDO transfers of the plan: requests as messages that a tester sends, answers as messages of the device.

use super::{Action, Engine, Waiting};
use described::{
    Abort, Decoded, Dictionary, Entry, Progress, SDO_RESPONSE, SdoClient, SignalValue,
};
use plan::{Order, Sdo, Send, Speaker, canopen_devices};
use record::figures;
use record::outcome::Outcome;
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::time::{Span, Timestamp};

/// Signals of the messages that carry the eight bytes of a transfer: name, first byte, number of bytes.
const PARTS: [(&str, usize, usize); 4] =
    [("command", 0, 1), ("index", 1, 2), ("sub", 3, 1), ("data", 4, 4)];

/// The CANopen devices of a rig, and the transfer under way.
#[derive(Debug, Clone, Default)]
pub(super) struct Transfers {
    devices: Vec<Device>,
    running: Option<Running>,
}

#[derive(Debug, Clone)]
struct Device {
    node: String,
    speaker: usize,
    dictionary: Arc<Dictionary>,
    /// The message that carries requests to it.
    request: String,
}

#[derive(Debug, Clone)]
struct Running {
    client: SdoClient,
    step: Sdo,
    device: Device,
}

impl Transfers {
    pub(super) fn of(speakers: &[Speaker]) -> Self {
        let device = |(speaker, known, request): (usize, &Speaker, String)| {
            let dictionary = Arc::clone(known.layout.dictionary()?);
            Some(Device { node: known.node.clone(), speaker, dictionary, request })
        };
        Self { devices: canopen_devices(speakers).filter_map(device).collect(), running: None }
    }

    /// When the answer of the device is overdue.
    pub(super) fn deadline(&self) -> Timestamp {
        self.running.as_ref().map_or(Timestamp::MAX, |running| running.client.deadline())
    }
}

/// The request with these bytes, as a message.
fn request(message: &str, words: [u8; 8]) -> Send {
    let value = |(name, first, length): (&str, usize, usize)| {
        let number = words[first..first + length].iter().rev();
        let number = number.fold(0u32, |number, byte| number << 8 | u32::from(*byte));
        (name.to_owned(), f64::from(number).into())
    };
    let set: BTreeMap<String, SignalValue> = PARTS.into_iter().map(value).collect();
    Send { message: message.to_owned(), set, every: Some(Span::ZERO) }
}

/// The bytes of an answer.
fn words(decoded: &Decoded<'_>) -> Option<[u8; 8]> {
    let mut words = [0; 8];
    for (name, first, length) in PARTS {
        let place = decoded.form.signals.iter().position(|signal| signal.name == name)?;
        let number = (*decoded.values.get(place)?)? as u32;
        words[first..first + length].copy_from_slice(&number.to_le_bytes()[..length]);
    }
    Some(words)
}

impl Engine {
    pub(super) fn begin_sdo(&mut self, now: Timestamp, step: Sdo) {
        let device = self.transfers.devices.iter().find(|device| device.node == step.node());
        let Some(device) = device.cloned() else {
            return self.broke(now, &format!("no EDS says which objects `{}` has", step.node()));
        };
        let entry = device.dictionary.find(step.index, step.sub);
        let bytes = step.write.and_then(|value| entry.ok()?.bytes(value));
        let (client, words) = SdoClient::new(now, (step.index, step.sub), bytes);
        self.transfers.running = Some(Running { client, step, device });
        self.waiting = Waiting::Sdo;
        self.request(words);
    }

    fn request(&mut self, words: [u8; 8]) {
        let Some(running) = &self.transfers.running else { return };
        let message = request(&running.device.request, words);
        self.actions.push_back(Action::Order(Order::Send(message)));
    }

    /// Takes a message of a speaker, which may be the answer to a request.
    pub(super) fn answer_sdo(&mut self, now: Timestamp, speaker: usize, decoded: &Decoded<'_>) {
        let Some(running) = &mut self.transfers.running else { return };
        if running.device.speaker != speaker || decoded.form.name != SDO_RESPONSE {
            return;
        }
        let Some(words) = words(decoded) else { return };
        match running.client.receive(now, &words) {
            Progress::Nothing => {}
            Progress::Send(next) => self.request(next),
            Progress::Done(bytes) => self.end_sdo(now, Ok(bytes)),
            Progress::Aborted(why) => self.end_sdo(now, Err(why)),
            Progress::Senseless(why) => {
                self.give_up_sdo(now, why, &format!("the answer makes no sense: {why}"));
            }
        }
    }

    /// Gives up a transfer whose answer is overdue.
    pub(super) fn check_sdo(&mut self, now: Timestamp) {
        if let Some(running) = &self.transfers.running
            && self.waiting == Waiting::Sdo
            && running.client.deadline() <= now
        {
            let mut reason = "the device does not answer".to_owned();
            if let Some((index, sub)) = running.client.other() {
                reason += &format!("; an answer for {index:04X}sub{sub:X} came");
            }
            self.give_up_sdo(now, Abort::TIMEOUT, &reason);
        }
    }

    fn give_up_sdo(&mut self, now: Timestamp, why: Abort, reason: &str) {
        let Some(running) = &self.transfers.running else { return };
        let words = running.client.give_up(why);
        self.request(words);
        self.transfers.running = None;
        self.end_here(now, Outcome::Failed, reason);
    }

    fn end_sdo(&mut self, now: Timestamp, how: Result<Vec<u8>, Abort>) {
        let Some(Running { step, device, client }) = self.transfers.running.take() else { return };
        let wanted = step.abort.map(Abort);
        let reason = match (&how, wanted) {
            (Err(why), Some(wanted)) if *why == wanted => None,
            (Err(why), None) => Some(format!("the device aborts with {why}")),
            (Err(why), Some(wanted)) => {
                Some(format!("the device aborts with {why}, expected {wanted}"))
            }
            (Ok(_), Some(wanted)) => {
                Some(format!("the device does it, expected an abort with {wanted}"))
            }
            (Ok(_), None) => None,
        };
        if let Some(reason) = reason {
            return self.end_here(now, Outcome::Failed, &reason);
        }
        if let (Ok(bytes), Some(quantity)) = (&how, step.quantity()) {
            let entry = device.dictionary.find(step.index, step.sub).ok();
            let length = entry.and_then(Entry::length).unwrap_or_default();
            let its = if client.says_length() { bytes } else { &bytes[..length.min(bytes.len())] };
            let Some(value) = entry.and_then(|entry| entry.value(its)) else {
                let bytes = figures::counted(bytes.len() as u64, "byte", "bytes");
                let why = format!("the answer has {bytes}, expected {length}");
                return self.end_here(now, Outcome::Failed, &why);
            };
            self.observe(now, |collector| collector.add_named(&quantity, value, 0.0, &[]));
        }
        self.waiting = Waiting::Nothing;
        self.advance(now);
    }
}
