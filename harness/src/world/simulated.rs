//! The simulated world: virtual time, the same bytes as on real lines, one event after another.
//!
//! Time jumps to the next event. At equal times the order is: begin and end faults, deliver what has arrived, wake what is
//! due, transmit until nothing moves any more, record. Nothing here reads a clock or draws a number,
//! so plan, seed and version determine every byte of the record.
//!
//! What is delivered may first [cross](super::crossing) a pty or a CAN interface of the kernel, which time
//! does not notice.

mod deliver;

use super::bench::Bench;
use super::crossing::{Crossing, Memory};
use super::faults::{Faults, Host};
use super::lines::{BaseLink, Node};
use super::stage::Stage;
use super::watch::{Watch, see};
use crate::engine::{Action, Ending, Engine};
use crate::hosted::{Hosted, HostedController as _, Hosting};
use crate::operator::{Answers, Operator};
use crate::outcome::Outcome;
use crate::properties::{Limits, Monitor, Property, Seen};
use crate::record::sink::RecordSink;
use crate::record::{FaultSummary, Progress};
use controller::mission::Report;
use controller::{Output, Port};
use wire::time::Timestamp;

/// Rounds of transmitting at one instant; more means that two devices answer each other for ever.
const ROUNDS_MAX: u32 = 1_000;
/// Events at one instant; more means that somebody wants to be woken again and again for nothing.
const EVENTS_AT_ONCE_MAX: u32 = 10_000;

/// Who has been reached by an event and may have something to say, or want to be woken at another time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Touched {
    controller: bool,
    carrier: bool,
    engine: bool,
}

/// Looks beyond a world: does anybody want the run to stop, does the disk still take the record?
pub(super) fn look_up(
    engine: &mut Engine,
    now: Timestamp,
    sink: &mut impl RecordSink,
    pulse: &mut impl FnMut(Progress) -> bool,
) {
    let (steps_done, steps) = engine.progress();
    if !pulse(Progress { now, steps_done, steps }) {
        engine.abort(now);
    }
    if let Some(error) = sink.failed() {
        engine.broke(now, &format!("failed to write the record: {error}"));
    }
}

/// One run in virtual time.
#[derive(Debug)]
pub struct SimulatedWorld<C = Memory> {
    now: Timestamp,
    stage: Stage,
    crossing: C,
    controller: Hosted,
    watch: Option<Box<Watch>>,
    touched: Touched,
    /// What goes wrong on purpose; none where the plan has no faults.
    faults: Option<Box<Faults>>,
    fault_summaries: Vec<FaultSummary>,
    /// Wake-ups of those that are asked again only when something has reached them.
    controller_due: Timestamp,
    carrier_due: Timestamp,
    engine_due: Timestamp,
    events: u64,
    events_at_once: u32,
}

impl SimulatedWorld {
    /// A world at time zero, its lines in memory.
    pub fn new(bench: Bench, engine: Engine) -> Self {
        Self::across(Memory, bench, engine)
    }
}

impl<C: Crossing> SimulatedWorld<C> {
    /// A world at time zero in which everything on a line goes through `crossing`.
    pub fn across(crossing: C, bench: Bench, engine: Engine) -> Self {
        let now = Timestamp::ZERO;
        Self {
            now,
            controller: Hosting::default().start(&bench.controller_config()),
            stage: Stage::new(bench, engine),
            crossing,
            watch: None,
            touched: Touched { controller: true, carrier: true, engine: true },
            controller_due: now,
            carrier_due: now,
            engine_due: now,
            faults: None,
            fault_summaries: Vec::new(),
            events: 0,
            events_at_once: 0,
        }
    }

    /// Answers to what a person would be asked.
    pub fn with_answers(mut self, answers: Answers) -> Self {
        self.stage.operator = Operator::simulated(answers);
        self
    }

    /// With the controller that `hosting` starts, in the place of ours.
    pub fn with_controller(mut self, hosting: &Hosting) -> Self {
        self.controller = hosting.start(&self.stage.bench.controller_config());
        self
    }

    /// With the faults of the plan, their random numbers from `seed`.
    pub fn with_faults(mut self, seed: u64) -> Self {
        self.faults = Faults::of(&self.stage.engine.plan().faults, seed);
        self
    }

    /// What became of the plan's faults, once the run is over.
    pub fn faults(&self) -> &[FaultSummary] {
        &self.fault_summaries
    }

    /// Properties are judged as the run goes on: `properties`, or all where there is none. The record
    /// stays what it is.
    pub fn with_monitor(mut self, properties: &[Property]) -> Self {
        let limits = Limits::of(&self.stage.bench.controller_config());
        self.watch = Some(Box::new(Watch::new(Monitor::new(properties, &limits))));
        self
    }

    /// The monitor, if there is one; it watches no longer.
    pub fn take_monitor(&mut self) -> Option<Monitor> {
        self.watch.take().map(|watch| watch.into_monitor())
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

    /// What the lines between the devices have dropped for want of room.
    pub fn dropped(&self) -> u64 {
        let held_back = self.faults.as_ref().map_or(0, |faults| faults.host.dropped());
        self.stage.lines.dropped() + held_back
    }

    /// Calibrations that the engine asks to be kept are handed to `keep`. Between two events `pulse` is
    /// called now and then; when it says false, the run is aborted.
    pub fn run(
        &mut self,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        let ending = self.run_to_end(sink, keep, pulse);
        let Self { faults, stage, controller, now, .. } = self;
        if let Some(faults) = faults {
            self.fault_summaries = faults.finish(*now, stage, Some(controller), sink);
        }
        ending
    }

    fn run_to_end(
        &mut self,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        const EVENTS_PER_PULSE: u64 = 50_000;
        self.transmit(sink, keep);
        loop {
            if let Some(ending) = self.stage.engine.ending() {
                return ending.clone();
            }
            if self.events.is_multiple_of(EVENTS_PER_PULSE) {
                self.look_up(sink, pulse);
            }
            let next = self.next_event();
            if next == Timestamp::MAX {
                self.broke("nothing is left that could happen");
            } else {
                self.events_at_once = if next > self.now { 0 } else { self.events_at_once + 1 };
                self.now = self.now.max(next);
            }
            if self.events_at_once == EVENTS_AT_ONCE_MAX {
                // Nothing that takes time can happen any more, a tear-down neither.
                let reason = format!("time stands still at {} s", self.now.as_secs_f64());
                return Ending { outcome: Outcome::Error, reason: Some(reason) };
            }
            self.events += 1;
            if self.faults.is_some() {
                self.strike(sink);
            }
            if self.stage.lines.next_arrival() <= self.now {
                self.deliver(sink);
            }
            self.note_confinement(sink);
            self.wake();
            if let Some(watch) = &mut self.watch {
                watch.look_again(self.now, &self.stage.bench.carrier);
            }
            self.transmit(sink, keep);
        }
    }

    /// Looks beyond the world; who is stopped may have something to say.
    fn look_up(&mut self, sink: &mut impl RecordSink, pulse: &mut impl FnMut(Progress) -> bool) {
        if let Some(watch) = &self.watch {
            watch.tell(sink);
        }
        look_up(&mut self.stage.engine, self.now, sink, pulse);
        self.touched.engine |= self.stage.engine.is_ending();
    }

    fn broke(&mut self, why: &str) {
        self.stage.engine.broke(self.now, why);
        self.touched.engine = true;
    }

    fn next_event(&self) -> Timestamp {
        self.stage
            .lines
            .next_arrival()
            .min(self.stage.bench.gyro.next_wakeup())
            .min(self.carrier_due)
            .min(self.controller_due)
            .min(self.engine_due)
            .min(self.faults.as_ref().map_or(Timestamp::MAX, |faults| faults.next_due()))
    }

    /// Faults that are due begin and end, which may reach anybody.
    #[cold]
    fn strike(&mut self, sink: &mut impl RecordSink) {
        let Self { faults: Some(faults), now, stage, controller, watch, touched, .. } = self else {
            return;
        };
        if faults.strike(*now, stage, Some(controller), sink) {
            see(watch, *now, &Seen::Faults { active: faults.active() });
            *touched = Touched { controller: true, carrier: true, engine: true };
        }
    }

    fn wake(&mut self) {
        let now = self.now;
        if self.carrier_due <= now {
            self.stage.bench.carrier.wake(now);
            self.touched.carrier = true;
        }
        self.stage.wake_gyro(now);
        if self.controller_due <= now && !self.is_stalled() {
            let told = self.host().map_or(now, |host| host.told(now));
            self.controller.wake(told);
            self.touched.controller = true;
        }
        if self.engine_due <= now {
            self.stage.engine.wake(now);
            self.touched.engine = true;
        }
    }

    /// Carries everything that those who were reached have to say, until nobody has, and asks them when
    /// they want to be woken.
    fn transmit(&mut self, sink: &mut impl RecordSink, keep: &mut impl FnMut(&Action)) {
        let mut rounds = 0;
        while self.touched != Touched::default() {
            rounds += 1;
            if rounds == ROUNDS_MAX {
                self.stage.engine.broke(self.now, "two devices answer each other without end");
                return;
            }
            if std::mem::take(&mut self.touched.controller) {
                self.ask_controller(sink);
            }
            if std::mem::take(&mut self.touched.carrier) {
                while let Some(sent) = self.stage.bench.carrier.transmit() {
                    self.stage.carry(self.now, sent);
                }
                self.carrier_due = self.stage.bench.carrier.next_wakeup();
            }
            if std::mem::take(&mut self.touched.engine) {
                self.ask_engine(sink, keep);
            }
        }
    }

    fn ask_controller(&mut self, sink: &mut impl RecordSink) {
        if self.is_stalled() {
            // It is touched again when its machine goes on.
            self.controller_due = Timestamp::MAX;
            return;
        }
        let told = self.host().map_or(self.now, |host| host.told(self.now));
        while let Some(output) = self.controller.transmit(told) {
            if let Some(watch) = &mut self.watch {
                watch.look(self.now, &self.stage.bench.carrier);
                watch.see(self.now, &Seen::Sent(&output));
            }
            self.carry(output);
        }
        while let Some(report) = self.controller.report() {
            self.hear_report(sink, &report);
        }
        let due = self.controller.next_wakeup();
        self.controller_due = self.host().map_or(due, |host| host.when(due));
    }

    /// Apart, as reports are rare and large: their room is not made at every event.
    #[inline(never)]
    fn hear_report(&mut self, sink: &mut impl RecordSink, report: &Report) {
        if let Some(watch) = &mut self.watch {
            watch.look(self.now, &self.stage.bench.carrier);
            watch.see(self.now, &Seen::Report(report));
        }
        self.stage.record_report(self.now, sink, report);
        self.stage.engine.report(self.now, report);
        self.touched.engine = true;
    }

    /// Apart for the same reason: an action may hold a whole calibration.
    #[inline(never)]
    fn ask_engine(&mut self, sink: &mut impl RecordSink, keep: &mut impl FnMut(&Action)) {
        while let Some(action) = self.stage.engine.action() {
            // Whatever it is, it may have reached anybody.
            self.touched = Touched { controller: true, carrier: true, engine: true };
            if let Some(watch) = &mut self.watch {
                watch.look(self.now, &self.stage.bench.carrier);
                watch.see_action(self.now, &action);
            }
            if let (Action::Phase(event), Some(faults)) = (&action, &mut self.faults) {
                faults.phase(self.now, event);
                continue;
            }
            if let Some(mission) = self.stage.act(self.now, sink, keep, action) {
                match &mut self.faults {
                    None => self.controller.command(self.now, mission),
                    Some(faults) => {
                        faults.host.mission(self.now, mission, &mut self.controller);
                    }
                }
            }
        }
        self.engine_due = self.stage.engine.next_wakeup();
    }

    /// The machine of the controller, where faults can strike it.
    fn host(&self) -> Option<&Host> {
        self.faults.as_ref().map(|faults| &faults.host)
    }

    fn is_stalled(&self) -> bool {
        self.host().is_some_and(Host::is_stalled)
    }

    fn carry(&mut self, output: Output) {
        let lines = &mut self.stage.lines;
        match (output, &mut lines.base) {
            (Output::Bytes(Port::Gyro, packet), _) => lines.gyro_commands.send(self.now, packet),
            (Output::Bytes(Port::Base, packet), BaseLink::Serial { to_base, .. }) => {
                to_base.send(self.now, packet);
            }
            (Output::Frame(frame), BaseLink::Can(bus)) => {
                bus.send(self.now, Node::Controller, frame);
            }
            _ => {}
        }
    }
}
