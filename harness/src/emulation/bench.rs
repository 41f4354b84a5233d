//! Emulated devices and their links, without IO and without a clock.
//!
//! Whatever is late, everything happens at its own instant: [`EmulatedBench::wake`] goes from event to
//! event, and at equal times the gyro measures first, then bytes arrive, then the carriers go on.

use super::Role;
use super::link::{Link, LinkFault, Output, Pace};
use super::request::{Fault, Get, Request, RequestError};
use super::tell;
use emulators::base::{BaseEmulator, BaseParameters, Transport};
use emulators::device_file::Mount;
use emulators::gyro::{GyroEmulator, GyroParameters};
use emulators::parameters::Parameters;
use emulators::table::{TableEmulator, TableParameters};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use wire::device::Transmit;
use wire::gyro::GyroStream;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, AngularRate};

/// The true rate is the mean over this long from now on, as things are going now.
const RATE_SPAN: Span = Span::from_millis(1);

/// The devices of a bench.
#[derive(Debug, Clone, Default)]
pub struct Parts {
    /// The gyro.
    pub gyro: Option<(GyroStream, GyroParameters)>,
    /// The base.
    pub base: Option<(Transport, BaseParameters)>,
    /// The table.
    pub table: Option<TableParameters>,
    /// What carries the gyro; nothing does where it, or what is named, is absent.
    pub mount: Option<Mount>,
}

/// What arrives at a device.
pub type Input = Output;

/// Emulated devices, each behind a link.
#[derive(Debug)]
pub struct EmulatedBench {
    pub(super) gyro: Option<GyroEmulator>,
    pub(super) base: Option<BaseEmulator>,
    pub(super) table: Option<TableEmulator>,
    base_transport: Option<Transport>,
    mount: Option<Mount>,
    turning: Turning,
    pub(super) links: BTreeMap<Role, Link>,
    emergency_stop_until: Option<Timestamp>,
    drive_fault_until: Option<Timestamp>,
    now: Timestamp,
}

/// What carries a gyro that nothing else carries.
#[derive(Debug, Clone, Copy, Default)]
struct Turning {
    since: Timestamp,
    from: Angle,
    rate: AngularRate,
}

impl Turning {
    fn angle_at(&self, at: Timestamp) -> Angle {
        self.from + Angle::from_rad(self.rate.rad_per_s() * (at - self.since).as_secs_f64())
    }
}

impl EmulatedBench {
    /// The devices, each with its own random numbers from `seed`, at rest at time zero. A device
    /// without a pace has no port: what it sends nobody hears.
    pub fn new(parts: Parts, paces: &BTreeMap<Role, Pace>, seed: u64) -> Self {
        let link = |(role, pace): (&Role, &Pace)| (*role, Link::new(*pace, seed, role.name()));
        let carried = match parts.mount {
            Some(Mount::Base) => parts.base.is_some(),
            Some(Mount::Table) => parts.table.is_some(),
            None => false,
        };
        Self {
            base_transport: parts.base.as_ref().map(|(transport, _)| *transport),
            gyro: parts.gyro.map(|(stream, parameters)| {
                GyroEmulator::new(parameters, stream, seed, Role::Gyro.name())
            }),
            base: parts.base.map(|(transport, parameters)| {
                BaseEmulator::new(parameters, transport, seed, Role::Base.name())
            }),
            table: parts.table.map(TableEmulator::new),
            mount: parts.mount.filter(|_| carried),
            turning: Turning::default(),
            links: paces.iter().map(link).collect(),
            emergency_stop_until: None,
            drive_fault_until: None,
            now: Timestamp::ZERO,
        }
    }

    /// The devices there are.
    pub fn roles(&self) -> impl Iterator<Item = Role> + '_ {
        Role::ALL.into_iter().filter(|role| match role {
            Role::Gyro => self.gyro.is_some(),
            Role::Base => self.base.is_some(),
            Role::Table => self.table.is_some(),
        })
    }

    /// Something arrived at the port of `role`.
    pub fn receive(&mut self, now: Timestamp, role: Role, input: Input) {
        self.wake(now);
        match input {
            Output::Bytes(bytes) => {
                let through = self.links.get_mut(&role).and_then(|link| link.receive(now, bytes));
                if let Some(bytes) = through {
                    self.deliver(now, role, bytes.as_slice());
                }
            }
            Output::Frame(frame) => {
                if let Some(base) = &mut self.base {
                    base.receive_frame(now, &frame);
                }
            }
        }
        self.collect(now);
    }

    /// Goes on to `now`.
    pub fn wake(&mut self, now: Timestamp) {
        while self.next_wakeup() <= now {
            // What was due before is late, and happens now: time does not go backward.
            let at = self.next_wakeup().max(self.now);
            self.step(at);
        }
        self.now = self.now.max(now);
    }

    /// When to call [`wake`](Self::wake) next.
    pub fn next_wakeup(&self) -> Timestamp {
        let gyro = self.gyro.as_ref().map(GyroEmulator::next_wakeup);
        let base = self.base.as_ref().and_then(BaseEmulator::next_wakeup);
        let table = self.table.as_ref().and_then(TableEmulator::next_wakeup);
        let faults = [self.emergency_stop_until, self.drive_fault_until];
        let links = self.links.values().map(Link::next_wakeup);
        [gyro, base, table]
            .into_iter()
            .chain(faults)
            .flatten()
            .chain(links)
            .min()
            .unwrap_or(Timestamp::MAX)
    }

    /// The next thing to hand to a port; call until there is none after each of the above.
    pub fn transmit(&mut self) -> Option<(Role, Output)> {
        self.links.iter_mut().find_map(|(role, link)| Some((*role, link.transmit()?)))
    }

    /// Carries out a request and says what is to be answered.
    ///
    /// # Errors
    ///
    /// When it cannot be carried out; then nothing has changed.
    pub fn request(&mut self, now: Timestamp, request: &Request) -> Result<Value, RequestError> {
        self.wake(now);
        let told = match request {
            Request::Set { device, values } => {
                let role = self.choose(*device)?;
                self.set(now, role, values)?;
                json!({ "set": values.len() })
            }
            Request::Get(Get::Truth) => tell::truth(self, now),
            Request::Get(Get::Counters) => tell::counters(self),
            Request::Turn(deg_per_s) => {
                self.turn(now, AngularRate::from_deg_per_s(*deg_per_s))?;
                json!({ "rate_deg_per_s": deg_per_s })
            }
            Request::Fault { device, fault, duration } => {
                let role = self.choose(*device)?;
                let until = duration.map_or(Timestamp::MAX, |duration| now + duration);
                self.fail(now, role, *fault, until)?;
                json!({ "device": role, "fault": fault.name() })
            }
            Request::List => tell::list(self),
        };
        self.collect(now);
        Ok(told)
    }

    /// Faults that a device can have, by the names of [`Fault`].
    pub(super) fn faults_of(&self, role: Role) -> Vec<&'static str> {
        let mut known = Vec::new();
        if self.links.contains_key(&role) {
            known.extend(["silent", "drop", "delay"]);
            known.extend(self.can_be_stuck(role).then_some("stuck"));
        }
        if role == Role::Base {
            known.extend(["emergency_stop", "drive_fault"]);
        }
        known.push("none");
        known
    }

    /// True heading of what carries the gyro, of a bench without one that of the base or the table.
    pub(super) fn heading_at(&self, at: Timestamp) -> Angle {
        match (self.mount, &self.gyro, &self.base, &self.table) {
            (Some(Mount::Table), _, _, Some(table)) | (None, None, None, Some(table)) => {
                table.angle_at(at)
            }
            (Some(Mount::Base), _, Some(base), _) | (None, None, Some(base), _) => {
                base.turret_heading_at(at)
            }
            _ => self.turning.angle_at(at),
        }
    }

    /// How fast that heading changes.
    pub(super) fn rate_at(&self, at: Timestamp) -> AngularRate {
        let turned = self.heading_at(at + RATE_SPAN) - self.heading_at(at);
        AngularRate::from_rad_per_s(turned.rad() / RATE_SPAN.as_secs_f64())
    }

    fn step(&mut self, at: Timestamp) {
        self.now = at;
        self.measure(at);
        for role in Role::ALL {
            while let Some(bytes) = self.links.get_mut(&role).and_then(|link| link.arrived(at)) {
                self.deliver(at, role, bytes.as_slice());
            }
        }
        if let Some(base) = &mut self.base {
            if self.emergency_stop_until.take_if(|until| *until <= at).is_some() {
                base.set_emergency_stop(at, false);
            }
            if self.drive_fault_until.take_if(|until| *until <= at).is_some() {
                base.set_fault(at, false);
            }
            if base.next_wakeup().is_some_and(|due| due <= at) {
                base.wake(at);
            }
        }
        if let Some(table) = &mut self.table {
            table.wake(at);
        }
        self.collect(at);
        for link in self.links.values_mut() {
            link.wake(at);
        }
    }

    /// The gyro's outputs up to `at`, each at its own instant.
    fn measure(&mut self, at: Timestamp) {
        while let Some(due) = self.gyro.as_ref().map(GyroEmulator::next_wakeup)
            && due <= at
        {
            let heading = self.heading_at(due);
            let Some(gyro) = &mut self.gyro else { return };
            if let (Some(Mount::Base), Some(base)) = (self.mount, &self.base)
                && gyro.feels_motors()
            {
                gyro.set_motor_current(base.motor_current_at(due));
            }
            if let (Some(packet), Some(link)) =
                (gyro.wake(due, heading), self.links.get_mut(&Role::Gyro))
            {
                link.send(due, Output::Bytes(packet));
            }
        }
    }

    fn deliver(&mut self, now: Timestamp, role: Role, bytes: &[u8]) {
        match role {
            Role::Gyro => {
                if let Some(gyro) = &mut self.gyro {
                    gyro.receive(now, bytes);
                }
            }
            Role::Base => {
                if let Some(base) = &mut self.base {
                    base.receive_bytes(now, bytes);
                }
            }
            Role::Table => {
                if let Some(table) = &mut self.table {
                    table.receive(now, bytes);
                }
            }
        }
    }

    /// Puts what the devices have to send on their links.
    fn collect(&mut self, now: Timestamp) {
        while let Some(output) = self.base.as_mut().and_then(BaseEmulator::transmit) {
            if let Some(link) = self.links.get_mut(&Role::Base) {
                link.send(
                    now,
                    match output {
                        Transmit::Frame(frame) => Output::Frame(frame),
                        Transmit::Bytes(packet) => Output::Bytes(packet),
                    },
                );
            }
        }
        while let Some(packet) = self.table.as_mut().and_then(TableEmulator::transmit) {
            if let Some(link) = self.links.get_mut(&Role::Table) {
                link.send(now, Output::Bytes(packet));
            }
        }
    }

    /// The device that a request means.
    fn choose(&self, device: Option<Role>) -> Result<Role, RequestError> {
        let there = || self.roles().map(Role::name).collect::<Vec<_>>().join(", ");
        match device {
            Some(device) if self.roles().any(|role| role == device) => Ok(device),
            Some(device) => Err(RequestError::NoDevice { device, there: there() }),
            None => {
                let mut roles = self.roles();
                match (roles.next(), roles.next()) {
                    (Some(only), None) => Ok(only),
                    _ => Err(RequestError::WhichDevice { there: there() }),
                }
            }
        }
    }

    fn set(
        &mut self,
        now: Timestamp,
        role: Role,
        values: &BTreeMap<String, f64>,
    ) -> Result<(), RequestError> {
        for dry in [true, false] {
            for (name, value) in values {
                let name = tell::parameter_name(name);
                let result = match role {
                    Role::Gyro => self.gyro.as_mut().map(|gyro| match dry {
                        true => gyro.parameters().clone().set(name, *value),
                        false => gyro.set_parameter(name, *value),
                    }),
                    Role::Base => self.base.as_mut().map(|base| match dry {
                        true => base.parameters().clone().set(name, *value),
                        false => base.set_parameter(now, name, *value),
                    }),
                    Role::Table => self.table.as_mut().map(|table| match dry {
                        true => table.parameters().clone().set(name, *value),
                        false => table.set_parameter(now, name, *value),
                    }),
                };
                result.unwrap_or(Ok(())).map_err(|error| RequestError::Parameter {
                    device: role,
                    parameter: name.to_owned(),
                    error,
                })?;
            }
        }
        Ok(())
    }

    fn turn(&mut self, now: Timestamp, rate: AngularRate) -> Result<(), RequestError> {
        match (&self.gyro, self.mount) {
            (None, _) => Err(RequestError::NotTurned("there is none here")),
            (_, Some(Mount::Base)) => Err(RequestError::NotTurned("the base carries it")),
            (_, Some(Mount::Table)) => Err(RequestError::NotTurned("the table carries it")),
            (Some(_), None) => {
                self.turning = Turning { since: now, from: self.turning.angle_at(now), rate };
                Ok(())
            }
        }
    }

    fn can_be_stuck(&self, role: Role) -> bool {
        // An answer of a serial line belongs to its question, and one that is repeated is no answer.
        role == Role::Gyro || role == Role::Base && self.base_transport == Some(Transport::Can)
    }

    fn fail(
        &mut self,
        now: Timestamp,
        role: Role,
        fault: Fault,
        until: Timestamp,
    ) -> Result<(), RequestError> {
        let cannot = |why| RequestError::CannotFail {
            device: role,
            fault: fault.name(),
            why,
            known: self.faults_of(role).join(", "),
        };
        if matches!(fault, Fault::Link(_)) && !self.links.contains_key(&role) {
            return Err(cannot("it has no port"));
        }
        if fault == Fault::Link(LinkFault::Stuck) && !self.can_be_stuck(role) {
            return Err(cannot("it only answers, and a repeated answer is none"));
        }
        if matches!(fault, Fault::EmergencyStop | Fault::DriveFault) && role != Role::Base {
            return Err(cannot("it has no drives"));
        }
        match (fault, self.links.get_mut(&role), &mut self.base) {
            (Fault::Link(fault), Some(link), _) => link.set_fault(fault, until),
            (Fault::EmergencyStop, _, Some(base)) => {
                base.set_emergency_stop(now, true);
                self.emergency_stop_until = Some(until);
            }
            (Fault::DriveFault, _, Some(base)) => {
                base.set_fault(now, true);
                self.drive_fault_until = Some(until);
            }
            (Fault::None, link, base) => {
                if let Some(link) = link {
                    link.clear_fault();
                }
                if let (Role::Base, Some(base)) = (role, base) {
                    base.set_emergency_stop(now, false);
                    base.set_fault(now, false);
                    (self.emergency_stop_until, self.drive_fault_until) = (None, None);
                }
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
