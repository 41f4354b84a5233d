//! Our controller in the process of the harness, on the ports that a process of its own would open.

use super::clock::Clock;
use super::device_under_test::StartError;
use super::histogram::Histogram;
use super::ports::{BASE, GYRO, Wiring, base_traffic, device};
use super::role_port::{PortEvent, RolePort, Traffic, next};
use crate::record::Device;
use controller::config::Config;
use controller::mission::{Mission, Report};
use controller::{Controller, Input, Output, Port};
use std::collections::{BTreeSet, VecDeque};
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Crossings that wait to be recorded; far more than one turn of the loop can bring.
const CROSSINGS_MAX: usize = 256;

/// What crossed a port that only the controller has open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Crossed {
    Bytes(Packet),
    Frame(CanFrame),
}

/// The controller and its ports.
#[derive(Debug)]
pub(super) struct InProcess {
    controller: Controller,
    gyro: RolePort,
    base: Option<RolePort>,
    /// Roles whose ports nobody else hears.
    unheard: BTreeSet<&'static str>,
    crossings: VecDeque<(Device, Crossed)>,
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
    /// Opens the ports. `unheard` are the roles whose traffic is to be kept for the record.
    ///
    /// # Errors
    ///
    /// When a port cannot be opened, or nobody knows where it is.
    pub(super) async fn start(
        config: Config,
        wiring: &Wiring,
        unheard: BTreeSet<&'static str>,
    ) -> Result<Self, StartError> {
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
            unheard,
            crossings: VecDeque::new(),
            heard_at: None,
            bus_to_command: Histogram::default(),
        })
    }

    pub(super) fn command(&mut self, clock: &Clock, mission: Mission) {
        let now = clock.now();
        self.controller.command(now, mission);
        self.send(clock, now);
    }

    pub(super) fn wake(&mut self, clock: &Clock, now: Timestamp) {
        if self.controller.next_wakeup() <= now {
            self.controller.wake(now);
            self.send(clock, now);
        }
    }

    pub(super) fn next_wakeup(&self) -> Timestamp {
        self.controller.next_wakeup()
    }

    /// Waits for what comes next. May be called off without losing anything.
    pub(super) async fn heard(&mut self, clock: &Clock) -> InProcessEvent {
        if let Some(report) = self.controller.report() {
            return InProcessEvent::Report(report);
        }
        let (port, role, event) = tokio::select! {
            event = self.gyro.next() => (Port::Gyro, GYRO, event),
            event = next(self.base.as_mut()) => (Port::Base, BASE, event),
        };
        let now = clock.now();
        match event {
            PortEvent::Bytes(packet) => {
                self.keep(role, device(role), Crossed::Bytes(packet));
                self.controller.receive(now, port, Input::Bytes(packet.as_slice()));
            }
            PortEvent::Frame(frame) => {
                self.keep(role, device(role), Crossed::Frame(frame));
                self.controller.receive(now, port, Input::Frame(frame));
            }
            event => return InProcessEvent::Port(role, event),
        }
        self.heard_at = Some(now);
        self.send(clock, now);
        InProcessEvent::Taken
    }

    /// Puts what the controller has to say on its lines.
    fn send(&mut self, clock: &Clock, now: Timestamp) {
        while let Some(output) = self.controller.transmit(now) {
            let (role, crossed) = match output {
                Output::Bytes(Port::Gyro, packet) => (GYRO, Crossed::Bytes(packet)),
                Output::Bytes(Port::Base, packet) => (BASE, Crossed::Bytes(packet)),
                Output::Frame(frame) => (BASE, Crossed::Frame(frame)),
            };
            self.keep(role, Device::Controller, crossed);
            let port = if role == GYRO { Some(&mut self.gyro) } else { self.base.as_mut() };
            match (port, crossed) {
                (Some(port), Crossed::Bytes(packet)) => port.send_bytes(packet.as_slice()),
                (Some(port), Crossed::Frame(frame)) => port.send_frame(now, &frame),
                (None, _) => {}
            }
            if let Some(heard_at) = self.heard_at.take() {
                self.bus_to_command.add(clock.now() - heard_at);
            }
        }
    }

    fn keep(&mut self, role: &str, device: Device, crossed: Crossed) {
        if self.unheard.contains(role) && self.crossings.len() < CROSSINGS_MAX {
            self.crossings.push_back((device, crossed));
        }
    }

    /// What has crossed a port that nobody else hears, oldest first.
    pub(super) fn crossing(&mut self) -> Option<(Device, Crossed)> {
        self.crossings.pop_front()
    }

    /// Its port for a role.
    pub(super) fn port(&self, role: &str) -> Option<&RolePort> {
        if role == GYRO { Some(&self.gyro) } else { self.base.as_ref() }
    }

    pub(super) const fn bus_to_command(&self) -> &Histogram {
        &self.bus_to_command
    }
}
