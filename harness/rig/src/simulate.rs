//! The loop in virtual time: the same bytes as on real lines, one event after another.
//!
//! Time jumps to the next event. Nothing here reads a clock or draws an unseeded number, so plan, seed and version
//! determine every byte of the record. Delivered data may first [cross](crate::crossing) a pty or a CAN interface of
//! the kernel, which virtual time does not notice.

mod snapshot;
mod stream;

use super::Rig;
use super::director::Director;
use super::faults::Faults;
use super::line::Line;
use super::node::{Node, Part};
use super::touched::Touched;
use crate::crossing::MaybeCrossing;
use crate::ended::Ended;
use crate::engine::{Ending, Engine};
use crate::watch::{Watch, see};
use crate::{Keep, Pulse, Sink};
use judge::properties::{Monitor, Seen};
use plan::PhaseEvent;
use record::outcome::Outcome;
use record::{Device, Progress, Record, RecordKind};
use stream::Stream;
use wire::time::{Span, Timestamp};

/// Most rounds of transmission at one instant; more means that two devices answer each other endlessly.
const ROUNDS_MAX: u32 = 1_000;
/// Most events at one instant; more means that a device asks to be woken again and again.
const EVENTS_AT_ONCE_MAX: u32 = 10_000;
/// Events between two checks outside the loop.
const EVENTS_PER_PULSE: u64 = 50_000;
/// Time for the last messages to arrive. Assumption: the longest queue of a bus is empty in a tenth of it.
const LAST_WORDS: Span = Span::from_secs(1);

/// Checks for a stop request, and whether the disk still takes the record.
pub fn look_up(engine: &mut Engine, now: Timestamp, sink: Sink<'_>, pulse: Pulse<'_>) {
    let (steps_done, steps) = engine.progress();
    if !pulse(Progress { now, steps_done, steps }) {
        engine.abort(now);
    }
    if let Some(error) = sink.failed() {
        engine.broke(now, &format!("failed to write the record: {error}"));
    }
}

pub struct Simulation {
    pub(super) now: Timestamp,
    pub(super) rig: Rig,
    pub director: Director,
    pub(super) crossing: MaybeCrossing,
    pub(super) watch: Option<Box<Watch>>,
    pub(super) touched: Touched,
    /// The emulated nodes and the others, one bit each.
    pub(super) emulated: u64,
    pub(super) others: u64,
    /// The nodes that play a log on lines that carry it as it is.
    replayed: u64,
    /// Faults of the plan; `None` if it schedules no faults.
    pub(super) faults: Option<Box<Faults>>,
    /// Next wake-up of the plan.
    pub(super) plan_due: Timestamp,
    pub(super) events: u64,
    pub(super) events_at_once: u32,
    /// See [`Rig::wake_gyros_late`].
    pub(super) gyros_are_late: bool,
    /// The gyro stream that may bypass the loop, once the run has begun.
    stream: Option<Stream>,
    /// See [`Self::before_faults`].
    pub(super) phases: Option<Vec<(Timestamp, PhaseEvent)>>,
}

impl Simulation {
    /// A run at time zero; the plan's faults draw from `seed`.
    pub fn new(crossing: MaybeCrossing, mut rig: Rig, director: Director, seed: u64) -> Self {
        let faults = Faults::of(&director.engine.plan().faults, seed, &mut rig);
        let now = Timestamp::ZERO;
        let bits = rig.nodes.iter().enumerate();
        let emulated = bits.filter(|(_, node)| node.is_emulated()).map(|(place, _)| 1_u64 << place);
        let emulated: u64 = emulated.sum();
        let others = ((1 << rig.nodes.len()) - 1) & !emulated;
        let plays = |node: &Node| matches!(node.part, Part::Replayed(_));
        let of_log = rig.lines.iter().any(Line::is_direct);
        let nodes = rig.nodes.iter().enumerate();
        let replayed = nodes.filter(|(_, node)| of_log && plays(node));
        let replayed = replayed.map(|(place, _)| 1_u64 << place).sum();
        Self {
            now,
            emulated,
            others,
            replayed,
            rig,
            director,
            crossing,
            watch: None,
            touched: Touched::ALL,
            faults,
            plan_due: now,
            events: 0,
            events_at_once: 0,
            gyros_are_late: false,
            stream: None,
            phases: None,
        }
    }

    /// Adds a monitor that judges properties during the run. The record stays the same.
    pub fn with_monitor(mut self, monitor: Option<Monitor>) -> Self {
        self.watch = monitor.map(|monitor| Box::new(Watch::new(monitor)));
        self
    }

    /// Runs the plan to its end. `keep` receives what the engine asks to keep. `pulse` is called between events now and
    /// then; if it returns `false`, the run is aborted.
    pub fn run(&mut self, sink: Sink<'_>, keep: Keep<'_>, pulse: Pulse<'_>) -> Ended {
        self.begin(sink, keep);
        self.go_on(sink, keep, pulse)
    }

    /// Lets everybody say what they say at first.
    pub(super) fn begin(&mut self, sink: Sink<'_>, keep: Keep<'_>) {
        self.transmit(sink, keep);
        // Properties are shown the truth at every event, those of the gyro included.
        self.gyros_are_late =
            self.faults.is_none() && self.watch.is_none() && self.phases.is_none();
        if self.gyros_are_late {
            self.rig.wake_gyros_late();
        }
        self.stream = Stream::of(&self.rig);
    }

    /// Runs the plan from where it stands to its end, as [`run`](Self::run) does from its beginning.
    pub fn go_on(&mut self, sink: Sink<'_>, keep: Keep<'_>, pulse: Pulse<'_>) -> Ended {
        let ending = self.run_to_end(sink, keep, pulse);
        let end = self.now;
        // Properties are judged up to here: what is still under way arrives at nodes that no longer run.
        let watch = self.watch.take();
        self.last_words(sink, keep);
        let Self { faults, rig, director, now, .. } = self;
        let notes = [rig.remarks(), rig.stop()].concat();
        for note in &notes {
            let kind = RecordKind::Note(note.clone());
            sink.record(Record { at: *now, device: Device::Plan, kind });
        }
        if let Some(unnoted) = director.talk.unnoted() {
            let kind = RecordKind::Note(unnoted);
            sink.record(Record { at: *now, device: Device::Controller, kind });
        }
        let faults = match faults {
            Some(faults) => faults.finish(*now, (rig, director, None), sink),
            None => Vec::new(),
        };
        let known = end.min(director.engine.known_until);
        let verdicts = |watch: Box<Watch>| watch.into_monitor().verdicts(known);
        Ended {
            end,
            events: self.events,
            observations: director.engine.take_observations(),
            dropped: rig.dropped(),
            commands: std::mem::take(&mut director.commands),
            faults,
            properties: watch.map(verdicts).unwrap_or_default(),
            notes,
            announced: director.engine.has_announced(),
            ..Ended::at_once(ending)
        }
    }

    fn run_to_end(&mut self, sink: Sink<'_>, keep: Keep<'_>, pulse: Pulse<'_>) -> Ending {
        loop {
            if let Some(ending) = self.director.engine.ending() {
                return ending.clone();
            }
            if self.events.is_multiple_of(EVENTS_PER_PULSE) {
                self.look_up(sink, pulse);
            }
            let Some(mut next) = self.next_beside_stream(Timestamp::MAX, sink, keep) else {
                continue;
            };
            if next == Timestamp::MAX {
                self.broke("nothing is left that could happen");
                next = self.now;
            }
            if let Some(ending) = self.step(next, sink, keep) {
                return ending;
            }
        }
    }

    /// Handles `next`, the next event; returns the end if time stands still.
    pub(super) fn step(
        &mut self,
        next: Timestamp,
        sink: Sink<'_>,
        keep: Keep<'_>,
    ) -> Option<Ending> {
        self.begin_event(next);
        if self.events_at_once == EVENTS_AT_ONCE_MAX {
            // No event that takes time can happen any more, not even a tear-down.
            let reason = format!("time stands still at {} s", self.now.as_secs_f64());
            return Some(Ending { outcome: Outcome::Error, reason: Some(reason), lost: false });
        }
        self.events += 1;
        if self.gyros_are_late {
            self.rig.wake_gyros_before(self.now);
        }
        if self.faults.is_some() {
            self.strike(sink);
        }
        // A log says when its entries had arrived: before what the plan does at that moment.
        for place in Touched(self.replayed).places() {
            self.rig.empty(self.now, place);
        }
        self.deliver(sink);
        if self.faults.is_some() {
            self.note_confinement(sink);
        }
        self.wake();
        self.look_again();
        self.transmit(sink, keep);
        None
    }

    /// Shows the truth to the properties, if it was not shown for long.
    #[inline]
    pub(super) fn look_again(&mut self) {
        if let (Some(watch), Some(robot)) = (&mut self.watch, self.rig.robot()) {
            watch.look_again(self.now, &robot.bench);
        }
    }

    #[inline]
    pub(super) fn begin_event(&mut self, next: Timestamp) {
        self.events_at_once = if next > self.now { 0 } else { self.events_at_once + 1 };
        self.now = self.now.max(next);
    }

    /// Checks outside the loop; a stopped engine may have actions.
    fn look_up(&mut self, sink: Sink<'_>, pulse: Pulse<'_>) {
        if let Some(watch) = &self.watch {
            watch.tell(sink);
        }
        look_up(&mut self.director.engine, self.now, sink, pulse);
        if self.director.engine.is_ending() {
            self.touched.0 |= Touched::PLAN;
        }
    }

    pub(super) fn broke(&mut self, why: &str) {
        self.director.engine.broke(self.now, why);
        self.touched.0 |= Touched::PLAN;
    }

    /// The next event, after those of a gyro's stream that nothing else interrupts before `until`. `None` if one of them
    /// had an effect, which may have ended the run.
    fn next_beside_stream(
        &mut self,
        until: Timestamp,
        sink: Sink<'_>,
        keep: Keep<'_>,
    ) -> Option<Timestamp> {
        match self.stream {
            Some(stream) => self.stream_alone(stream, until, sink, keep),
            None => Some(self.next_event()),
        }
    }

    pub(super) fn next_event(&self) -> Timestamp {
        self.rig
            .next_arrival()
            .min(self.rig.next_wakeup())
            .min(self.plan_due)
            .min(self.next_fault())
    }

    /// When the next fault begins or ends.
    #[inline]
    fn next_fault(&self) -> Timestamp {
        self.faults.as_ref().map_or(Timestamp::MAX, |faults| faults.next_due())
    }

    /// Begins and ends the faults that are due, which may reach any node.
    #[cold]
    fn strike(&mut self, sink: Sink<'_>) {
        let Self { faults: Some(faults), now, rig, director, watch, touched, .. } = self else {
            return;
        };
        if faults.strike(*now, (rig, director, None), sink) {
            see(watch, *now, &faults.seen());
            *touched = Touched::ALL;
        }
    }

    /// Records nodes that have gone bus-off or recovered through faults.
    fn note_confinement(&mut self, sink: Sink<'_>) {
        let Self { faults: Some(faults), now, rig, watch, touched, .. } = self else { return };
        if faults.record_confinement(*now, rig, sink, |node| touched.node(node)) {
            see(watch, *now, &Seen::BusOff);
        }
    }

    pub(super) fn wake(&mut self) {
        let Self { now, rig, director, touched, .. } = self;
        let now = *now;
        let engine = &mut director.engine;
        let mut was_told = false;
        let told = |woken| {
            engine.woken(now, woken);
            was_told = true;
        };
        rig.wake_emulated(now, |place| touched.node(place), told);
        // What the plan was told may have ended its wait: its next wake-up is another one.
        if was_told {
            touched.0 |= Touched::PLAN;
        }
        if rig.wake_others(now, &mut director.engine, |place| touched.node(place)) {
            touched.0 |= Touched::PLAN;
        }
        let was_reached = self.touched.0 & Touched::PLAN != 0;
        if self.plan_due <= now || (was_reached && director.engine.next_wakeup() <= now) {
            director.engine.wake(now);
            self.touched.0 |= Touched::PLAN;
            if !self.director.engine.is_heard() {
                self.wait_for_state();
            }
        }
    }

    /// Carries the outputs of all touched nodes until there are no more: devices under test and testers first, then the
    /// orders of the plan, then the emulated devices.
    pub(super) fn transmit(&mut self, sink: Sink<'_>, keep: Keep<'_>) {
        let mut rounds = 0;
        let anybody = Touched::PLAN | self.emulated | self.others;
        while self.touched.0 & anybody != 0 {
            rounds += 1;
            if rounds == ROUNDS_MAX {
                self.director.engine.broke(self.now, "two devices answer each other without end");
                return;
            }
            for place in self.touched.take(self.others).places() {
                match self.rig.nodes[place].part {
                    Part::Controller(_) => self.ask_controller(place, sink),
                    _ => self.rig.empty(self.now, place),
                }
            }
            if self.touched.take(Touched::PLAN) != Touched::default() {
                self.ask_engine(sink, keep);
            }
            for place in self.touched.take(self.emulated).places() {
                self.rig.empty(self.now, place);
            }
        }
        self.touched = Touched::default();
    }

    /// Delivers the plan's last messages, if it has a tester.
    fn last_words(&mut self, sink: Sink<'_>, keep: Keep<'_>) {
        if !self.rig.nodes.iter().any(|node| matches!(node.part, Part::Tester(_))) {
            return;
        }
        self.touched.0 |= Touched::PLAN;
        self.transmit(sink, keep);
        let until = self.now + LAST_WORDS;
        loop {
            let next = self.rig.next_arrival();
            if next > until {
                return;
            }
            self.now = self.now.max(next);
            self.deliver(sink);
        }
    }
}
