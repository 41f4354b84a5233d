//! Applies the scheduled faults to the lines, devices, machine of the controller and operator of a rig, records what
//! happens to them, and sums it up at the end of a run.

use super::Rig;
use super::director::Director;
use super::injector::{Change, Injector};
use super::line::EndId;
use super::node::{Machine, Node};
use crate::Sink;
use crate::bench::Carrier;
use crate::link::{ErrorState, Struck};
use emulators::base::BaseFault;
use emulators::gyro::GyroFault;
use judge::properties::Seen;
use plan::PhaseEvent;
use plan::faults::{Chances, FaultKind, Schedule, Target, Toward};
use record::{Device, FaultEvent, FaultRecord, FaultSummary, Record, RecordKind};
use wire::time::{Span, Timestamp};
use wire::units::Angle;

/// Targets of faults: a rig, the answers of a person, and the machine of a controller that runs in this process but is
/// not part of the rig.
type Reached<'a> = (&'a mut Rig, &'a mut Director, Option<&'a mut Machine>);

#[derive(Debug, Clone)]
pub struct Faults {
    injector: Injector,
}

impl Faults {
    /// The faults of `schedule` in the run with `seed`, which begins at zero; `None` if the schedule is empty. From now
    /// on faults can strike the machines of devices under test.
    pub fn of(schedule: &Schedule, seed: u64, rig: &mut Rig) -> Option<Box<Self>> {
        if schedule.is_empty() {
            return None;
        }
        rig.nodes.iter_mut().for_each(Node::with_faults);
        Some(Box::new(Self { injector: Injector::new(schedule, seed, Timestamp::ZERO) }))
    }

    pub const fn next_due(&self) -> Timestamp {
        self.injector.next_due()
    }

    pub fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.injector.phase(now, event);
    }

    /// State of the faults for a monitor.
    pub fn seen(&self) -> Seen<'static> {
        Seen::Faults(self.injector.active())
    }

    /// Begins and ends the faults that are due; returns whether any did.
    pub fn strike(&mut self, now: Timestamp, struck: Reached<'_>, sink: Sink<'_>) -> bool {
        let (rig, director, mut here) = struck;
        let mut any = false;
        while let Some(change) = self.injector.change(now) {
            any = true;
            match change {
                Change::Begins(index) => {
                    self.tell(now, sink, index, FaultEvent::Began);
                    self.begin(now, index, (rig, director, here.as_deref_mut()));
                }
                Change::Ends(index) => {
                    self.over(now, index, (rig, director, here.as_deref_mut()), sink);
                }
            }
        }
        any
    }

    /// Records changed error states of bus nodes, and tells those under test; returns whether a node went bus-off.
    pub fn record_confinement(
        &self,
        now: Timestamp,
        rig: &mut Rig,
        sink: Sink<'_>,
        mut reached: impl FnMut(usize),
    ) -> bool {
        let mut has_left = false;
        let Rig { lines, nodes, .. } = rig;
        for line in lines {
            while let Some((fault, change)) = line.state_change() {
                has_left |= change.state == ErrorState::Off;
                let event = FaultEvent::Confinement {
                    node: line.name(change.node).to_owned(),
                    state: change.state.name().to_owned(),
                    tec: change.counters.tec,
                    rec: change.counters.rec,
                };
                self.tell(now, sink, fault, event);
                if let Some(end) = line.ends().get(change.node.place()) {
                    nodes[end.node].confined(now, end.port, &change);
                    reached(end.node);
                }
            }
        }
        has_left
    }

    /// Ends the run: switches active faults off and lists those that never began.
    pub fn finish(
        &mut self,
        now: Timestamp,
        (rig, director, mut here): Reached<'_>,
        sink: Sink<'_>,
    ) -> Vec<FaultSummary> {
        for index in self.injector.still_on() {
            self.over(now, index, (rig, director, here.as_deref_mut()), sink);
        }
        for (index, why) in self.injector.never_begun() {
            self.tell(now, sink, index, FaultEvent::NeverHappened { why: why.to_owned() });
        }
        self.injector.summaries()
    }

    fn over(&mut self, now: Timestamp, index: usize, struck: Reached<'_>, sink: Sink<'_>) {
        let acted = self.end(now, index, struck);
        self.injector.acted(index, acted);
        self.tell(now, sink, index, FaultEvent::Ended { acted });
    }

    fn tell(&self, at: Timestamp, sink: Sink<'_>, index: usize, event: FaultEvent) {
        let fault = self.injector.fault(index);
        let record = FaultRecord { index: index as u32, name: fault.to_string(), event };
        let kind = RecordKind::Fault(Box::new(record));
        sink.record(Record { at, device: Device::from(fault.target), kind });
    }

    /// Switches a fault on. An instantaneous fault is done at once.
    fn begin(&mut self, now: Timestamp, index: usize, (rig, director, here): Reached<'_>) {
        let fault = self.injector.fault(index).clone();
        let kind = fault.what;
        match kind {
            FaultKind::SchedulerStall { .. } | FaultKind::ClockStep { .. } => {
                rig.nodes.iter_mut().for_each(|node| node.begin_fault(&kind));
                here.into_iter().for_each(|machine| machine.host.begin_fault(&kind));
            }
            FaultKind::WrongUnit { .. } | FaultKind::WrongSign { .. } => {
                let chance = self.injector.chances(index).of("answer");
                director.slips.switch_on(index, kind, chance);
            }
            _ => {
                let struck = (fault.target, fault.toward, &kind);
                match rig.begin_fault(now, index, struck, self.injector.chances(index)) {
                    0 => {}
                    acted => self.injector.acted(index, acted),
                }
            }
        }
    }

    /// Switches a fault off; returns how often it acted.
    fn end(&mut self, now: Timestamp, index: usize, (rig, director, here): Reached<'_>) -> u64 {
        let fault = self.injector.fault(index).clone();
        let kind = fault.what;
        match kind {
            FaultKind::SchedulerStall { .. } | FaultKind::ClockStep { .. } => {
                let here = here.map_or(0, |machine| machine.end_fault(now, &kind));
                rig.nodes.iter_mut().map(|node| node.end_fault(now, &kind)).sum::<u64>() + here
            }
            FaultKind::WrongUnit { .. } | FaultKind::WrongSign { .. } => {
                director.slips.switch_off(index).map_or(0, |(acted, _)| acted)
            }
            _ => rig.end_fault(now, index, (fault.target, &kind)),
        }
    }
}

impl Rig {
    /// Switches on a fault of a line or of an emulated device, under its number. Returns how often an instantaneous
    /// fault acted.
    pub fn begin_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        (target, toward, kind): (Target, Toward, &FaultKind),
        chances: &Chances,
    ) -> u64 {
        if let Some(part) = target.part() {
            for (line, end, struck) in self.said(target.node(), part) {
                let line = &mut self.lines[line];
                match kind.info().reach.is_line() {
                    true => {
                        let only = struck.layout.messages()[struck.message].can_id();
                        line.begin_fault(now, (number, kind), (end, Toward::Host, only), chances);
                    }
                    false => line.tamper((number, kind, chances.of("to host")), end, struck),
                }
            }
            return 0;
        }
        if kind.info().reach.is_line() {
            for (line, end) in self.lines_of(target) {
                self.lines[line].begin_fault(now, (number, kind), (end, toward, None), chances);
            }
            return 0;
        }
        if let Some(node) = self.powered(target, kind) {
            node.switch(now, false);
            return 0;
        }
        let stream = || chances.of("device").into_stream();
        let Some(robot) = self.robots_mut().find(|robot| robot.has(target)) else { return 0 };
        if let Some(of_gyro) = gyro_fault(kind) {
            robot.bench.gyro.begin_fault(number, of_gyro, stream());
            return 0;
        }
        match (*kind, &mut robot.bench.carrier) {
            (FaultKind::EncoderJump { angle_deg }, Carrier::Base(base)) => {
                base.jump_encoder(now, Angle::from_deg(angle_deg));
                1
            }
            (FaultKind::LostSteps { steps }, Carrier::Table(table)) => {
                table.lose_steps(now, steps);
                1
            }
            (_, Carrier::Base(base)) => {
                if let Some(of_base) = base_fault(kind) {
                    base.begin_fault(now, number, of_base, stream());
                }
                0
            }
            (_, Carrier::Table(_) | Carrier::Turning(_)) => 0,
        }
    }

    /// Switches a fault off; returns how often it acted.
    pub fn end_fault(
        &mut self,
        now: Timestamp,
        number: usize,
        (target, kind): (Target, &FaultKind),
    ) -> u64 {
        if kind.info().reach.is_line() || target.part().is_some() {
            let lines = self.lines_of(target);
            return lines.iter().map(|(line, _)| self.lines[*line].end_fault(now, number)).sum();
        }
        if let Some(node) = self.powered(target, kind) {
            node.switch(now, true);
            return 1;
        }
        let Some(robot) = self.robots_mut().find(|robot| robot.has(target)) else { return 0 };
        if gyro_fault(kind).is_some() {
            return robot.bench.gyro.end_fault(number);
        }
        match &mut robot.bench.carrier {
            Carrier::Base(base) => base.end_fault(now, number),
            Carrier::Table(_) | Carrier::Turning(_) => 0,
        }
    }

    /// A message of a node, or one of its signals, and each end of a line where the node sends it.
    pub fn said(&self, node: &str, part: &str) -> Vec<(usize, EndId, Struck)> {
        let said = self.ears.iter().filter_map(|ear| {
            let (layout, sender) = (ear.decoder.layout(), ear.decoder.sender()?);
            if self.lines[ear.line].name(ear.end) != node {
                return None;
            }
            let (message, signal) = match layout.find(part) {
                Some(message) => (message, None),
                None => {
                    let found = layout.sent_signal(sender, part);
                    found.map(|(message, signal)| (message, Some(signal)))?
                }
            };
            let is_its = layout.messages()[message].sender == sender;
            let struck = Struck { layout: layout.clone(), sender, message, signal };
            is_its.then_some((ear.line, ear.end, struck))
        });
        let mut all: Vec<(usize, EndId, Struck)> = Vec::new();
        for one in said {
            // A node may have several layouts on one line.
            if all.iter().all(|(line, ..)| *line != one.0) {
                all.push(one);
            }
        }
        all
    }

    /// The node whose supply this fault cuts.
    fn powered(&mut self, target: Target, kind: &FaultKind) -> Option<&mut Node> {
        let place = self.find(target.node()).filter(|_| kind.cuts_supply_of(target))?;
        self.nodes.get_mut(place).filter(|node| node.is_powered())
    }

    /// The lines that a fault of this target strikes, each with the target's end.
    pub(crate) fn lines_of(&self, target: Target) -> Vec<(usize, EndId)> {
        let name = target.node();
        let of_name = |line: usize| {
            let ends = self.lines[line].ends();
            let at = ends.iter().position(|end| &*end.name == name).map(EndId::of);
            // If the target is a line, the fault strikes everything that crosses it, whatever the end.
            let all = (*self.line_names[line] == *name).then_some(EndId::STRANGER);
            at.or(all).map(|end| (line, end))
        };
        (0..self.lines.len()).filter_map(of_name).collect()
    }
}

fn gyro_fault(kind: &FaultKind) -> Option<GyroFault> {
    Some(match *kind {
        FaultKind::Stuck { .. } => GyroFault::Stuck,
        FaultKind::OverRange { lost_percent } => {
            GyroFault::OverRange { lost: lost_percent / 100.0 }
        }
        FaultKind::BiasStep { deg_per_h } => {
            GyroFault::BiasStep { by: (deg_per_h / 3_600.0).to_radians() }
        }
        FaultKind::NoiseBurst { rms_deg_per_s } => {
            GyroFault::Noise { rms: rms_deg_per_s.to_radians() }
        }
        FaultKind::TemperatureFrozen { .. } => GyroFault::TemperatureFrozen,
        FaultKind::TemperatureWild { rms_kelvin } => GyroFault::TemperatureWild { rms_kelvin },
        FaultKind::Restart { .. } => GyroFault::Off,
        _ => return None,
    })
}

fn base_fault(kind: &FaultKind) -> Option<BaseFault> {
    Some(match *kind {
        FaultKind::RefuseCommands { .. } => BaseFault::RefuseCommands,
        FaultKind::StuckOdometry { .. } => BaseFault::StuckOdometry,
        FaultKind::WheelSlip { slip_percent } => {
            BaseFault::WheelSlip { lost: slip_percent / 100.0 }
        }
        FaultKind::LateStop { late_s } => BaseFault::LateStop { by: Span::from_secs_f64(late_s) },
        FaultKind::EmergencyStop { .. } => BaseFault::EmergencyStop,
        _ => return None,
    })
}
