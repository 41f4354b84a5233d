//! A node of a rig.

use super::error_frame;
use super::host::{Guest, OnHost};
use super::own::Own;
use super::replayed::Replaying;
use super::robot::Robot;
use super::tester::Tester;
use crate::hosted::{Hosted, HostedController as _};
use crate::link::StateChange;
use controller::mission::Mission;
use controller::{Input, Output, Port};
use described::Description;
use plan::DEVICE;
use plan::faults::FaultKind;
use std::sync::Arc;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

#[derive(Debug)]
pub struct Node {
    pub name: Arc<str>,
    pub part: Part,
    /// Line and end of each port.
    pub(super) routes: Vec<Option<Route>>,
}

/// Line and end at which a port is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Route {
    pub(super) line: usize,
    pub(super) end: super::line::EndId,
}

#[derive(Debug)]
pub enum Part {
    /// Emulated, built in: the gyro and its carrier.
    Robot(Box<Robot>),
    Described(Box<Described>),
    /// Under test in this process; takes missions.
    Controller(Box<Machine>),
    /// The user's own code in this process: emulated or under test.
    Own(Own),
    /// Sends messages that the plan orders.
    Tester(Box<Tester>),
    Replayed(Replaying),
    /// The plan's own port to the table.
    Plan,
    /// At a port of this machine: a process, or a real device.
    Away,
}

impl Node {
    pub fn new(name: &str, part: Part) -> Self {
        Self { name: name.into(), part, routes: Vec::new() }
    }

    pub(super) fn route(&self, port: PortId) -> Option<Route> {
        self.routes.get(usize::from(port.0)).copied().flatten()
    }

    /// A copy in the same state, which runs on its own. `None` for user code, programs and FMUs, which cannot
    /// be copied.
    pub(super) fn copied(&self) -> Option<Self> {
        let part = match &self.part {
            Part::Robot(robot) => Part::Robot(robot.clone()),
            Part::Described(described) if described.device.can_be_copied() => {
                Part::Described(described.clone())
            }
            Part::Controller(machine) => Part::Controller(Box::new(machine.copied()?)),
            Part::Tester(tester) => Part::Tester(tester.clone()),
            Part::Replayed(replaying) => Part::Replayed(replaying.clone()),
            Part::Plan => Part::Plan,
            Part::Own(_) | Part::Described(_) | Part::Away => return None,
        };
        Some(Self { name: self.name.clone(), part, routes: self.routes.clone() })
    }

    /// Whether the node is emulated: woken before the devices under test.
    pub const fn is_emulated(&self) -> bool {
        matches!(self.part, Part::Robot(_) | Part::Described(_))
    }

    #[inline]
    pub(super) fn receive(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        match &mut self.part {
            Part::Controller(machine) => machine.host.receive(now, port, what),
            Part::Robot(robot) => robot.receive(now, port, what),
            Part::Described(described) => described.receive(now, what),
            Part::Own(own) => own.receive(now, port, what),
            Part::Tester(tester) => tester.receive(now, what),
            // They read the line together with all other traffic.
            Part::Replayed(_) | Part::Plan | Part::Away => {}
        }
    }

    /// Tells a device under test that its end of a bus has changed its error state.
    pub(super) fn confined(&mut self, now: Timestamp, port: PortId, change: &StateChange) {
        if let Part::Own(own) = &mut self.part {
            let (id, data) = error_frame::of(change);
            let now = own.told(now);
            own.guest.error_frame(now, port, id, data);
        }
    }

    #[inline]
    pub(super) fn next_wakeup(&self) -> Timestamp {
        match &self.part {
            Part::Controller(machine) => machine.next_wakeup(),
            Part::Robot(robot) => robot.next_wakeup(),
            Part::Described(described) => described.next_wakeup(),
            Part::Own(own) => own.next_wakeup(),
            Part::Tester(tester) => tester.next_wakeup(),
            Part::Replayed(replaying) => replaying.next_wakeup(),
            Part::Plan | Part::Away => Timestamp::MAX,
        }
    }

    /// Lets faults strike its machine from now on.
    pub(super) fn with_faults(&mut self) {
        match &mut self.part {
            Part::Controller(machine) => machine.host.with_faults(),
            Part::Own(own) => own.with_faults(),
            _ => {}
        }
    }

    pub(super) fn begin_fault(&mut self, kind: &FaultKind) {
        match &mut self.part {
            Part::Controller(machine) => machine.host.begin_fault(kind),
            Part::Own(own) => own.begin_fault(kind),
            _ => {}
        }
    }

    pub(super) fn end_fault(&mut self, now: Timestamp, kind: &FaultKind) -> u64 {
        match &mut self.part {
            Part::Controller(machine) => machine.end_fault(now, kind),
            Part::Own(own) => {
                let due = own.when(own.guest.next_wakeup());
                own.end_fault(now, kind, due)
            }
            _ => 0,
        }
    }

    /// Items dropped by the node or its buffers.
    pub(super) fn dropped(&self) -> u64 {
        match &self.part {
            Part::Controller(machine) => machine.host.dropped(),
            Part::Described(described) => described.device.dropped(),
            Part::Own(own) => own.dropped(),
            _ => 0,
        }
    }
}

/// What has become of an emulated device.
#[derive(Debug)]
pub enum Woken {
    /// It has been switched on again.
    Back,
    /// It cannot go on; why.
    Failed(String),
}

/// A described device with a power switch.
#[derive(Debug, Clone)]
pub struct Described {
    pub device: described::Device,
    /// When it is switched on again.
    on_at: Option<Timestamp>,
}

impl Described {
    /// Creates the device. Its random numbers come from `seed` and the name of the node.
    pub fn new(node: &str, description: &Arc<Description>, seed: u64) -> Self {
        let named = match node == DEVICE || node == description.name {
            true => Arc::clone(description),
            false => Arc::new(description.named(node)),
        };
        Self { device: described::Device::new(named, seed), on_at: None }
    }

    pub(super) fn receive(&mut self, now: Timestamp, what: &Transmit) {
        match what {
            Transmit::Frame(frame) => self.device.receive_frame(now, frame),
            Transmit::Bytes(packet) => self.device.receive_bytes(now, packet.as_slice()),
        }
    }

    /// Does what is due; returns whether the device has just been switched on again.
    pub fn wake(&mut self, now: Timestamp) -> bool {
        let is_back = self.on_at.take_if(|at| *at <= now).is_some();
        if is_back {
            self.device.power(now, true);
        }
        if self.device.next_wakeup() <= now {
            self.device.wake(now);
        }
        is_back
    }

    pub fn next_wakeup(&self) -> Timestamp {
        self.device.next_wakeup().min(self.on_at.unwrap_or(Timestamp::MAX))
    }

    /// Switches the device off, and on again at `on_at`.
    pub fn cycle(&mut self, now: Timestamp, on_at: Timestamp) {
        self.device.power(now, false);
        self.on_at = Some(on_at);
    }
}

/// The controller's port to its gyro.
pub const GYRO: PortId = PortId(0);
/// The controller's port to its base.
pub const BASE: PortId = PortId(1);

#[derive(Debug)]
pub struct Machine {
    pub host: OnHost<Hosted>,
    /// When the controller wants to be woken; updated after each input.
    due: Timestamp,
}

impl Machine {
    pub const fn new(controller: Hosted) -> Self {
        Self { host: OnHost::new(controller), due: Timestamp::ZERO }
    }

    fn copied(&self) -> Option<Self> {
        let Hosted::Ours(controller) = &self.host.guest else { return None };
        let host = self.host.with_guest(Hosted::Ours(controller.clone()));
        Some(Self { host, due: self.due })
    }

    /// Whether the controller is due and its machine runs.
    #[inline]
    pub fn is_due(&self, now: Timestamp) -> bool {
        self.due <= now && !self.host.is_stalled()
    }

    #[inline]
    pub fn wake(&mut self, now: Timestamp) {
        self.host.guest.wake(self.host.told(now));
    }

    /// Next wake-up; never while the machine is stalled: what falls due then is done when it resumes.
    pub fn next_wakeup(&self) -> Timestamp {
        if self.host.is_stalled() { Timestamp::MAX } else { self.due }
    }

    pub fn end_fault(&mut self, now: Timestamp, kind: &FaultKind) -> u64 {
        self.host.end_fault(now, kind, self.due)
    }

    /// Updates the next wake-up, in bench time.
    pub fn ask_due(&mut self) {
        self.due = self.host.when(self.host.guest.next_wakeup());
    }
}

impl Guest for Hosted {
    #[inline]
    fn hear(&mut self, now: Timestamp, port: PortId, what: &Transmit) {
        let at = if port == GYRO { Port::Gyro } else { Port::Base };
        self.receive(now, at, input(what));
    }

    fn order(&mut self, now: Timestamp, mission: Mission) {
        self.command(now, mission);
    }
}

fn input(what: &Transmit) -> Input<'_> {
    match what {
        Transmit::Bytes(packet) => Input::Bytes(packet.as_slice()),
        Transmit::Frame(frame) => Input::Frame(*frame),
    }
}

/// An output of a controller, with its port.
pub const fn output(output: Output) -> (PortId, Transmit) {
    match output {
        Output::Bytes(Port::Gyro, packet) => (GYRO, Transmit::Bytes(packet)),
        Output::Bytes(Port::Base, packet) => (BASE, Transmit::Bytes(packet)),
        Output::Frame(frame) => (BASE, Transmit::Frame(frame)),
    }
}
