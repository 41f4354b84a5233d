//! The emulator of a described device.

mod answers;
mod canopen;
mod correction;
mod diagnosis;
mod dynamics;
mod occasion;
mod readings;
mod sending;
mod server;
#[cfg(test)]
mod tests;

use crate::canopen::Node;
use crate::description::{Description, Model, Source};
use crate::layout::{Decoder, Sender};
use crate::outbox::Outbox;
use answers::Answers;
use dynamics::{Dynamics, finite};
use readings::Readings;
use sending::{Agenda, Sending};
use server::Server;
use std::sync::Arc;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Maximum number of messages waiting to be sent, or the number of sent messages if greater; any more are dropped and
/// counted. Assumption: no device has as many ready at once.
const QUEUE_MAX: usize = 64;

/// Stands for no time. It is not due even at the end of all time.
const NEVER: Timestamp = Timestamp::MAX;

/// A running described device.
///
/// Its behaviour depends on what it receives and when, not on how often it is woken: states advance in fixed steps
/// from power-on, with a shorter one to each message.
#[derive(Debug, Clone)]
pub struct Device {
    description: Arc<Description>,
    decoder: Decoder,
    outbox: Outbox,
    dynamics: Dynamics,
    on: bool,
    senders: Vec<Sending>,
    agenda: Agenda,
    readings: Readings,
    /// The time at which each received message counts as lost.
    lost: Vec<Timestamp>,
    answers: Answers,
    /// Values of the message being received, one per signal.
    heard: Vec<Option<f64>>,
    not_finite: u64,
    /// Number of messages with a wrong counter or checksum.
    refused: u64,
    /// Its diagnostics, and the end of a reset that they asked for.
    uds: Option<Box<Server>>,
    back_at: Timestamp,
    /// The protocol of a CANopen device.
    canopen: Option<Box<Node>>,
}

impl Device {
    /// A device switched on at the start of the run. Its random numbers depend on the seed, its name and the signal.
    pub fn new(description: Arc<Description>, seed: u64) -> Self {
        let layout = description.layout();
        let model = &description.model;
        let sending = |sent| Sending::new(&description, sent, seed);
        let mut device = Self {
            decoder: layout.decoder_for(Sender::Host),
            outbox: Outbox::new(
                layout.clone(),
                Sender::Device,
                QUEUE_MAX.max(2 * model.sent.len()),
            ),
            refused: 0,
            uds: model.uds.as_ref().map(|uds| Box::new(Server::new(uds, seed, &description.name))),
            back_at: NEVER,
            canopen: (model.canopen.as_ref())
                .map(|known| Box::new(Node::new(Arc::clone(&known.dictionary), model.step))),
            dynamics: Dynamics::new(model),
            on: false,
            senders: model.sent.iter().map(sending).collect(),
            agenda: Agenda::new(model.sent.len()),
            readings: Readings::new(model),
            lost: vec![NEVER; model.heard.len()],
            answers: Answers::default(),
            heard: Vec::new(),
            not_finite: 0,
            description: Arc::clone(&description),
        };
        for (index, (_, value, _)) in description.parameters().enumerate() {
            device.dynamics.set(model.variables.parameter(index), value);
        }
        device.power(Timestamp::ZERO, true);
        device
    }

    /// Its description.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Takes a frame from the bus.
    pub fn receive_frame(&mut self, now: Timestamp, frame: &CanFrame) {
        if !self.on {
            return;
        }
        if self.uds.is_some() {
            self.diagnose(now, |uds, case| uds.receive(frame, case));
            if self.uds.as_ref().is_some_and(|uds| uds.is_deaf()) {
                return;
            }
        }
        if self.canopen.is_some() {
            return self.receive_canopen(now, frame);
        }
        self.outbox.receive(now, frame);
        let Some(heard) = self.decoder.at(now).frame(frame) else { return };
        if !self.outbox.is_addressed(heard.form, frame) {
            return;
        }
        if !heard.is_sound() {
            self.refused += 1;
            return;
        }
        let message = heard.message;
        let mut values = std::mem::take(&mut self.heard);
        values.clear();
        values.extend_from_slice(heard.values);
        self.hear(now, message, &values);
        self.heard = values;
    }

    /// Takes bytes from the serial line.
    pub fn receive_bytes(&mut self, now: Timestamp, bytes: &[u8]) {
        if !self.on {
            return;
        }
        let (mut found, mut refused) = (Vec::new(), 0);
        self.decoder.bytes(bytes, &mut |heard| match heard.is_sound() {
            true => found.push((heard.message, heard.values.to_vec())),
            false => refused += 1,
        });
        self.refused += refused;
        for (message, values) in found {
            self.hear(now, message, &values);
        }
    }

    /// Does the work due at `now`.
    pub fn wake(&mut self, now: Timestamp) {
        if self.back_at <= now {
            self.power(now, true);
        }
        if !self.on {
            return;
        }
        let description = Arc::clone(&self.description);
        self.pass(&description.model, now);
        self.dynamics.advance(&description.model, now);
        self.do_what_is_due(&description.model, now);
        self.outbox.wake(now);
        if self.uds.is_some() {
            self.wake_diagnosis(now);
        }
        self.wake_canopen(&description.model, now);
    }

    /// The next output.
    #[inline]
    pub fn transmit(&mut self) -> Option<Transmit> {
        let sent = match &mut self.canopen {
            None => self.outbox.transmit(),
            Some(node) => node.transmit().map(Transmit::Frame),
        };
        if let Some(Transmit::Frame(frame)) = &sent {
            self.decoder.says(frame);
        }
        match sent {
            None => self.uds.as_mut()?.transmit().map(Transmit::Frame),
            sent => sent,
        }
    }

    /// Time of the next wake-up if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        if let Some(at) = self.dynamics.physics_failed_at() {
            return at;
        }
        if !self.on {
            return self.back_at;
        }
        let lost = self.lost.iter().copied().min().unwrap_or(NEVER);
        let answer = self.answers.times().min().unwrap_or(NEVER);
        let parts = self.outbox.next_wakeup();
        let uds = self.uds.as_ref().map_or(NEVER, |uds| uds.next_wakeup());
        let canopen = self.canopen.as_ref().map_or(NEVER, |node| node.next_wakeup());
        let protocols = parts.min(uds).min(canopen);
        self.agenda.first().min(answer).min(lost).min(protocols).min(self.dynamics.deadline())
    }

    /// Changes a parameter, or all elements of an array; if [`Description::check_parameter`] refuses, returns `false`
    /// and changes nothing. States that start with the parameter use it at the next power-on;
    /// [`Description::set_parameter`] is for the first.
    pub fn set_parameter(&mut self, now: Timestamp, name: &str, value: f64) -> bool {
        let description = Arc::clone(&self.description);
        let model = &description.model;
        if description.check_parameter(name, value).is_err() {
            return false;
        }
        if self.on {
            self.pass(model, now);
            self.dynamics.reach(model, now);
        }
        for place in description.parameters_named(name) {
            self.dynamics.set(model.variables.parameter(place), value);
        }
        if self.on {
            self.dynamics.settle();
            self.dynamics.go_on(model, now, None);
        }
        true
    }

    /// Switches the power. Off, the device neither sends nor receives. On again, its states have their start values,
    /// and its parameters stay as set.
    pub fn power(&mut self, now: Timestamp, on: bool) {
        if on == self.on {
            return;
        }
        (self.on, self.back_at) = (on, NEVER);
        self.answers.clear();
        self.decoder.reset();
        self.outbox.reset();
        self.lost.fill(NEVER);
        if let Some(node) = &mut self.canopen {
            node.start(now);
        }
        if !on {
            return self.dynamics.stop_physics();
        }
        let description = Arc::clone(&self.description);
        let model = &description.model;
        for heard in 0..model.heard.len() {
            self.hear_nothing(heard);
        }
        if let Some(uds) = &mut self.uds {
            uds.power_on();
            self.dynamics.next_cycle();
        }
        self.dynamics.start(model, now);
        for (sending, sent) in self.senders.iter_mut().zip(&model.sent) {
            sending.start(&description, sent, now);
        }
        for index in 0..model.sent.len() {
            let mut numbers = Vec::new();
            self.numbers(model, index, &mut numbers);
            let rule = &model.sent[index].send;
            self.senders[index].occasion.start(rule, now, model.step, numbers);
            self.agenda.plan(index, self.senders[index].next());
        }
    }

    /// The true value of a state, a parameter or a signal. A sent signal is evaluated now, without noise; a received
    /// one has the value that the device knows.
    pub fn value(&self, name: &str) -> Option<f64> {
        let model = &self.description.model;
        if let Some(slot) = model.variables.inner(name) {
            return Some(self.dynamics.get(slot));
        }
        if let Some(value) = self.object(name) {
            return Some(value);
        }
        let (message, signal) = self.description.layout().signal(name)?;
        if let Some(slot) = model.variables.signal(message, signal) {
            return Some(self.dynamics.get(slot));
        }
        let index = model.sent.iter().position(|sent| sent.message == message)?;
        let sending = &self.senders[index];
        let last = *sending.last.get(signal)?;
        let value = match &model.sent[index].signals.get(signal)?.source {
            Source::Unsaid => last,
            // Looking is not reading: the sensor stays unchanged.
            source => source.value(self.dynamics.values(), &mut sending.sensors[signal].clone()),
        };
        Some(if value.is_finite() { value } else { last })
    }

    /// Number of messages not sent because the queue was full or because no receiver answered a message in parts.
    pub fn dropped(&self) -> u64 {
        let uds = self.uds.as_ref().map_or(0, |uds| uds.dropped());
        let canopen = self.canopen.as_ref().map_or(0, |node| node.dropped());
        self.outbox.dropped() + self.answers.dropped + uds + canopen
    }

    /// Number of non-finite values of states, signals and objects, for which the previous value was kept.
    pub fn not_finite(&self) -> u64 {
        let objects = self.canopen.as_ref().map_or(0, |node| node.not_finite());
        self.not_finite + self.dynamics.not_finite() + objects
    }

    /// Input that is not a message; see [`Decoder::damaged`].
    pub const fn damaged(&self) -> u64 {
        self.decoder.damaged()
    }

    /// Number of received messages with a wrong checksum: of a message on a serial line, or among the signals; or with a
    /// wrong counter.
    pub const fn refused_messages(&self) -> u64 {
        self.refused + self.decoder.checksum_failures()
    }

    /// Number of questions not used because another was being answered.
    pub const fn refused_busy(&self) -> u64 {
        self.answers.refused
    }

    fn hear(&mut self, now: Timestamp, message: usize, values: &[Option<f64>]) {
        let description = Arc::clone(&self.description);
        let model = &description.model;
        self.pass(model, now);
        if self.accepts(model, now, message, values) {
            self.take(model, now, message, values);
        }
        self.do_what_is_due(model, now);
    }

    fn take(&mut self, model: &Model, now: Timestamp, message: usize, values: &[Option<f64>]) {
        self.dynamics.reach(model, now);
        for (signal, value) in values.iter().enumerate() {
            let slot = model.variables.signal(message, signal);
            if let (Some(slot), Some(value)) = (slot, value) {
                let before = self.dynamics.get(slot);
                self.dynamics.set(slot, finite(*value, before, &mut self.not_finite));
            }
        }
        self.dynamics.settle();
        self.dynamics.go_on(model, now, Some(message));
        for (lost, heard) in self.lost.iter_mut().zip(&model.heard) {
            if heard.message == message {
                *lost = heard.timeout.map_or(NEVER, |timeout| now + timeout);
            }
        }
        self.answer(model, now, message, false);
        self.look_at_all(model, now);
    }

    /// Sends what is due, and takes questions whose turn comes with that.
    fn do_what_is_due(&mut self, model: &Model, now: Timestamp) {
        self.send_what_is_due(model, now);
        while let Some((message, values)) = self.answers.question() {
            self.take(model, now, message, &values);
            self.send_what_is_due(model, now);
        }
    }

    /// Handles message time-outs and timed transitions of machines, in the order of time.
    fn pass(&mut self, model: &Model, now: Timestamp) {
        loop {
            let lost = self.lost.iter().enumerate().min_by_key(|(_, at)| **at);
            let lost = lost.map(|(heard, at)| (*at, heard)).unwrap_or((NEVER, 0));
            let deadline = self.dynamics.deadline();
            let at = lost.0.min(deadline);
            if at > now || at == NEVER {
                return;
            }
            self.dynamics.reach(model, at);
            if lost.0 == at {
                self.hear_nothing(lost.1);
                self.dynamics.settle();
                self.dynamics.go_on(model, at, None);
                self.lost[lost.1] = NEVER;
            }
            if deadline == at {
                self.look_at_all(model, at);
            }
        }
    }

    /// Resets the signals of a message to their initial values.
    fn hear_nothing(&mut self, heard: usize) {
        let model = &self.description.model;
        let message = model.heard[heard].message;
        let signals = &self.description.layout().messages()[message].signals;
        for (index, signal) in signals.iter().enumerate() {
            if let Some(slot) = model.variables.signal(message, index) {
                self.dynamics.set(slot, signal.start);
            }
        }
    }
}
