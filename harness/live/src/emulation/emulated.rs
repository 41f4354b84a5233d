//! Emulated devices on their lines, without IO and without a clock.
//!
//! Even if calls are late, everything happens at its own instant: [`Emulated::wake`] goes from event to event, and at
//! equal times the gyro measures first, then data arrives from the lines, then the devices act.

mod tell;

use super::build::{Setup, build};
use super::request::{Fault, Get, Request, RequestError};
use crate::world::{BASE, GYRO, PortPlans, TABLE};
use emulators::parameters::Parameters as _;
use plan::faults::{Chances, FaultKind, Lasts, Lines, Target};
use rig::Rig;
use rig::bench::{Bench, Carrier};
use rig::line::EndId;
use rig::node::{Part, Woken};
use rig::robot::Robot;
use serde_json::{Value, json};
use std::collections::{BTreeMap, VecDeque};
use wire::device::Transmit;
use wire::time::Timestamp;
use wire::units::AngularRate;

/// Most items that wait for the ports; more are dropped and counted.
pub const OUTGOING_MAX: usize = 1_024;

/// A rig whose devices serve the programs at its ports.
#[derive(Debug)]
pub struct Emulated {
    pub(super) rig: Rig,
    pub(super) lines: Lines,
    faults: BTreeMap<usize, (Target, FaultKind, Timestamp)>,
    begun: usize,
    /// How often faults that are over have acted.
    pub(super) acted: u64,
    outgoing: VecDeque<(usize, EndId, Transmit)>,
    overflowed: u64,
    /// Why a device cannot go on.
    pub(super) failure: Option<String>,
    seed: u64,
    now: Timestamp,
}

impl Emulated {
    /// The devices of `setup` at rest at time zero, and the ports of their lines.
    pub fn new(setup: &Setup) -> (Self, PortPlans) {
        let (rig, ports, lines) = build(setup);
        let emulated = Self {
            rig,
            lines,
            faults: BTreeMap::new(),
            begun: 0,
            acted: 0,
            outgoing: VecDeque::new(),
            overflowed: 0,
            failure: None,
            seed: setup.seed,
            now: Timestamp::ZERO,
        };
        (emulated, ports)
    }

    /// Takes what arrived at the port at that end of a line.
    pub fn receive(&mut self, now: Timestamp, at: (usize, EndId), what: Transmit) {
        self.wake(now);
        self.rig.lines[at.0].send(now, at.1, what);
    }

    pub fn wake(&mut self, now: Timestamp) {
        while self.next_wakeup() <= now {
            // An overdue event happens now: time does not go backward.
            self.now = self.next_wakeup().max(self.now);
            self.step(self.now);
        }
        self.now = self.now.max(now);
    }

    /// When to call [`wake`](Self::wake) next.
    pub fn next_wakeup(&self) -> Timestamp {
        let faults = self.faults.values().map(|(.., until)| *until).min();
        let rig = self.rig.next_arrival().min(self.rig.next_wakeup());
        rig.min(faults.unwrap_or(Timestamp::MAX))
    }

    /// Returns the next item for the ports of a line, with the end that sent it; call after each of the above until it
    /// returns `None`.
    pub fn transmit(&mut self) -> Option<(usize, EndId, Transmit)> {
        self.outgoing.pop_front()
    }

    pub(super) fn counters(&self) -> Value {
        tell::counters(self)
    }

    /// Number of items dropped for lack of room.
    pub(super) fn dropped(&self) -> u64 {
        self.overflowed + self.rig.dropped()
    }

    fn step(&mut self, at: Timestamp) {
        let over = |(_, (.., until)): &(&usize, &(Target, FaultKind, Timestamp))| *until <= at;
        while let Some((number, _)) = self.faults.iter().find(over) {
            self.end_fault(at, *number);
        }
        for place in 0..self.rig.nodes.len() {
            self.rig.wake_gyro(at, place);
        }
        for line in 0..self.rig.lines.len() {
            while self.rig.lines[line].next_arrival() <= at
                && let Some((from, what)) = self.rig.lines[line].arrived(at)
            {
                self.rig.hand_over(at, line, from, &what, |_| {});
                if self.outgoing.len() < OUTGOING_MAX {
                    self.outgoing.push_back((line, from, what));
                } else {
                    self.overflowed += 1;
                }
            }
            // Only the record of a run uses error states.
            while self.rig.lines[line].state_change().is_some() {}
        }
        let failure = &mut self.failure;
        let told = |woken| {
            if let Woken::Failed(why) = woken {
                failure.get_or_insert(why);
            }
        };
        self.rig.wake_emulated(at, |_| {}, told);
        self.say(at);
    }

    /// Sends the outputs of the devices on their lines.
    fn say(&mut self, now: Timestamp) {
        for place in 0..self.rig.nodes.len() {
            self.rig.empty(now, place);
        }
    }

    /// Carries out a request and returns its answer.
    ///
    /// # Errors
    /// When it cannot be carried out; then nothing has changed.
    pub fn request(&mut self, now: Timestamp, request: &Request) -> Result<Value, RequestError> {
        self.wake(now);
        let told = match request {
            Request::Set { device, values } => {
                let name = self.choose(device.as_deref())?;
                for dry in [true, false] {
                    for (parameter, value) in values {
                        let parameter = tell::parameter_name(parameter);
                        self.set(now, &name, (parameter, *value), dry).map_err(|error| {
                            RequestError::Refused(format!(
                                "failed to set {name}.{parameter}: {error}; {{\"list\":true}} names all"
                            ))
                        })?;
                    }
                }
                json!({ "set": values.len() })
            }
            Request::Get(_, Get::Truth) => tell::truth(self, now),
            Request::Get(_, Get::Counters) => tell::counters(self),
            Request::Get(device, Get::Values(names)) => {
                let name = self.choose(device.as_deref())?;
                tell::values(self, &name, names).map_err(RequestError::Refused)?
            }
            Request::Turn(deg_per_s) => {
                self.turn(now, AngularRate::from_deg_per_s(*deg_per_s))?;
                json!({ "rate_deg_per_s": deg_per_s })
            }
            Request::Power { device, on } => {
                let name = self.choose(device.as_deref())?;
                let Some(device) = self.described(&name) else {
                    let why = format!(
                        "failed to switch the {name}: it has no switch; restart the gyro by a fault"
                    );
                    return Err(RequestError::Refused(why));
                };
                device.power(now, *on);
                json!({ "power": on })
            }
            Request::Fault { device, fault } => {
                let target = match device {
                    Some(name) => name.clone(),
                    None => self.choose(None)?,
                };
                self.begin_fault(now, &target, fault)?;
                json!({ "device": target, "fault": fault.kind.name() })
            }
            Request::NoFault => {
                while let Some(number) = self.faults.keys().next() {
                    self.end_fault(now, *number);
                }
                json!({ "fault": null })
            }
            Request::List => tell::list(self),
        };
        self.say(now);
        Ok(told)
    }

    pub(super) fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        for node in &self.rig.nodes {
            match &node.part {
                Part::Robot(robot) => {
                    const PARTS: [(Target, &str); 3] =
                        [(Target::Gyro, GYRO), (Target::Base, BASE), (Target::Table, TABLE)];
                    let there = PARTS.iter().filter(|(target, _)| robot.has(*target));
                    names.extend(there.map(|(_, name)| *name));
                }
                Part::Described(_) => names.push(&*node.name),
                _ => {}
            }
        }
        names
    }

    /// The gyro with its carrier, or the lone carrier, that includes this device.
    pub(super) fn robot(&self, name: &str) -> Option<&Robot> {
        let target = Target::named(name)?;
        self.rig.robots().find(|robot| robot.has(target))
    }

    pub(super) fn described(&mut self, name: &str) -> Option<&mut described::Device> {
        let place = self.rig.find(name)?;
        match &mut self.rig.nodes[place].part {
            Part::Described(described) => Some(described),
            _ => None,
        }
    }

    /// A described device, for inspection.
    pub(super) fn shown(&self, name: &str) -> Option<&described::Device> {
        match &self.rig.nodes[self.rig.find(name)?].part {
            Part::Described(described) => Some(described),
            _ => None,
        }
    }

    fn choose(&self, device: Option<&str>) -> Result<String, RequestError> {
        let names = self.names();
        let there = names.join(", ");
        match (device, names.as_slice()) {
            (Some(device), names) if names.contains(&device) => Ok(device.to_owned()),
            (Some(device), _) => Err(RequestError::NoDevice { device: device.to_owned(), there }),
            (None, [only]) => Ok((*only).to_owned()),
            (None, _) => Err(RequestError::WhichDevice { there }),
        }
    }

    fn set(
        &mut self,
        now: Timestamp,
        name: &str,
        (parameter, value): (&str, f64),
        dry: bool,
    ) -> Result<(), String> {
        if let Some(device) = self.described(name) {
            device.description().check_parameter(parameter, value)?;
            if !dry {
                device.set_parameter(now, parameter, value);
            }
            return Ok(());
        }
        let Some(target) = Target::named(name) else { return Ok(()) };
        let Some(robot) = self.rig.robots_mut().find(|robot| robot.has(target)) else {
            return Ok(());
        };
        let Bench { gyro, carrier, .. } = &mut robot.bench;
        let set = match (target, carrier) {
            (Target::Gyro, _) if dry => gyro.parameters().clone().set(parameter, value),
            (Target::Gyro, _) => gyro.set_parameter(parameter, value),
            (_, Carrier::Base(base)) if dry => base.parameters().clone().set(parameter, value),
            (_, Carrier::Base(base)) => base.set_parameter(now, parameter, value),
            (_, Carrier::Table(table)) if dry => table.parameters().clone().set(parameter, value),
            (_, Carrier::Table(table)) => table.set_parameter(now, parameter, value),
            (_, Carrier::Turning(_)) => Ok(()),
        };
        set.map_err(|error| error.to_string())
    }

    fn turn(&mut self, now: Timestamp, rate: AngularRate) -> Result<(), RequestError> {
        let robot = self.rig.robots_mut().find(|robot| robot.has(Target::Gyro));
        let why = match robot.map(|robot| &mut robot.bench.carrier) {
            Some(Carrier::Turning(turning)) => {
                turning.turn(now, rate);
                return Ok(());
            }
            None => "there is none here",
            Some(Carrier::Base(_)) => "the base carries it",
            Some(Carrier::Table(_)) => "the table carries it",
        };
        Err(RequestError::Refused(format!("failed to turn the gyro: {why}")))
    }

    fn begin_fault(
        &mut self,
        now: Timestamp,
        name: &str,
        fault: &Fault,
    ) -> Result<(), RequestError> {
        let no_device =
            || RequestError::NoDevice { device: name.to_owned(), there: self.names().join(", ") };
        let target = Target::named(name).ok_or_else(no_device)?;
        let declared = plan::faults::Fault {
            toward: fault.toward,
            duration: fault.duration,
            ..plan::faults::Fault::new(target, fault.kind)
        };
        declared.check(&self.lines).map_err(|unfit| {
            let help = unfit.help.map(|help| format!("; {help}")).unwrap_or_default();
            RequestError::Refused(format!("failed to strike the {name}: {}{help}", unfit.message))
        })?;
        let number = self.begun;
        self.begun += 1;
        let chances = Chances::new(self.seed, &declared, number);
        let acted =
            self.rig.begin_fault(now, number, (target, fault.toward, &fault.kind), &chances);
        self.acted += acted;
        if fault.kind.info().lasts != Lasts::Instant {
            let until = declared.lasting().map_or(Timestamp::MAX, |lasting| now + lasting);
            self.faults.insert(number, (target, fault.kind, until));
        }
        Ok(())
    }

    fn end_fault(&mut self, now: Timestamp, number: usize) {
        if let Some((target, kind, _)) = self.faults.remove(&number) {
            self.acted += self.rig.end_fault(now, number, (target, &kind));
        }
    }
}

#[cfg(test)]
mod tests;
