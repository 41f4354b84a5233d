//! PDOs while the device runs: when they are sent, and what they write.

use super::{Heard, NEVER, Node};
use crate::canopen::dictionary::unsigned;
use crate::canopen::emergency;
use crate::canopen::nmt::State;
use crate::canopen::objects::{Application, Objects};
use crate::canopen::pdo::{self, Direction, Pdo};
use std::ops::RangeInclusive;
use wire::can::Id;
use wire::time::{Span, Timestamp};

/// Transmission types (CiA 301, table 72).
const CYCLIC: RangeInclusive<u8> = 1..=240;
pub(super) const AT_EVENTS: RangeInclusive<u8> = 254..=255;

#[derive(Debug, Clone)]
pub(super) struct Sending {
    pub(super) pdo: Pdo,
    pub(super) last: Option<[u8; 8]>,
    /// No earlier than this, because of the inhibit time.
    pub(super) free: Timestamp,
    pub(super) timer: Timestamp,
    pub(super) is_changed: bool,
    pub(super) syncs: u8,
}

impl Sending {
    pub(super) fn new(pdo: Pdo) -> Self {
        let timer = NEVER;
        Self { pdo, last: None, free: Timestamp::ZERO, timer, is_changed: false, syncs: 0 }
    }

    pub(super) fn due(&self) -> Timestamp {
        let change = if self.is_changed { self.free } else { NEVER };
        // A master can take the identifier away while the timer runs.
        let is_sent = AT_EVENTS.contains(&self.pdo.kind) && self.pdo.id().is_some();
        if is_sent { change.min(self.timer) } else { NEVER }
    }
}

impl Node {
    pub(super) fn configure_pdos(&mut self, now: Timestamp) {
        let of = |direction| {
            let Objects { dictionary, values, .. } = &self.objects;
            pdo::pdos(dictionary, values, direction).unwrap_or_default()
        };
        let (transmitted, received) = (of(Direction::Transmit), of(Direction::Receive));
        // What stays as it was goes on.
        let mut before = std::mem::take(&mut self.transmitted);
        let kept = |pdo: Pdo| match before.iter().position(|known| known.pdo == pdo) {
            Some(place) => before.swap_remove(place),
            None => Sending::new(pdo),
        };
        self.transmitted = transmitted.into_iter().map(kept).collect();
        self.received = received.into_iter().map(|pdo| (pdo, None)).collect();
        for sending in &mut self.transmitted {
            let is_timed = self.state == State::Operational && sending.pdo.event > Span::ZERO;
            if is_timed && sending.timer == NEVER {
                sending.timer = now + sending.pdo.event;
            }
        }
    }

    pub(super) fn sample(&mut self, place: usize, application: &dyn Application) -> [u8; 8] {
        let mut word = 0;
        for (entry, first, bits) in self.transmitted[place].pdo.objects() {
            let raw = unsigned(self.objects.current(entry, application));
            word |= (raw & (u64::MAX >> (u64::BITS - bits))) << first;
        }
        word.to_le_bytes()
    }

    pub(super) fn transmit_pdo(&mut self, now: Timestamp, place: usize, data: [u8; 8]) {
        let sending = &mut self.transmitted[place];
        (sending.last, sending.is_changed) = (Some(data), false);
        sending.free = now + sending.pdo.inhibit;
        if sending.pdo.event > Span::ZERO {
            sending.timer = now + sending.pdo.event;
        }
        let (id, length) = (sending.pdo.id(), sending.pdo.length());
        self.send(id, &data[..length]);
    }

    pub(super) fn sync(&mut self, now: Timestamp, application: &mut dyn Application) -> Heard {
        let waiting = self.received.iter_mut().enumerate();
        let waiting = waiting.filter_map(|(place, (_, data))| Some((place, data.take()?)));
        for (place, data) in waiting.collect::<Vec<_>>() {
            self.apply(place, data, application);
        }
        for place in 0..self.transmitted.len() {
            let sending = &mut self.transmitted[place];
            // One that is switched off does not count.
            if sending.pdo.id().is_none() {
                continue;
            }
            let is_due = match sending.pdo.kind {
                0 => sending.is_changed,
                kind if CYCLIC.contains(&kind) => {
                    sending.syncs += 1;
                    sending.syncs >= kind
                }
                _ => false,
            };
            if is_due {
                sending.syncs = 0;
                let data = self.sample(place, application);
                self.transmit_pdo(now, place, data);
            }
        }
        Heard::Message
    }

    pub(super) fn pdo(&mut self, id: Id, data: &[u8], application: &mut dyn Application) -> Heard {
        let place = self.received.iter().position(|(pdo, _)| pdo.id() == Some(id));
        let Some(place) = place else { return Heard::Nothing };
        let (pdo, waiting) = &mut self.received[place];
        if data.len() < pdo.length() {
            self.raise(emergency::PDO_LENGTH);
            self.clear(emergency::PDO_LENGTH);
            return Heard::Nothing;
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        if pdo.kind <= *CYCLIC.end() {
            *waiting = Some(bytes);
            return Heard::Nothing;
        }
        self.apply(place, bytes, application);
        Heard::Message
    }

    /// Writes the objects of a PDO. Values that their objects cannot have are left out.
    fn apply(&mut self, place: usize, data: [u8; 8], application: &mut dyn Application) {
        let word = u64::from_le_bytes(data);
        let objects: Vec<_> = self.received[place].0.objects().collect();
        for (entry, first, bits) in objects {
            let raw = (word >> first) & (u64::MAX >> (u64::BITS - bits));
            let entry = &self.objects.dictionary.entries[entry];
            let (object, length) = ((entry.index, entry.sub), entry.kind.bytes());
            let _ = self.objects.write(object, &raw.to_le_bytes()[..length], application);
        }
    }
}
