//! Our controller in the process of the harness, on the ports that a separate process would open.

use super::clock::Clock;
use super::error::StartError;
use super::heard::Heard;
use super::histogram::Histogram;
use super::ports::{BASE, GYRO, Wiring, base_traffic, device};
use super::role_port::{PortEvent, RolePort, Traffic, next};
use controller::config::Config;
use controller::mission::Mission;
use record::Device;
use rig::hosted::{Hosted, HostedController as _};
use rig::node::{self, Machine};
use std::collections::VecDeque;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Most crossings that wait to be fetched: far more than one turn of the loop can bring. More are counted as dropped.
const CROSSINGS_MAX: usize = 256;

/// Something crossed a port of the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    pub(super) role: &'static str,
    pub(super) by: Device,
    pub(super) crossed: Transmit,
}

/// The controller, its machine and its ports.
#[derive(Debug)]
pub(super) struct InProcess {
    machine: Machine,
    gyro: RolePort,
    base: Option<RolePort>,
    crossings: VecDeque<Crossing>,
    dropped: u64,
    /// Time of the last input, until a command follows it.
    heard_at: Option<Timestamp>,
    bus_to_command: Histogram,
}

impl InProcess {
    /// Opens the ports.
    ///
    /// # Errors
    /// When a port cannot be opened, or when its place is unknown.
    pub(super) async fn start(
        config: Config,
        with_faults: bool,
        wiring: &Wiring,
    ) -> Result<Self, StartError> {
        let known = |role| StartError::NoFarSide { role };
        let gyro = wiring.port(GYRO).ok_or(known(GYRO))?;
        let gyro = RolePort::open(gyro, Traffic::Bytes(config.gyro.stream.format.serial())).await?;
        let base = match config.base {
            None => None,
            Some(base) => {
                let spec = wiring.port(BASE).ok_or(known(BASE))?;
                Some(RolePort::open(spec, base_traffic(base.transport)).await?)
            }
        };
        let mut machine = Machine::new(Hosted::ours(&config));
        if with_faults {
            machine.host.with_faults();
        }
        Ok(Self {
            machine,
            gyro,
            base,
            crossings: VecDeque::new(),
            dropped: 0,
            heard_at: None,
            bus_to_command: Histogram::default(),
        })
    }

    pub(super) fn command(&mut self, clock: &Clock, mission: Mission) {
        let now = clock.now();
        self.machine.host.command(now, mission);
        self.send(clock, now);
    }

    pub(super) fn wake(&mut self, clock: &Clock, now: Timestamp) {
        if self.next_wakeup() <= now {
            self.machine.wake(now);
            self.send(clock, now);
        }
    }

    /// Sends outputs after a fault struck the machine or ended.
    pub(super) fn struck(&mut self, clock: &Clock, now: Timestamp) {
        self.send(clock, now);
    }

    pub(super) const fn machine(&mut self) -> &mut Machine {
        &mut self.machine
    }

    /// Next wake-up, in bench time.
    pub(super) fn next_wakeup(&self) -> Timestamp {
        self.machine.next_wakeup()
    }

    /// Waits for the next event. Cancel-safe.
    pub(super) async fn heard(&mut self, clock: &Clock) -> Heard {
        if !self.machine.host.is_stalled()
            && let Some(report) = self.machine.host.guest.report()
        {
            return Heard::Report(report);
        }
        let (port, role, event) = tokio::select! {
            event = self.gyro.next() => (node::GYRO, GYRO, event),
            event = next(self.base.as_mut()) => (node::BASE, BASE, event),
        };
        let now = clock.now();
        let what = match event {
            PortEvent::Bytes(packet) => Transmit::Bytes(packet),
            PortEvent::Frame(frame) => Transmit::Frame(frame),
            event => return Heard::Port(role, event),
        };
        self.keep(role, device(role), what);
        self.machine.host.receive(now, port, &what);
        self.heard_at = Some(now);
        self.send(clock, now);
        Heard::Nothing
    }

    fn send(&mut self, clock: &Clock, now: Timestamp) {
        if self.machine.host.is_stalled() {
            return;
        }
        let told = self.machine.host.told(now);
        while let Some(sent) = self.machine.host.guest.transmit(told) {
            let (port, crossed) = node::output(sent);
            let role = if port == node::GYRO { GYRO } else { BASE };
            self.keep(role, Device::Controller, crossed);
            let port = if role == GYRO { Some(&mut self.gyro) } else { self.base.as_mut() };
            match (port, crossed) {
                (Some(port), Transmit::Bytes(packet)) => port.send_bytes(packet.as_slice()),
                (Some(port), Transmit::Frame(frame)) => port.send_frame(now, &frame),
                (None, _) => {}
            }
            if let Some(heard_at) = self.heard_at.take() {
                self.bus_to_command.add(clock.now() - heard_at);
            }
        }
        self.machine.ask_due();
    }

    fn keep(&mut self, role: &'static str, by: Device, crossed: Transmit) {
        if self.crossings.len() < CROSSINGS_MAX {
            self.crossings.push_back(Crossing { role, by, crossed });
        } else {
            self.dropped += 1;
        }
    }

    /// Returns what has crossed its ports, oldest first.
    pub(super) fn crossing(&mut self) -> Option<Crossing> {
        self.crossings.pop_front()
    }

    /// Number of items dropped by its machine or from the list of crossings.
    pub(super) fn dropped(&self) -> u64 {
        self.dropped + self.machine.host.dropped()
    }

    pub(super) fn port(&self, role: &str) -> Option<&RolePort> {
        if role == GYRO { Some(&self.gyro) } else { self.base.as_ref() }
    }

    pub(super) const fn bus_to_command(&self) -> &Histogram {
        &self.bus_to_command
    }
}
