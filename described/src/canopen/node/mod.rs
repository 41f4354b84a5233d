//! The protocol of a device: what it does with a frame, and by itself.

mod sending;

use super::dictionary::Dictionary;
use super::emergency::{self, Errors};
use super::nmt::{self, Command, Consumed, State};
use super::objects::{Application, Objects};
use super::pdo::{self, Pdo};
use super::sdo::{Server, Store};
use crate::clipped::Clipped;
use sending::{AT_EVENTS, Sending};
use std::collections::VecDeque;
use std::sync::Arc;
use wire::can::{CanFrame, Id, StandardId};
use wire::time::{Span, Timestamp};

/// Stands for no time.
const NEVER: Timestamp = Timestamp::MAX;

/// Most frames that wait for the line: one of each PDO, and answers.
const QUEUE_MAX: usize = 1024;

/// What a frame was for the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Heard {
    /// Nothing, or not in this state.
    Nothing,
    Message,
    /// The device is to begin anew.
    Reset,
}

#[derive(Debug, Clone)]
pub(crate) struct Node {
    objects: Objects,
    state: State,
    /// When its events are looked at: this long after one another from `started` on.
    step: Span,
    started: Timestamp,
    look: Timestamp,
    heartbeat: Timestamp,
    consumed: Vec<Consumed>,
    transmitted: Vec<Sending>,
    /// Each with what came for the next SYNC.
    received: Vec<(Pdo, Option<[u8; 8]>)>,
    server: Server,
    errors: Errors,
    has_errors: bool,
    guard_toggle: u8,
    queue: VecDeque<CanFrame>,
    dropped: u64,
}

impl Node {
    /// A device that is off. It looks for changes and errors this often.
    pub(crate) fn new(dictionary: Arc<Dictionary>, step: Span) -> Self {
        Self {
            objects: Objects::new(dictionary),
            state: State::Initialising,
            step,
            started: Timestamp::ZERO,
            look: NEVER,
            heartbeat: NEVER,
            consumed: Vec::new(),
            transmitted: Vec::new(),
            received: Vec::new(),
            server: Server::default(),
            errors: Errors::default(),
            has_errors: false,
            guard_toggle: 0,
            queue: VecDeque::new(),
            dropped: 0,
        }
    }

    /// Power-on. Its boot-up message comes with the next wake-up.
    pub(crate) fn start(&mut self, now: Timestamp) {
        let anew = Self::new(Arc::clone(&self.objects.dictionary), self.step);
        let before = std::mem::replace(self, anew);
        (self.started, self.dropped) = (now, before.dropped);
        self.objects.count_on(before.objects);
        self.configure(now);
    }

    /// Number of frames not sent because the queue was full.
    pub(crate) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// The objects of which values were clipped to the range.
    pub(crate) fn clipped(&self) -> impl Iterator<Item = Clipped<'_>> {
        self.objects.clipped()
    }

    /// Number of values that were not finite, for which objects kept the one before.
    pub(crate) const fn not_finite(&self) -> u64 {
        self.objects.not_finite()
    }

    fn id(&self, function: u16) -> Option<Id> {
        StandardId::new(function + u16::from(self.objects.dictionary.node_id)).map(Id::Standard)
    }

    /// The identifier in a COB-ID of the dictionary, or the default one.
    fn id_in(&self, (index, sub): (u16, u8), default: Option<Id>) -> Option<Id> {
        match self.objects.setting(index, sub) {
            // Bit 31: it does not exist; bit 30 of the SYNC: the device would send it.
            Some(cob) => pdo::id(cob as u32).filter(|_| cob & 1 << 31 == 0),
            None => default,
        }
    }

    fn send(&mut self, id: Option<Id>, data: &[u8]) {
        let frame = id.and_then(|id| CanFrame::new(id, data));
        match frame.filter(|_| self.queue.len() < QUEUE_MAX) {
            Some(frame) => self.queue.push_back(frame),
            None => self.dropped += u64::from(id.is_some()),
        }
    }

    /// The next frame for the line.
    pub(crate) fn transmit(&mut self) -> Option<CanFrame> {
        self.queue.pop_front()
    }

    /// Takes what the objects of the communication say.
    fn configure(&mut self, now: Timestamp) {
        self.configure_pdos(now);
        self.consumed = nmt::consumed(&self.objects);
        self.configure_heartbeat(now);
    }

    fn configure_heartbeat(&mut self, now: Timestamp) {
        let period = self.period().filter(|_| self.state != State::Initialising);
        self.heartbeat = period.map_or(NEVER, |period| now + period);
    }

    /// The producer heartbeat time, 1017h.
    fn period(&self) -> Option<Span> {
        let ms = self.objects.setting(0x1017, 0).filter(|ms| *ms > 0)?;
        Some(Span::from_millis(ms.min(0xFFFF) as i64))
    }

    fn go(&mut self, now: Timestamp, state: State) {
        if state == self.state {
            return;
        }
        self.state = state;
        for sending in &mut self.transmitted {
            *sending = Sending::new(sending.pdo.clone());
            if state == State::Operational && sending.pdo.event > Span::ZERO {
                sending.timer = now + sending.pdo.event;
            }
        }
        self.received.iter_mut().for_each(|(_, waiting)| *waiting = None);
    }

    /// When to wake it if nothing arrives before.
    pub(crate) fn next_wakeup(&self) -> Timestamp {
        if self.state == State::Initialising {
            return self.started;
        }
        let lost = self.consumed.iter().map(|one| one.due);
        let sent = self.transmitted.iter().map(Sending::due);
        let sent = sent.filter(|_| self.state == State::Operational);
        lost.chain(sent).fold(self.heartbeat.min(self.look), Timestamp::min)
    }

    pub(crate) fn wake(&mut self, now: Timestamp, application: &mut dyn Application) {
        if self.state == State::Initialising {
            self.send(self.id(0x700), &[State::Initialising as u8]);
            self.state = State::PreOperational;
            self.configure(now);
        }
        if self.heartbeat <= now {
            self.heartbeat = self.period().map_or(NEVER, |period| {
                let missed = now.since(self.heartbeat).as_nanos() / period.as_nanos() + 1;
                self.heartbeat + period * missed
            });
            self.send(self.id(0x700), &[self.state as u8]);
        }
        let lost = self.consumed.iter_mut().filter_map(|one| one.is_overdue(now).then_some(()));
        if lost.count() > 0 {
            self.raise(emergency::HEARTBEAT);
            self.go(now, nmt::after_error(&self.objects, self.state));
        }
        self.look(now, application);
    }

    fn raise(&mut self, code: u16) {
        let message = self.errors.raise(code, &mut self.objects);
        self.emergency(message);
    }

    fn clear(&mut self, code: u16) {
        let message = self.errors.clear(code, &mut self.objects);
        self.emergency(message);
    }

    fn emergency(&mut self, message: Option<[u8; 8]>) {
        if let Some(message) = message.filter(|_| self.state != State::Stopped) {
            self.send(self.id_in((0x1014, 0), self.id(0x80)), &message);
        }
    }

    /// Looks at the conditions of errors and at the PDOs that are sent at events.
    pub(crate) fn look(&mut self, now: Timestamp, application: &mut dyn Application) {
        if self.state == State::Initialising {
            return;
        }
        let errors = application.errors();
        self.has_errors = !errors.is_empty();
        for (code, _) in &errors {
            // Several conditions may share a code: it goes with the last of them.
            let holds = errors.iter().any(|(other, holds)| other == code && *holds);
            if holds { self.raise(*code) } else { self.clear(*code) }
        }
        let mut has_events = false;
        for place in 0..self.transmitted.len() {
            let sending = &self.transmitted[place];
            let is_event = self.state == State::Operational && sending.pdo.id().is_some();
            // Those of type 0 are sent at a SYNC after an event.
            if !is_event || !(sending.pdo.kind == 0 || AT_EVENTS.contains(&sending.pdo.kind)) {
                continue;
            }
            has_events = true;
            let data = self.sample(place, application);
            let sending = &mut self.transmitted[place];
            sending.is_changed |= sending.last != Some(data);
            if sending.due() <= now {
                self.transmit_pdo(now, place, data);
            }
        }
        self.look = NEVER;
        if has_events || self.has_errors {
            let steps = now.since(self.started).as_nanos() / self.step.as_nanos().max(1) + 1;
            self.look = self.started + self.step * steps;
        }
    }

    pub(crate) fn receive(
        &mut self,
        now: Timestamp,
        frame: &CanFrame,
        application: &mut dyn Application,
    ) -> Heard {
        let heard = self.hear(now, frame, application);
        match self.objects.changed.take() {
            Some(0x1016) => {
                self.consumed = nmt::consumed(&self.objects);
                self.clear(emergency::HEARTBEAT);
            }
            Some(0x1017) => self.configure_heartbeat(now),
            Some(0x1400..=0x1BFF) => self.configure_pdos(now),
            _ => {}
        }
        heard
    }

    fn hear(
        &mut self,
        now: Timestamp,
        frame: &CanFrame,
        application: &mut dyn Application,
    ) -> Heard {
        if self.state == State::Initialising || frame.fd_flags().is_some() {
            return Heard::Nothing;
        }
        if frame.is_remote() {
            self.asked(now, frame.id(), application);
            return Heard::Nothing;
        }
        let (id, data) = (frame.id(), frame.data());
        if id == Id::Standard(StandardId::ZERO) {
            return self.command(now, data);
        }
        if let Id::Standard(raw) = id
            && let (0x701..=0x77F, Some(_)) = (raw.as_raw(), data.first())
        {
            let node = (raw.as_raw() & 0x7F) as u8;
            let back = self.consumed.iter_mut().map(|one| one.hear(now, node));
            if back.fold(false, |any, is_back| any | is_back)
                && !self.consumed.iter().any(|one| one.is_lost)
            {
                self.clear(emergency::HEARTBEAT);
            }
        }
        if self.state == State::Stopped {
            return Heard::Nothing;
        }
        if Some(id) == self.id_in((0x1200, 1), self.id(0x600)) {
            return self.transfer(data, application);
        }
        if self.state != State::Operational {
            return Heard::Nothing;
        }
        if Some(id) == self.id_in((0x1005, 0), StandardId::new(0x80).map(Id::Standard)) {
            return self.sync(now, application);
        }
        self.pdo(id, data, application)
    }

    fn command(&mut self, now: Timestamp, data: &[u8]) -> Heard {
        match Command::of(data, self.objects.dictionary.node_id) {
            Some(Command::Go(state)) => self.go(now, state),
            Some(Command::ResetNode) => return Heard::Reset,
            Some(Command::ResetCommunication) => {
                self.objects.reset_communication();
                self.server = Server::default();
                // The objects show no error; those that are still there appear anew.
                self.errors = Errors::default();
                self.go(now, State::Initialising);
                (self.started, self.guard_toggle) = (now, 0);
                self.queue.clear();
            }
            None => return Heard::Nothing,
        }
        Heard::Message
    }

    fn transfer(&mut self, data: &[u8], application: &mut dyn Application) -> Heard {
        let Some(request) = data.first_chunk::<8>() else { return Heard::Nothing };
        let mut store = Store { objects: &mut self.objects, application };
        if let Some(answer) = self.server.request(request, &mut store) {
            self.send(self.id_in((0x1200, 2), self.id(0x580)), &answer);
        }
        Heard::Message
    }

    /// A remote request: for a PDO, or of node guarding.
    fn asked(&mut self, now: Timestamp, id: Id, application: &mut dyn Application) {
        if Some(id) == self.id(0x700) {
            if self.heartbeat == NEVER {
                self.send(Some(id), &[self.guard_toggle | self.state as u8]);
                self.guard_toggle ^= 0x80;
            }
        } else if self.state == State::Operational {
            let mut pdos = self.transmitted.iter();
            let is_it = |one: &Sending| one.pdo.id() == Some(id) && one.pdo.allows_remote();
            if let Some(place) = pdos.position(is_it) {
                let data = self.sample(place, application);
                self.transmit_pdo(now, place, data);
            }
        }
    }
}
