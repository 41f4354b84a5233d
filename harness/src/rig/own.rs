//! Somebody's own device or program, and the machine that it runs on.

use super::host::{Guest, Host};
use crate::faults::FaultKind;
use crate::hosted::NodeDevice;
use controller::mission::Mission;
use std::fmt;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// A device under test in this process, or a program in step with it.
pub(crate) struct Own {
    device: Box<dyn NodeDevice>,
    /// Only where faults can strike it.
    host: Option<Host>,
}

impl Own {
    pub(crate) const fn new(device: Box<dyn NodeDevice>) -> Self {
        Self { device, host: None }
    }

    pub(super) fn with_faults(&mut self) {
        self.host = Some(Host::default());
    }

    pub(super) fn begin_fault(&mut self, kind: &FaultKind) {
        if let Some(host) = &mut self.host {
            host.begin(kind);
        }
    }

    pub(super) fn end_fault(&mut self, now: Timestamp, kind: &FaultKind) -> u64 {
        let Self { device, host: Some(host) } = self else { return 0 };
        host.end(now, kind, device)
    }

    pub(super) fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        match &mut self.host {
            None => self.device.receive(now, port, what),
            Some(host) => host.hear(now, port, *what, &mut self.device),
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        self.device.wake(self.told(now));
    }

    /// By the clock of the bench; never while its machine stands still.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        let due = self.device.next_wakeup();
        match &self.host {
            None => due,
            Some(host) if host.is_stalled() => Timestamp::MAX,
            Some(host) => host.when(due),
        }
    }

    pub(super) fn transmit(&mut self, now: Timestamp) -> Option<(PortId, Transmit)> {
        if self.host.as_ref().is_some_and(Host::is_stalled) {
            return None;
        }
        self.device.transmit(self.told(now))
    }

    pub(super) fn ended(&mut self) -> Option<String> {
        self.device.ended()
    }

    pub(super) fn dropped(&self) -> u64 {
        self.host.as_ref().map_or(0, Host::dropped)
    }

    fn told(&self, now: Timestamp) -> Timestamp {
        self.host.as_ref().map_or(now, |host| host.told(now))
    }
}

impl Guest for Box<dyn NodeDevice> {
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        self.receive(now, port, what);
    }

    /// Nodes are given none.
    fn order(&mut self, _: Timestamp, _: Mission) {}
}

impl fmt::Debug for Own {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Own").field("host", &self.host).finish_non_exhaustive()
    }
}
