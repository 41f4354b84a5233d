//! Our controller in the process of the harness, on the ports that a process of its own would open.

use super::clock::Clock;
use super::device_under_test::StartError;
use super::histogram::Histogram;
use super::ports::{BASE, GYRO, Wiring, base_traffic, device};
use super::role_port::{PortEvent, RolePort, Traffic, next};
use crate::record::Device;
use crate::world::faults::Host;
use controller::config::Config;
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use std::collections::VecDeque;
use wire::device::Transmit;
use wire::time::Timestamp;

/// Crossings that wait to be told; far more than one turn of the loop can bring. More are counted as dropped.
const CROSSINGS_MAX: usize = 256;

/// Something crossed a port of the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Crossing {
    /// The role that the port leads to.
    pub(super) role: &'static str,
    /// Who sent it.
    pub(super) by: Device,
    pub(super) crossed: Transmit,
}

/// The controller and its ports. Where faults can strike its machine, `host` is that machine.
#[derive(Debug)]
pub(super) struct InProcess {
    controller: Controller,
    gyro: RolePort,
    base: Option<RolePort>,
    crossings: VecDeque<Crossing>,
    dropped: u64,
    /// The last thing heard, until a command follows it.
    heard_at: Option<Timestamp>,
    bus_to_command: Histogram,
}

/// What came of listening.
pub(super) enum InProcessEvent {
    Report(Report),
    /// Something was taken in.
    Taken,
    /// A port tells of itself.
    Port(&'static str, PortEvent),
}

impl InProcess {
    /// Opens the ports.
    ///
    /// # Errors
    ///
    /// When a port cannot be opened, or nobody knows where it is.
    pub(super) async fn start(config: Config, wiring: &Wiring) -> Result<Self, StartError> {
        let known = |role| StartError::NoFarSide { role };
        let gyro = wiring.gyro.as_ref().ok_or(known(GYRO))?;
        let gyro = RolePort::open(gyro, Traffic::Bytes(config.gyro.stream.format.serial())).await?;
        let base = match config.base {
            None => None,
            Some(base) => {
                let spec = wiring.base.as_ref().ok_or(known(BASE))?;
                Some(RolePort::open(spec, base_traffic(base.transport)).await?)
            }
        };
        Ok(Self {
            controller: Controller::new(config, Timestamp::ZERO),
            gyro,
            base,
            crossings: VecDeque::new(),
            dropped: 0,
            heard_at: None,
            bus_to_command: Histogram::default(),
        })
    }

    pub(super) fn command(&mut self, clock: &Clock, mission: Mission, host: Option<&mut Host>) {
        let now = clock.now();
        match host {
            None => {
                self.controller.command(now, mission);
                self.send(clock, now, None);
            }
            Some(host) => {
                host.mission(now, mission, &mut self.controller);
                self.send(clock, now, Some(host));
            }
        }
    }

    pub(super) fn wake(&mut self, clock: &Clock, now: Timestamp, host: Option<&Host>) {
        if self.next_wakeup(host) <= now {
            self.controller.wake(host.map_or(now, |host| host.told(now)));
            self.send(clock, now, host);
        }
    }

    /// Its machine was struck, or goes on: it may have something to say.
    pub(super) fn struck(&mut self, clock: &Clock, now: Timestamp, host: &Host) {
        self.send(clock, now, Some(host));
    }

    /// What faults of its machine strike.
    pub(super) const fn controller(&mut self) -> &mut Controller {
        &mut self.controller
    }

    /// On the clock of the bench.
    pub(super) fn next_wakeup(&self, host: Option<&Host>) -> Timestamp {
        match host {
            None => self.controller.next_wakeup(),
            Some(host) if host.is_stalled() => Timestamp::MAX,
            Some(host) => host.when(self.controller.next_wakeup()),
        }
    }

    /// Waits for what comes next. May be called off without losing anything.
    pub(super) async fn heard(
        &mut self,
        clock: &Clock,
        mut host: Option<&mut Host>,
    ) -> InProcessEvent {
        let stalled = host.as_deref().is_some_and(Host::is_stalled);
        if let Some(report) = if stalled { None } else { self.controller.report() } {
            return InProcessEvent::Report(report);
        }
        let (port, role, event) = tokio::select! {
            event = self.gyro.next() => (Port::Gyro, GYRO, event),
            event = next(self.base.as_mut()) => (Port::Base, BASE, event),
        };
        let now = clock.now();
        match event {
            PortEvent::Bytes(packet) => {
                self.keep(role, device(role), Transmit::Bytes(packet));
                match host.as_deref_mut() {
                    None => self.controller.receive(now, port, Input::Bytes(packet.as_slice())),
                    Some(host) => host.bytes(now, port, packet, &mut self.controller),
                }
            }
            PortEvent::Frame(frame) => {
                self.keep(role, device(role), Transmit::Frame(frame));
                match host.as_deref_mut() {
                    None => self.controller.receive(now, port, Input::Frame(frame)),
                    Some(host) => host.frame(now, frame, &mut self.controller),
                }
            }
            event => return InProcessEvent::Port(role, event),
        }
        self.heard_at = Some(now);
        self.send(clock, now, host.as_deref());
        InProcessEvent::Taken
    }

    /// Puts what the controller has to say on its lines.
    fn send(&mut self, clock: &Clock, now: Timestamp, host: Option<&Host>) {
        if host.is_some_and(Host::is_stalled) {
            return;
        }
        let told = host.map_or(now, |host| host.told(now));
        while let Some(output) = self.controller.transmit(told) {
            let (role, crossed) = match output {
                Output::Bytes(Port::Gyro, packet) => (GYRO, Transmit::Bytes(packet)),
                Output::Bytes(Port::Base, packet) => (BASE, Transmit::Bytes(packet)),
                Output::Frame(frame) => (BASE, Transmit::Frame(frame)),
            };
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
    }

    fn keep(&mut self, role: &'static str, by: Device, crossed: Transmit) {
        if self.crossings.len() < CROSSINGS_MAX {
            self.crossings.push_back(Crossing { role, by, crossed });
        } else {
            self.dropped += 1;
        }
    }

    /// What has crossed its ports, oldest first.
    pub(super) fn crossing(&mut self) -> Option<Crossing> {
        self.crossings.pop_front()
    }

    /// Crossings that are told to nobody, for want of room.
    pub(super) const fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Its port for a role.
    pub(super) fn port(&self, role: &str) -> Option<&RolePort> {
        if role == GYRO { Some(&self.gyro) } else { self.base.as_ref() }
    }

    pub(super) const fn bus_to_command(&self) -> &Histogram {
        &self.bus_to_command
    }
}
