//! A node as which the plan speaks: it sends what the plan orders, again and again where it is to.

use crate::plan::Send;
use described::{Encoder, Layout, Message, Sender};
use std::collections::VecDeque;
use wire::device::Transmit;
use wire::time::{Span, Timestamp};

/// Somebody on a line who says what the plan orders.
#[derive(Debug)]
pub(crate) struct Tester {
    /// Its counters go on from one message to the next, whoever orders them.
    encoder: Encoder,
    /// Whose messages of the layout it sends.
    sender: Sender,
    /// Of each message, what its signals were set to last.
    values: Vec<Vec<f64>>,
    /// Of each message, the signals that the last order set: a counter and a checksum among them are not put in.
    own: Vec<Vec<usize>>,
    /// Of each message that is sent again and again, how often, and when next.
    again: Vec<Option<(Span, Timestamp)>>,
    outgoing: VecDeque<Transmit>,
}

impl Tester {
    pub(crate) fn new(layout: Layout, sender: Sender) -> Self {
        let start = |message: &Message| message.signals.iter().map(|signal| signal.start).collect();
        Self {
            values: layout.messages().iter().map(start).collect(),
            own: vec![Vec::new(); layout.messages().len()],
            again: vec![None; layout.messages().len()],
            outgoing: VecDeque::new(),
            encoder: Encoder::new(layout),
            sender,
        }
    }

    /// It can send a message of this name.
    pub(super) fn knows(&self, message: &str) -> bool {
        let layout = self.encoder.layout();
        let place = layout.find(message);
        place.is_some_and(|place| layout.messages()[place].sender == self.sender)
    }

    /// Sends a message now, and again as often as it says, or as the layout does. Its counter and its checksum are put
    /// in, unless the order sets them.
    ///
    /// # Errors
    ///
    /// When the layout has no such message or signal, or a value does not fit in.
    pub(super) fn send(&mut self, now: Timestamp, send: &Send) -> Result<(), String> {
        let layout = self.encoder.layout();
        let Some(message) = layout.find(&send.message) else {
            return Err(format!("no message `{}` in the layout of the device", send.message));
        };
        let form = &layout.messages()[message];
        self.own[message].clear();
        for (name, value) in &send.set {
            let Some(signal) = form.signals.iter().position(|signal| signal.name == *name) else {
                return Err(format!("`{}` has no signal `{name}`", send.message));
            };
            self.values[message][signal] = *value;
            self.own[message].push(signal);
        }
        let signals = form.signals.iter().enumerate();
        let mut set = signals.filter(|(_, signal)| send.set.contains_key(&signal.name));
        let values = &self.values[message];
        if let Some((_, signal)) = set.find(|(place, _)| !form.carries(*place, values)) {
            return Err(format!(
                "`{}` has no `{}` with its multiplexers as they are: set them in the same step",
                send.message, signal.name
            ));
        }
        let every = send.every.or(form.period).filter(|every| *every > Span::ZERO);
        self.again[message] = every.map(|every| (every, now + every));
        self.encode(message)
    }

    /// This message is no longer sent again.
    pub(super) fn stop(&mut self, message: &str) {
        if let Some(message) = self.encoder.layout().find(message) {
            self.again[message] = None;
        }
    }

    /// When a message is to be sent again.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        let dues = self.again.iter().flatten().map(|(_, due)| *due);
        dues.min().unwrap_or(Timestamp::MAX)
    }

    /// Sends again what is due.
    ///
    /// # Errors
    ///
    /// When a value does not fit in.
    pub(super) fn wake(&mut self, now: Timestamp) -> Result<(), String> {
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
    pub(super) fn transmit(&mut self) -> Option<Transmit> {
        self.outgoing.pop_front()
    }

    fn encode(&mut self, message: usize) -> Result<(), String> {
        let (values, own) = (&self.values[message], &self.own[message]);
        let encoded = self.encoder.encode(message, values, |signal| own.contains(&signal));
        self.outgoing.push_back(encoded.map_err(|error| error.to_string())?);
        Ok(())
    }
}
