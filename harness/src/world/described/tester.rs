//! The plan's end of the line: it sends what the plan orders, again and again where it is to, and reads what the device
//! says.

use crate::engine::Engine;
use crate::plan::Send;
use described::{Decoded, Decoder, Description, Message, Sender};
use std::collections::VecDeque;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Everybody on the line but the device.
#[derive(Debug)]
pub(in crate::world) struct Tester {
    description: Arc<Description>,
    /// Of each message, what its signals were set to last.
    values: Vec<Vec<f64>>,
    /// Of each message that is sent again and again, how often, and when next.
    again: Vec<Option<(Span, Timestamp)>>,
    decoder: Decoder,
    outgoing: VecDeque<Transmit>,
}

impl Tester {
    pub(in crate::world) fn new(description: Arc<Description>) -> Self {
        let layout = description.layout();
        let start = |message: &Message| message.signals.iter().map(|signal| signal.start).collect();
        Self {
            values: layout.messages().iter().map(start).collect(),
            again: vec![None; layout.messages().len()],
            decoder: layout.decoder_for(Sender::Device),
            outgoing: VecDeque::new(),
            description,
        }
    }

    /// Sends a message now, and again as often as it says, or as the layout does.
    ///
    /// # Errors
    ///
    /// When the layout has no such message or signal, or a value does not fit in.
    pub(in crate::world) fn send(&mut self, now: Timestamp, send: &Send) -> Result<(), String> {
        let layout = self.description.layout();
        let Some(message) = layout.find(&send.message) else {
            return Err(format!("no message `{}` in the layout of the device", send.message));
        };
        let form = &layout.messages()[message];
        for (name, value) in &send.set {
            let Some(signal) = form.signals.iter().position(|signal| signal.name == *name) else {
                return Err(format!("`{}` has no signal `{name}`", send.message));
            };
            self.values[message][signal] = *value;
        }
        let every = send.every.or(form.period).filter(|every| *every > Span::ZERO);
        self.again[message] = every.map(|every| (every, now + every));
        self.encode(message)
    }

    /// This message is no longer sent again.
    pub(in crate::world) fn stop(&mut self, message: &str) {
        if let Some(message) = self.description.layout().find(message) {
            self.again[message] = None;
        }
    }

    /// When a message is to be sent again.
    pub(in crate::world) fn next_wakeup(&self) -> Timestamp {
        let dues = self.again.iter().flatten().map(|(_, due)| *due);
        dues.min().unwrap_or(Timestamp::MAX)
    }

    /// Sends again what is due.
    ///
    /// # Errors
    ///
    /// When a value does not fit in.
    pub(in crate::world) fn wake(&mut self, now: Timestamp) -> Result<(), String> {
        for message in 0..self.again.len() {
            let Some((every, due)) = self.again[message].filter(|(_, due)| *due <= now) else {
                continue;
            };
            // What real time has missed is left out, and not made up for in a burst.
            let missed = (now - due).as_nanos() / every.as_nanos();
            self.again[message] = Some((every, due + every * (missed + 1)));
            self.encode(message)?;
        }
        Ok(())
    }

    /// The next thing for the line.
    pub(in crate::world) fn transmit(&mut self) -> Option<Transmit> {
        self.outgoing.pop_front()
    }

    /// Reads what came from the device; `engine` takes each message.
    pub(in crate::world) fn hear(&mut self, what: &Transmit, now: Timestamp, engine: &mut Engine) {
        let mut take = |decoded: Decoded| engine.message(now, decoded.message, &decoded.values);
        match what {
            Transmit::Frame(frame) => self.decoder.frame(frame).into_iter().for_each(take),
            Transmit::Bytes(packet) => self.decoder.bytes(packet.as_slice(), &mut take),
        }
    }

    /// What came and could not be read.
    pub(in crate::world) fn damaged(&self) -> u64 {
        self.decoder.damaged()
    }

    fn encode(&mut self, message: usize) -> Result<(), String> {
        let encoded = self.description.layout().encode(message, &self.values[message]);
        self.outgoing.push_back(encoded.map_err(|error| error.to_string())?);
        Ok(())
    }
}
