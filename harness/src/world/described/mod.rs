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

mod emulated;
mod faults;
mod link;
mod stage;
mod tester;

pub(crate) use emulated::Emulated;
pub(crate) use link::End;
pub(super) use stage::DeviceStage;

use super::simulated::look_up;
use crate::engine::{Ending, Engine};
use crate::operator::{Answers, Operator};
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::record::Device;
use crate::record::FaultSummary;
use crate::record::Progress;
use crate::record::sink::RecordSink;
use described::Description;
use std::sync::Arc;
use wire::device::Transmit;
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
    stage: DeviceStage,
    fault_summaries: Vec<FaultSummary>,
    events: u64,
}

impl DescribedWorld {
    /// A run of `plan`, its random numbers from `seed`.
    pub fn new(
        plan: Arc<Plan>,
        description: &Arc<Description>,
        answers: Answers,
        seed: u64,
    ) -> Self {
        let emulated = Some(Emulated::new(description, seed));
        let operator = Operator::simulated(answers);
        Self {
            now: Timestamp::ZERO,
            stage: DeviceStage::new(plan, description, emulated, operator, seed),
            fault_summaries: Vec::new(),
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
        &self.stage.engine
    }

    /// What became of the plan's faults, once the run is over.
    pub fn faults(&self) -> &[FaultSummary] {
        &self.fault_summaries
    }

    /// What the line and the device had no room for.
    pub fn dropped(&self) -> u64 {
        self.stage.dropped()
    }

    /// Runs the plan to its end. Between two events `pulse` is called now and then; when it says false, the run is aborted.
    pub fn run(
        &mut self,
        sink: &mut impl RecordSink,
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        let ending = self.run_to_end(sink, pulse);
        self.last_words(sink);
        self.fault_summaries = self.stage.finish(self.now, sink);
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
                look_up(&mut self.stage.engine, self.now, sink, pulse);
            }
            self.step(sink);
            if let Some(ending) = self.stage.engine.ending() {
                return ending.clone();
            }
            let next = self.stage.next_due();
            if next == Timestamp::MAX {
                self.stage.engine.broke(self.now, "nothing is left that could happen");
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
        self.stage.strike(self.now, sink);
        self.deliver(sink);
        self.stage.note_confinement(self.now, sink);
        self.stage.wake(self.now, sink);
        self.transmit();
    }

    fn deliver(&mut self, sink: &mut impl RecordSink) {
        let Self { now, stage: DeviceStage { engine, tester, emulated, .. }, .. } = self;
        let (now, Some(emulated)) = (*now, emulated) else { return };
        emulated.deliver(now, &mut |from, what| {
            record(sink, now, from, what);
            if from != End::Host {
                tester.hear(what, now, engine);
            }
        });
    }

    fn transmit(&mut self) {
        let DeviceStage { tester, emulated: Some(emulated), .. } = &mut self.stage else { return };
        while let Some(sent) = tester.transmit() {
            emulated.receive(self.now, sent);
        }
        emulated.transmit(self.now);
    }

    /// What the plan sent last goes through.
    fn last_words(&mut self, sink: &mut impl RecordSink) {
        self.stage.act(self.now, sink);
        self.transmit();
        let until = self.now + LAST_WORDS;
        loop {
            let next = self.stage.emulated.as_ref().map_or(Timestamp::MAX, Emulated::next_arrival);
            if next > until {
                break;
            }
            self.now = self.now.max(next);
            self.deliver(sink);
        }
    }
}

/// Keeps what crossed the line in a full record.
pub(super) fn record(sink: &mut impl RecordSink, now: Timestamp, from: End, what: &Transmit) {
    let device = match from {
        End::Device => Device::Device,
        End::Host | End::Stranger => Device::Plan,
    };
    match what {
        Transmit::Bytes(packet) => sink.bytes(now, device, packet.as_slice()),
        Transmit::Frame(frame) => sink.frame(now, device, *frame),
    }
}
