//! An emulated device with its line.

use super::link::{DeviceLink, End};
#[cfg(feature = "live")]
use crate::faults::Chance;
#[cfg(feature = "live")]
use crate::faults::{FaultKind, Toward};
use described::Description;
use std::sync::Arc;
use wire::device::Transmit;
use wire::time::Timestamp;

/// The emulator, and the line up to its port.
#[derive(Debug)]
pub(crate) struct Emulated {
    pub(crate) device: described::Device,
    pub(in crate::world) link: DeviceLink,
    /// It is switched on again then.
    on_at: Option<Timestamp>,
}

impl Emulated {
    /// Its random numbers are from `seed`.
    pub(crate) fn new(description: &Arc<Description>, seed: u64) -> Self {
        Self {
            device: described::Device::new(Arc::clone(description), seed),
            link: DeviceLink::new(description.layout().medium()),
            on_at: None,
        }
    }

    /// Something came to the port.
    pub(crate) fn receive(&mut self, now: Timestamp, what: Transmit) {
        self.link.send(now, End::Host, what);
    }

    /// The device takes what has come through its line; everything that has goes to `each`, with who sent it.
    pub(crate) fn deliver(&mut self, now: Timestamp, each: &mut impl FnMut(End, &Transmit)) {
        while let Some((from, what)) = self.link.arrived(now) {
            if from != End::Device {
                match &what {
                    Transmit::Frame(frame) => self.device.receive_frame(now, frame),
                    Transmit::Bytes(packet) => self.device.receive_bytes(now, packet.as_slice()),
                }
            }
            each(from, &what);
        }
    }

    /// The device does what is due.
    pub(crate) fn wake(&mut self, now: Timestamp) {
        if self.device.next_wakeup() <= now {
            self.device.wake(now);
        }
    }

    /// Puts what the device has to say on its line.
    pub(crate) fn transmit(&mut self, now: Timestamp) {
        while let Some(sent) = self.device.transmit() {
            self.link.send(now, End::Device, sent);
        }
    }

    /// When something is through its line.
    pub(super) fn next_arrival(&self) -> Timestamp {
        self.link.next_arrival()
    }

    /// When something is through or due, if nothing comes before.
    pub(crate) fn next_due(&self) -> Timestamp {
        self.link
            .next_arrival()
            .min(self.device.next_wakeup())
            .min(self.on_at.unwrap_or(Timestamp::MAX))
    }

    /// Switches it off, and on again at `on_at`.
    pub(crate) fn cycle(&mut self, now: Timestamp, on_at: Timestamp) {
        self.device.power(now, false);
        self.on_at = Some(on_at);
    }

    /// It has just been switched on again.
    pub(crate) fn is_back(&mut self, now: Timestamp) -> bool {
        let due = self.on_at.is_some_and(|at| at <= now);
        if due {
            self.on_at = None;
            self.device.power(now, true);
        }
        due
    }

    /// What it and its line had no room for.
    pub(crate) fn dropped(&self) -> u64 {
        self.link.dropped() + self.device.dropped()
    }
}

/// Faults on request.
#[cfg(feature = "live")]
impl Emulated {
    /// From now on its line is faulty in this way too, both ways.
    pub(crate) fn begin_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        kind: &FaultKind,
        seed: u64,
    ) {
        let chance = |way: &str| Chance::new(seed, &format!("{number} {way}"));
        self.link.begin_fault(now, number, kind, Toward::Both, chance);
    }

    /// The fault of this number is over.
    pub(crate) fn end_fault(&mut self, now: Timestamp, number: usize) {
        self.link.end_fault(now, number);
    }
}
