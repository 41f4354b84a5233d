//! A node of a rig.

use super::error_frame;
use super::host::{Guest, OnHost};
use super::own::Own;
use super::replayed::Replaying;
use super::robot::Robot;
use super::supply::Supply;
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
use wire::time::{Span, Timestamp};

#[derive(Debug)]
pub struct Node {
    pub name: Arc<str>,
    pub part: Part,
    pub(super) supply: Supply,
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
    /// Emulated, as described in a file.
    Described(Box<described::Device>),
    /// Under test in this process; takes missions.
    Controller(Box<Machine>),
    /// The user's own code in this process: emulated or under test.
    Own(Own),
    /// Sends messages that the plan orders.
    Tester(Box<Tester>),
    Replayed(Replaying),
    /// The plan's own port to the table.
    Plan,
    /// At a port of this machine: somebody's process, or a real device.
    Away,
    /// At a port of this machine: a program of this run, and what has become of its supply since the run last looked.
    Process(Option<bool>),
}

impl Node {
    pub fn new(name: &str, part: Part) -> Self {
        Self { name: name.into(), part, supply: Supply::default(), routes: Vec::new() }
    }

    /// A device as described. Its random numbers come from `seed` and the name of the node.
    pub fn described(name: &str, description: &Arc<Description>, seed: u64) -> Self {
        let named = match name == DEVICE || name == description.name {
            true => Arc::clone(description),
            false => Arc::new(description.named(name)),
        };
        Self::new(name, Part::Described(Box::new(described::Device::new(named, seed))))
    }

    pub(super) fn route(&self, port: PortId) -> Option<Route> {
        self.routes.get(usize::from(port.0)).copied().flatten()
    }

    pub(super) fn join(&mut self, port: PortId, route: Route) {
        let port = usize::from(port.0);
        if self.routes.len() <= port {
            self.routes.resize(port + 1, None);
        }
        self.routes[port] = Some(route);
    }

    /// A copy in the same state, which runs on its own. `None` for user code, programs and FMUs, which cannot
    /// be copied.
    pub(super) fn copied(&self) -> Option<Self> {
        let part = match &self.part {
            Part::Robot(robot) => Part::Robot(robot.clone()),
            Part::Described(described) if described.can_be_copied() => {
                Part::Described(described.clone())
            }
            Part::Controller(machine) => Part::Controller(Box::new(machine.copied()?)),
            Part::Tester(tester) => Part::Tester(tester.clone()),
            Part::Replayed(replaying) => Part::Replayed(replaying.clone()),
            Part::Plan => Part::Plan,
            Part::Own(_) | Part::Described(_) | Part::Away | Part::Process(_) => return None,
        };
        let (name, supply) = (self.name.clone(), self.supply.clone());
        Some(Self { name, part, supply, routes: self.routes.clone() })
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
            Part::Described(described) => match what {
                Transmit::Frame(frame) => described.receive_frame(now, frame),
                Transmit::Bytes(packet) => described.receive_bytes(now, packet.as_slice()),
            },
            Part::Own(_) if self.supply.is_off() => {}
            Part::Own(own) => own.receive(now, port, what),
            Part::Tester(tester) => tester.receive(now, what),
            Part::Replayed(replaying) => replaying.receive(now, what),
            // They read the line together with all other traffic.
            Part::Plan | Part::Away | Part::Process(_) => {}
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
        let due = match &self.part {
            Part::Controller(machine) => machine.next_wakeup(),
            Part::Robot(robot) => robot.next_wakeup(),
            Part::Described(described) => described.next_wakeup(),
            Part::Own(own) => own.next_wakeup(),
            Part::Tester(tester) => tester.next_wakeup(),
            Part::Replayed(replaying) => replaying.next_wakeup(),
            Part::Plan | Part::Away | Part::Process(_) => Timestamp::MAX,
        };
        due.min(self.supply.on_at)
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

    /// Whether it is at a port of this machine.
    pub const fn is_away(&self) -> bool {
        matches!(self.part, Part::Away | Part::Process(_))
    }

    /// Whether its supply is in our hands. A log says by itself what its node did meanwhile.
    pub(super) const fn is_powered(&self) -> bool {
        matches!(
            self.part,
            Part::Described(_) | Part::Own(_) | Part::Replayed(_) | Part::Process(_)
        )
    }

    /// Cuts its supply for a time: [`back`](Self::back) ends it.
    pub(super) fn cut_for(&mut self, now: Timestamp, off: Span) {
        self.supply.on_at = now + off;
        self.switch(now, false);
    }

    /// Undoes a cut that has lasted its time; returns whether there was one.
    pub(super) fn back(&mut self, now: Timestamp) -> bool {
        let is_due = self.supply.on_at <= now;
        if is_due {
            self.supply.on_at = Timestamp::MAX;
            self.switch(now, true);
        }
        is_due
    }

    /// Cuts its supply, or undoes one cut.
    pub(super) fn switch(&mut self, now: Timestamp, on: bool) {
        if !self.supply.switch(on) {
            return;
        }
        match &mut self.part {
            Part::Described(described) => described.power(now, on),
            Part::Own(own) => own.power(now, on),
            Part::Process(wanted) => *wanted = Some(on),
            _ => {}
        }
    }

    /// Items dropped by the node or its buffers.
    pub(super) fn dropped(&self) -> u64 {
        match &self.part {
            Part::Controller(machine) => machine.host.dropped(),
            Part::Described(described) => described.dropped(),
            Part::Own(own) => own.dropped(),
            _ => 0,
        }
    }
}

/// What has become of a node.
#[derive(Debug)]
pub enum Woken {
    /// It has been switched on again.
    Back,
    /// It cannot go on; why.
    Failed(String),
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
