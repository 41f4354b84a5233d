//! Reruns the devices under test on what they received in a recorded run, and compares their outputs.
//!
//! Inputs come from the record alone, whatever a device sends now, so any difference is its own. Its outputs go through
//! lines like those of the run, on which it is alone, and faults strike them there as they did in the run.

mod ends;
mod error;
mod moments;
mod pairs;
mod struck;

pub use error::RerunError;
pub use moments::Moments;
pub use pairs::{Clock, Difference};

use super::Rig;
use super::line::EndId;
use super::node::{Part, output};
use crate::engine::{FIRST_MISSION, is_of_lost};
use crate::hosted::{HostedController as _, News};
use controller::mission::{Command, Mission, MissionId};
use ends::ends_alike;
use pairs::{BUS_APART_MAX, Pairs, identifier};
use plan::faults::{Chances, Fault};
use record::reader::RecordError;
use record::{BUS_CLOSED, BUS_OPENED, Device, Record, RecordKind};
use std::collections::{BTreeMap, BTreeSet};
use wire::can::Id;
use wire::device::Transmit;
use wire::packet::{BYTES_MAX, Packet};
use wire::time::{Span, Timestamp};

/// Most wake-ups at one instant; more means that a device asks to be woken again and again.
const WAKES_AT_ONCE_MAX: u32 = 10_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Said {
    /// Packets of bytes and frames.
    pub outputs: u64,
    pub reports: u64,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rerun {
    pub recorded: Said,
    pub now: Said,
    /// `None` if all outputs are the same.
    pub difference: Option<Difference>,
    /// How a program ended early.
    pub ended: Option<String>,
    /// The note of the run on a device under test that ended early.
    pub recorded_end: Option<String>,
    /// Whether a program ended early as in the run, or none did in either.
    pub ends_alike: bool,
}

impl Rerun {
    /// Whether the devices did what they did in the run, and ended as they did there.
    pub const fn is_same(&self) -> bool {
        self.difference.is_none() && self.ends_alike
    }
}

struct Again {
    rig: Rig,
    clock: Clock,
    is_over: bool,
    /// Nodes that are run again.
    tested: Vec<usize>,
    /// Ends at which nobody hears the bus now.
    closed: BTreeSet<Device>,
    /// The schedule of the run.
    faults: Vec<(Fault, Chances)>,
    cycles: Cycles,
    /// Ends of lines on which faults hold messages up that others send, since when.
    held_up: BTreeMap<Device, Timestamp>,
    now: Timestamp,
    /// An input has reached a device since the last query.
    is_reached: bool,
    next_id: MissionId,
    /// By the end of a line that sent them, and frames by identifier, as they may swap places on a busy bus. Bytes have no
    /// identifier.
    outputs: BTreeMap<(Device, Option<Id>), Pairs>,
    reports: Pairs,
    not_started: Option<String>,
    came: Rerun,
}

/// Nodes that steps of a plan switch off, and for how long, by the titles of the steps.
pub type Cycles = BTreeMap<String, (String, Span)>;

/// Runs the devices under test in `rig` again on the inputs of `records`, from a run with these faults, and steps that switch
/// nodes off and on.
pub fn rerun(
    rig: Rig,
    Moments { clock, closed }: Moments,
    faults: Vec<(Fault, Chances)>,
    cycles: Cycles,
    records: impl IntoIterator<Item = Result<Record, RecordError>>,
) -> Result<Rerun, RerunError> {
    let is_tested =
        |place: &usize| matches!(rig.nodes[*place].part, Part::Controller(_) | Part::Own(_));
    let tested: Vec<usize> = (0..rig.nodes.len()).filter(is_tested).collect();
    if tested.is_empty() {
        return Err(RerunError::NobodyUnderTest);
    }
    let mut again = Again {
        rig,
        clock,
        is_over: false,
        tested,
        closed,
        faults,
        cycles,
        held_up: BTreeMap::new(),
        now: Timestamp::ZERO,
        is_reached: false,
        next_id: FIRST_MISSION,
        outputs: BTreeMap::new(),
        reports: Pairs::new(clock),
        not_started: None,
        came: Rerun::default(),
    };
    // At the start the devices are queried, not woken.
    again.tested.clone().into_iter().for_each(|place| again.ask(place));
    if let Some(why) = again.not_started.take() {
        return Err(RerunError::NotStarted { why });
    }
    let (mut has_bytes, mut over) = (false, Timestamp::ZERO);
    for record in records {
        let record = record?;
        match record.kind {
            RecordKind::Bytes(_) | RecordKind::Frame(_) => has_bytes = true,
            RecordKind::Note(_) | RecordKind::Fault(_) => {}
            _ => over = record.at,
        }
        again.advance(record.at)?;
        again.take(record)?;
    }
    if !has_bytes {
        return Err(RerunError::NoBytes);
    }
    // The lines still carry what was under way.
    again.advance(again.now + Span::from_nanos(1))?;
    again.settle();
    // After the end of a plan the lines still deliver, but no device is queried any more.
    for pairs in again.outputs.values_mut().chain([&mut again.reports]) {
        pairs.now.retain(|record| record.at <= over);
        // What the end of the run met on its way, behind frames of nodes that do not run again, is in no record.
        let is_late = |last: &Record| over - last.at < BUS_APART_MAX;
        while pairs.now.len() > pairs.recorded.len() && pairs.now.back().is_some_and(is_late) {
            pairs.now.pop_back();
        }
    }
    // In real time both sides may still have said something that the other had no time to say.
    again.is_over = true;
    again.compare(match clock {
        Clock::Virtual => Timestamp::MAX,
        Clock::Real => over,
    })?;
    let Rerun { recorded_end, ended, .. } = &again.came;
    again.came.ends_alike = ends_alike(clock, recorded_end.as_deref(), ended.as_deref());
    Ok(again.came)
}

impl Again {
    /// Handles everything before `until`.
    fn advance(&mut self, until: Timestamp) -> Result<(), RerunError> {
        if until <= self.now {
            return Ok(());
        }
        self.settle();
        let mut at_once = 0;
        loop {
            let wakes = self.tested.iter().map(|place| self.rig.nodes[*place].next_wakeup());
            let next = wakes.min().unwrap_or(Timestamp::MAX).min(self.rig.next_arrival());
            if next >= until {
                break;
            }
            at_once = if next > self.now { 0 } else { at_once + 1 };
            if at_once == WAKES_AT_ONCE_MAX {
                return Err(RerunError::StandsStill { at_s: self.now.as_secs_f64() });
            }
            self.now = self.now.max(next);
            self.arrive();
            self.settle();
        }
        self.compare(self.now)?;
        self.now = until;
        Ok(())
    }

    /// The outputs with which this one is compared.
    fn pairs(&mut self, said: &Record) -> &mut Pairs {
        let clock = self.clock;
        self.outputs.entry((said.device, identifier(said))).or_insert_with(|| Pairs::new(clock))
    }

    /// Counts what has arrived through the lines as sent now.
    fn arrive(&mut self) {
        for line in 0..self.rig.lines.len() {
            while let Some((from, what)) = self.rig.lines[line].arrived(self.now) {
                if from == EndId::STRANGER {
                    continue;
                }
                let kind = match what {
                    Transmit::Bytes(packet) => RecordKind::Bytes(packet.as_slice().to_vec()),
                    Transmit::Frame(frame) => RecordKind::Frame(frame),
                };
                self.came.now.outputs += 1;
                let said = Record { at: self.now, device: self.rig.lines[line].who(from), kind };
                self.pairs(&said).now.push_back(said);
            }
        }
    }

    /// Wakes the devices under test that are due, and sends their outputs.
    fn settle(&mut self) {
        for place in self.tested.clone() {
            self.is_reached |= self.rig.nodes[place].back(self.now);
            let is_due = self.rig.nodes[place].next_wakeup() <= self.now;
            match &mut self.rig.nodes[place].part {
                Part::Controller(machine) if is_due => machine.wake(self.now),
                Part::Own(own) if is_due => {
                    own.wake(self.now);
                    let ended = own.guest.ended();
                    self.came.ended = self.came.ended.take().or(ended);
                }
                _ if self.is_reached => {}
                _ => continue,
            }
            self.ask(place);
        }
        self.is_reached = false;
    }

    fn ask(&mut self, place: usize) {
        self.rig.empty(self.now, place);
        let Part::Controller(machine) = &mut self.rig.nodes[place].part else { return };
        let guest = &mut machine.host.guest;
        let mut sent = Vec::new();
        while let Some(one) = guest.transmit(self.now) {
            sent.push(output(one));
        }
        while let Some(report) = guest.report() {
            let kind = RecordKind::Report(report);
            self.came.now.reports += 1;
            self.reports.now.push_back(Record { at: self.now, device: Device::Controller, kind });
        }
        while let Some(news) = guest.news() {
            match news {
                News::Ended(how) => _ = self.came.ended.get_or_insert(how),
                News::NotStarted(why) => _ = self.not_started.get_or_insert(why),
                _ => {}
            }
        }
        machine.ask_due();
        for (port, what) in sent {
            self.rig.send(self.now, place, port, what);
        }
    }

    fn take(&mut self, record: Record) -> Result<(), RerunError> {
        match &record.kind {
            RecordKind::Bytes(bytes) => {
                let packets = bytes.chunks(BYTES_MAX).filter_map(Packet::from_slice);
                let what: Vec<_> = packets.map(Transmit::Bytes).collect();
                self.heard(record, &what, false)?;
            }
            RecordKind::Frame(frame) => {
                let what = [Transmit::Frame(*frame)];
                self.heard(record, &what, true)?;
            }
            RecordKind::Command(command) => self.order(Command::clone(command)),
            RecordKind::Report(_) => {
                self.settle();
                self.came.recorded.reports += 1;
                self.reports.recorded.push_back(record);
            }
            RecordKind::Fault(_) if record.device == Device::Controller => {
                return Err(RerunError::HostFault { at_s: record.at.as_secs_f64() });
            }
            RecordKind::Fault(fault) => self.strike(fault)?,
            RecordKind::StepBegan { title, .. } => self.cycle(title)?,
            RecordKind::Note(text) if is_of_lost(text) && record.device == Device::Plan => {
                self.came.recorded_end.get_or_insert_with(|| text.clone());
            }
            RecordKind::Note(text) if self.clock == Clock::Real => self.learn(record.device, text),
            _ => {}
        }
        Ok(())
    }

    /// A program hears a bus while it has opened it.
    fn learn(&mut self, at: Device, note: &str) {
        if note.ends_with(BUS_OPENED) {
            self.closed.remove(&at);
        } else if note.ends_with(BUS_CLOSED) {
            self.closed.insert(at);
        }
    }

    fn order(&mut self, command: Command) {
        self.settle();
        let mission = Mission { id: self.next_id, command };
        self.next_id = self.next_id.wrapping_add(1);
        for node in &mut self.rig.nodes {
            if let Part::Controller(machine) = &mut node.part {
                machine.host.command(self.now, mission.clone());
            }
        }
        self.is_reached = true;
    }

    /// Takes traffic of the record: the input of devices under test, or the output of one of them.
    fn heard(&mut self, record: Record, what: &[Transmit], is_can: bool) -> Result<(), RerunError> {
        let is_said = |line: &usize| {
            let line = &self.rig.lines[*line];
            // A fault sends from no end of the bus.
            let mut senders = line.ends().iter().map(|end| end.who);
            let is_strange = is_can && line.who(EndId::STRANGER) == record.device;
            line.is_can() == is_can && (is_strange || senders.any(|who| who == record.device))
        };
        let lines: Vec<usize> = (0..self.rig.lines.len()).filter(is_said).collect();
        let from = |line: usize| {
            let ends = self.rig.lines[line].ends();
            ends.iter().position(|end| end.who == record.device).map(EndId::of)
        };
        let is_tested = |line: usize| {
            let end = from(line).map(|end| self.rig.lines[line].ends()[end.place()].node);
            end.is_some_and(|node| self.tested.contains(&node))
        };
        if lines.iter().any(|line| is_tested(*line)) {
            self.came.recorded.outputs += 1;
            self.pairs(&record).recorded.push_back(record);
            return Ok(());
        }
        let [line] = lines[..] else {
            let who = record.device.name().to_owned();
            // A line outside the rig, such as that of an emulated table, has no device under test.
            return if lines.is_empty() { Ok(()) } else { Err(RerunError::SeveralLines { who }) };
        };
        let from = from(line).unwrap_or(EndId::STRANGER);
        let ends = self.rig.lines[line].ends().iter().enumerate();
        let mut hear: Vec<_> = ends.map(|(at, end)| (EndId::of(at), end.node, end.port)).collect();
        let is_open = |at: EndId| !self.closed.contains(&self.rig.lines[line].who(at));
        hear.retain(|(at, node, _)| *at != from && self.tested.contains(node) && is_open(*at));
        for one in what.iter().filter(|_| !hear.is_empty()) {
            self.rig.lines[line].lose(from, one);
            for (end, node, port) in &hear {
                if !self.rig.lines[line].misses(*end) {
                    self.rig.nodes[*node].receive(self.now, *port, one);
                }
            }
            self.is_reached = true;
        }
        Ok(())
    }

    /// Compares the outputs of both sides by `at`, until the first difference.
    fn compare(&mut self, at: Timestamp) -> Result<(), RerunError> {
        if self.came.difference.is_some() {
            self.outputs.clear();
            self.reports = Pairs::new(self.clock);
            return Ok(());
        }
        let (pairs, is_over) = (self.outputs.values_mut().chain([&mut self.reports]), self.is_over);
        let differences = pairs.filter_map(|pairs| pairs.difference(at, is_over));
        self.came.difference = differences.min_by_key(|one| one.sides().map(|said| said.at).min());
        let sides = self.came.difference.iter().flat_map(Difference::sides);
        let outputs =
            sides.filter(|said| matches!(said.kind, RecordKind::Frame(_) | RecordKind::Bytes(_)));
        let since =
            |said: &Record| self.held_up.get(&said.device).filter(|since| said.at >= **since);
        match outputs.filter_map(since).min() {
            Some(since) => Err(RerunError::HeldUp { at_s: since.as_secs_f64() }),
            None => Ok(()),
        }
    }
}
