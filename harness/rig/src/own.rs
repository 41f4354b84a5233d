//! The user's own device or program under test, with its machine.

use super::host::{Guest, OnHost};
use crate::hosted::NodeDevice;
use controller::mission::Mission;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// A device under test in this process, or a program in step with it, with its machine.
pub type Own = OnHost<Box<dyn NodeDevice>>;

impl Own {
    pub(super) fn wake(&mut self, now: Timestamp) {
        if !self.is_stalled() {
            self.guest.wake(self.told(now));
        }
    }

    /// In bench time; never while the machine is stalled.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self.is_stalled() {
            true => Timestamp::MAX,
            false => self.when(self.guest.next_wakeup()),
        }
    }

    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        if self.is_stalled() { None } else { self.guest.transmit(self.told(now)) }
    }

    /// Its supply is cut, or there again. What a stalled machine had not read yet is lost.
    pub(super) fn power(&mut self, now: Timestamp, on: bool) {
        self.forget();
        self.guest.power(self.told(now), on);
    }
}

impl Guest for Box<dyn NodeDevice> {
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.receive(now, port, what);
    }

    /// Nodes receive no missions.
    fn order(&mut self, _: Timestamp, _: Mission) {}

    fn set_wall_clock(&mut self, by: Span) -> bool {
        NodeDevice::set_wall_clock(&mut **self, by)
    }
}
