//! The user's own device or program under test, with its machine.

use super::host::{Guest, OnHost};
use crate::hosted::NodeDevice;
use controller::mission::Mission;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A device under test in this process, or a program in step with it.
#[derive(Debug)]
pub struct Own {
    pub(super) host: OnHost<Box<dyn NodeDevice>>,
}

impl Own {
    pub const fn new(device: Box<dyn NodeDevice>) -> Self {
        Self { host: OnHost::new(device) }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        self.host.guest.wake(self.host.told(now));
    }

    /// In bench time; never while the machine is stalled.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        match self.host.is_stalled() {
            true => Timestamp::MAX,
            false => self.host.when(self.host.guest.next_wakeup()),
        }
    }

    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        if self.host.is_stalled() {
            return None;
        }
        self.host.guest.transmit(self.host.told(now))
    }

    pub(super) fn ended(&mut self) -> Option<String> {
        self.host.guest.ended()
    }

    pub(super) fn wrong(&mut self) -> Option<String> {
        self.host.guest.wrong()
    }

    pub(super) fn is_given_up(&self) -> bool {
        self.host.guest.is_given_up()
    }
}

impl Guest for Box<dyn NodeDevice> {
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.receive(now, port, what);
    }

    /// Nodes receive no missions.
    fn order(&mut self, _: Timestamp, _: Mission) {}
}
