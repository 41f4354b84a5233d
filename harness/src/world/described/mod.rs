//! A device of the user's own, described in a file, and the plan that talks to it: virtual time, every byte and frame on
//! its line.
//!
//! ```text
//!  engine ── Tester ──┤ DeviceLink ├── described::Device
//!            sends, reads    paced, faulty     the emulator
//! ```
//!
//! At equal times the order is that of the simulated world: begin and end faults, deliver what has arrived, wake what is
//! due, transmit until nothing moves any more, record. The live world has the same parts with ports between them.

#[cfg(feature = "live")]
mod emulated;
mod faults;
mod link;
mod tester;

#[cfg(feature = "live")]
pub(crate) use emulated::Emulated;
pub(super) use faults::LinkFaults;
pub(super) use link::{DeviceLink, End};
pub(super) use tester::Tester;

use super::simulated::Progress;
use crate::engine::{Action, Ending, Engine};
use crate::faults::FaultSummary;
use crate::operator::{Answers, Asked, Operator};
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::record::sink::{Level, RecordSink};
use crate::record::{Device, Record, RecordKind};
use described::{Description, Wired};
use std::sync::Arc;
use wire::time::{Span, Timestamp};

/// Events at one instant; more means that two ends answer each other for ever.
const EVENTS_AT_ONCE_MAX: u32 = 10_000;
/// Events between two looks beyond the world.
const EVENTS_PER_PULSE: u64 = 50_000;
/// What is sent last has so long to get through. Assumption: the longest queue of a bus is over in a tenth of it.
const LAST_WORDS: Span = Span::from_secs(1);

/// One run of a device of the user's own in virtual time.
#[derive(Debug)]
pub struct DescribedWorld {
    now: Timestamp,
    engine: Engine,
    tester: Tester,
    link: DeviceLink,
    device: described::Device,
    power: Power,
    faults: Option<LinkFaults>,
    fault_summaries: Vec<FaultSummary>,
    operator: Operator,
    events: u64,
}

/// The device's power, as far as a step is about it.
#[derive(Debug, Clone, Copy, Default)]
struct Power {
    /// It is switched on again then.
    on_at: Option<Timestamp>,
}

impl DescribedWorld {
    /// A run of `plan`, its random numbers from `seed`.
    pub fn new(
        plan: Arc<Plan>,
        description: &Arc<Description>,
        answers: Answers,
        seed: u64,
    ) -> Self {
        let faults = LinkFaults::of(&plan.faults, seed);
        Self {
            now: Timestamp::ZERO,
            engine: Engine::of_device(plan, description.layout(), Timestamp::ZERO),
            tester: Tester::new(Arc::clone(description)),
            link: DeviceLink::new(description.layout().medium()),
            device: described::Device::new(Arc::clone(description), seed),
            power: Power::default(),
            faults,
            fault_summaries: Vec::new(),
            operator: Operator::simulated(answers),
            events: 0,
        }
    }

    /// Bench time.
    pub const fn now(&self) -> Timestamp {
        self.now
    }

    /// Events handled.
    pub const fn events(&self) -> u64 {
        self.events
    }

    /// The engine, for what it observed.
    pub const fn engine(&self) -> &Engine {
        &self.engine
    }

    /// What became of the plan's faults, once the run is over.
    pub fn faults(&self) -> &[FaultSummary] {
        &self.fault_summaries
    }

    /// What the line and the device had no room for.
    pub fn dropped(&self) -> u64 {
        self.link.dropped() + self.device.dropped()
    }

    /// Runs the plan to its end. Between two events `pulse` is called now and then; when it says false, the run is aborted.
    pub fn run(
        &mut self,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        let ending = self.run_to_end(sink, pulse);
        self.last_words(sink);
        if self.tester.damaged() > 0 {
            let note = format!("{} times what came could not be read", self.tester.damaged());
            self.note(sink, note);
        }
        let Self { faults, link, now, .. } = self;
        if let Some(faults) = faults {
            self.fault_summaries = faults.finish(*now, link, sink);
        }
        ending
    }

    fn run_to_end(
        &mut self,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        let mut events_at_once = 0;
        loop {
            if self.events.is_multiple_of(EVENTS_PER_PULSE) {
                self.look_up(sink, pulse);
            }
            self.step(sink);
            if let Some(ending) = self.engine.ending() {
                return ending.clone();
            }
            let next = self.next_event();
            if next == Timestamp::MAX {
                self.engine.broke(self.now, "nothing is left that could happen");
                continue;
            }
            events_at_once = if next > self.now { 0 } else { events_at_once + 1 };
            if events_at_once == EVENTS_AT_ONCE_MAX {
                let reason = format!("time stands still at {} s", self.now.as_secs_f64());
                return Ending { outcome: Outcome::Error, reason: Some(reason) };
            }
            self.now = self.now.max(next);
        }
    }

    /// All that is to be done at this instant.
    fn step(&mut self, sink: &mut impl RecordSink) {
        self.events += 1;
        let now = self.now;
        if let Some(faults) = &mut self.faults {
            faults.strike(now, &mut self.link, sink);
        }
        self.deliver(sink);
        if let Some(faults) = &self.faults {
            faults.record_confinement(now, &mut self.link, sink);
        }
        if self.power.on_at.is_some_and(|at| at <= now) {
            self.power.on_at = None;
            self.device.power(now, true);
            self.engine.answered(now);
        }
        if self.device.next_wakeup() <= now {
            self.device.wake(now);
        }
        if let Err(why) = self.tester.wake(now) {
            self.engine.broke(now, &why);
        }
        if self.engine.next_wakeup() <= now {
            self.engine.wake(now);
        }
        while let Some(action) = self.engine.action() {
            self.act(sink, action);
        }
        self.transmit();
    }

    fn transmit(&mut self) {
        while let Some(sent) = self.tester.transmit() {
            self.link.send(self.now, End::Host, sent);
        }
        while let Some(sent) = self.device.transmit() {
            self.link.send(self.now, End::Device, sent);
        }
    }

    fn next_event(&self) -> Timestamp {
        let faults = self.faults.as_ref().map_or(Timestamp::MAX, LinkFaults::next_due);
        self.link
            .next_arrival()
            .min(self.device.next_wakeup())
            .min(self.tester.next_wakeup())
            .min(self.engine.next_wakeup())
            .min(self.power.on_at.unwrap_or(Timestamp::MAX))
            .min(faults)
    }

    fn deliver(&mut self, sink: &mut impl RecordSink) {
        let Self { now, link, device, tester, engine, .. } = self;
        let now = *now;
        while let Some((from, what)) = link.arrived(now) {
            record(sink, now, from, &what);
            if from != End::Device {
                match &what {
                    Wired::Frame(frame) => device.receive_frame(now, frame),
                    Wired::Bytes(packet) => device.receive_bytes(now, packet.as_slice()),
                }
            }
            if from != End::Host {
                tester.hear(&what, &mut |decoded| {
                    engine.message(now, decoded.message, &decoded.values);
                });
            }
        }
    }

    fn act(&mut self, sink: &mut impl RecordSink, action: Action) {
        let now = self.now;
        match action {
            Action::Send(send) => {
                if let Err(why) = self.tester.send(now, &send) {
                    self.engine.broke(now, &why);
                }
            }
            Action::StopSending(message) => self.tester.stop(&message),
            Action::SetParameter { parameter, value, .. } => {
                if self.device.set_parameter(now, &parameter, value) {
                    self.engine.answered(now);
                } else {
                    self.engine.broke(now, &format!("the device takes no {parameter} = {value}"));
                }
            }
            Action::PowerCycle { off, .. } => {
                self.device.power(now, false);
                self.power.on_at = Some(now + off);
            }
            Action::Prompt { text, answer } => {
                let asked = self.operator.ask(&text, answer.as_ref());
                answered(&mut self.engine, now, asked, sink);
            }
            Action::Phase(event) => {
                if let Some(faults) = &mut self.faults {
                    faults.phase(now, &event);
                }
            }
            Action::Record(device, kind) => sink.record(Record { at: now, device, kind }),
            other => {
                self.engine.broke(now, &format!("no device of one's own does this: {other:?}"))
            }
        }
    }

    /// What the plan sent last goes through.
    fn last_words(&mut self, sink: &mut impl RecordSink) {
        while let Some(action) = self.engine.action() {
            self.act(sink, action);
        }
        self.transmit();
        let until = self.now + LAST_WORDS;
        while self.link.next_arrival() <= until {
            self.now = self.now.max(self.link.next_arrival());
            self.deliver(sink);
        }
    }

    /// Looks beyond the world: does anybody want the run to stop, does the disk still take the record?
    fn look_up(&mut self, sink: &mut impl RecordSink, pulse: &mut impl FnMut(Progress) -> bool) {
        let (steps_done, steps) = self.engine.progress();
        if !pulse(Progress { now: self.now, steps_done, steps }) {
            self.engine.abort(self.now);
        }
        if let Some(error) = sink.failed() {
            self.engine.broke(self.now, &format!("failed to write the record: {error}"));
        }
    }

    fn note(&self, sink: &mut impl RecordSink, note: String) {
        let kind = RecordKind::Note(note);
        sink.record(Record { at: self.now, device: Device::Plan, kind });
    }
}

/// Keeps what crossed the line in a full record.
pub(super) fn record(sink: &mut impl RecordSink, now: Timestamp, from: End, what: &Wired) {
    let device = match from {
        End::Device => Device::Device,
        End::Host | End::Stranger => Device::Plan,
    };
    match what {
        Wired::Bytes(packet) => sink.bytes(now, device, packet.as_slice()),
        Wired::Frame(frame) if sink.level() == Level::Full => {
            sink.record(Record { at: now, device, kind: RecordKind::Frame((*frame).into()) });
        }
        Wired::Frame(_) => {}
    }
}

/// Hands on what came of a question to a person.
pub(super) fn answered(
    engine: &mut Engine,
    now: Timestamp,
    asked: Asked,
    sink: &mut impl RecordSink,
) {
    match asked {
        Asked::Waiting => {}
        Asked::Assumed => engine.answered(now),
        Asked::Nobody(why) => engine.broke(now, &why),
        Asked::Replied(reply) => {
            let value = reply.number.as_ref().map(|number| number.value);
            let kind = RecordKind::Reply(Box::new(reply));
            sink.record(Record { at: now, device: Device::Plan, kind });
            match value {
                Some(value) => engine.answered_with(now, value),
                None => engine.answered(now),
            }
        }
    }
}
