//! The simulated world: virtual time, the same bytes as on real lines, one event after another.
//!
//! Time jumps to the next event. At equal times the order is: deliver what has arrived, wake what is
//! due, transmit until nothing moves any more, record. Nothing here reads a clock or draws a number,
//! so plan, seed and version determine every byte of the record.

use super::bench::{Bench, Carrier, Sent};
use super::lines::{BaseLink, Lines, Node};
use crate::engine::{Action, Ending, Engine};
use crate::outcome::Outcome;
use crate::record::sink::{Level, RecordSink};
use crate::record::{Device, Record, RecordKind};
use controller::mission::{Activity, Report};
use controller::{Controller, Input, Output, Port};
use std::collections::BTreeMap;
use wire::can::CanFrame;
use wire::table::AnswerDecoder;
use wire::time::{Span, Timestamp};

/// Rounds of transmitting at one instant; more means that two devices answer each other for ever.
const ROUNDS_MAX: u32 = 1_000;
/// Events at one instant; more means that somebody wants to be woken again and again for nothing.
const EVENTS_AT_ONCE_MAX: u32 = 10_000;
/// Without the full record, states are kept this far apart in motion and at rest.
const STATE_PERIOD_MOVING: Span = Span::from_millis(200);
/// See [`STATE_PERIOD_MOVING`].
const STATE_PERIOD_AT_REST: Span = Span::from_secs(30);

/// Who has been reached by an event and may have something to say, or want to be woken at another time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Touched {
    controller: bool,
    carrier: bool,
    engine: bool,
}

/// What a caller is told while a run goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Bench time.
    pub now: Timestamp,
    /// Steps done.
    pub steps_done: u64,
    /// Steps in all.
    pub steps: u64,
}

/// One run in virtual time.
#[derive(Debug)]
pub struct SimulatedWorld {
    now: Timestamp,
    engine: Engine,
    controller: Controller,
    bench: Bench,
    lines: Lines,
    table_answers: AnswerDecoder,
    answers: BTreeMap<String, f64>,
    state_kept: Option<Timestamp>,
    touched: Touched,
    /// Wake-ups of those that are asked again only when something has reached them.
    controller_due: Timestamp,
    carrier_due: Timestamp,
    engine_due: Timestamp,
    events: u64,
    events_at_once: u32,
}

impl SimulatedWorld {
    /// A world at time zero.
    pub fn new(bench: Bench, engine: Engine) -> Self {
        let now = Timestamp::ZERO;
        Self {
            now,
            controller: Controller::new(bench.controller_config(), now),
            engine,
            lines: Lines::new(bench.gyro_stream(), bench.base_transport()),
            bench,
            table_answers: AnswerDecoder::new(),
            answers: BTreeMap::new(),
            state_kept: None,
            touched: Touched { controller: true, carrier: true, engine: true },
            controller_due: now,
            carrier_due: now,
            engine_due: now,
            events: 0,
            events_at_once: 0,
        }
    }

    /// Answers to what a person would be asked, by name.
    pub fn with_answers(mut self, answers: BTreeMap<String, f64>) -> Self {
        self.answers = answers;
        self
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

    /// What the lines between the devices have dropped for want of room.
    pub fn dropped(&self) -> u64 {
        self.lines.dropped()
    }

    /// Calibrations that the engine asks to be kept are handed to `keep`. Between two events `pulse` is
    /// called now and then; when it says false, the run is aborted.
    pub fn run(
        &mut self,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        pulse: &mut impl FnMut(Progress) -> bool,
    ) -> Ending {
        const EVENTS_PER_PULSE: u64 = 50_000;
        self.transmit(sink, keep);
        loop {
            if let Some(ending) = self.engine.ending() {
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
            self.deliver(sink);
            self.wake();
            self.transmit(sink, keep);
        }
    }

    /// Looks beyond the world: does anybody want the run to stop, does the disk still take the record?
    fn look_up(&mut self, sink: &mut impl RecordSink, pulse: &mut impl FnMut(Progress) -> bool) {
        let (steps_done, steps) = self.engine.progress();
        if !pulse(Progress { now: self.now, steps_done, steps }) {
            self.engine.abort(self.now);
            self.touched.engine = true;
        }
        if let Some(error) = sink.failed() {
            self.broke(&format!("failed to write the record: {error}"));
        }
    }

    fn broke(&mut self, why: &str) {
        self.engine.broke(self.now, why);
        self.touched.engine = true;
    }

    fn next_event(&self) -> Timestamp {
        self.lines
            .next_arrival()
            .min(self.bench.gyro.next_wakeup())
            .min(self.carrier_due)
            .min(self.controller_due)
            .min(self.engine_due)
    }

    fn deliver(&mut self, sink: &mut impl RecordSink) {
        let Self { now, lines, controller, bench, touched, engine, .. } = self;
        let now = *now;
        while let Some(packet) = lines.gyro.arrived(now) {
            sink.bytes(now, Device::Gyro, packet.as_slice());
            controller.receive(now, Port::Gyro, Input::Bytes(packet.as_slice()));
            touched.controller = true;
        }
        while let Some(packet) = lines.gyro_commands.arrived(now) {
            sink.bytes(now, Device::Controller, packet.as_slice());
            bench.gyro.receive(now, packet.as_slice());
        }
        match (&mut lines.base, &mut bench.carrier) {
            (BaseLink::Can(bus), Carrier::Base(base)) => {
                while let Some((from, frame)) = bus.arrived(now) {
                    match from {
                        Node::Controller => {
                            record_frame(sink, now, Device::Controller, frame);
                            base.receive_frame(now, &frame);
                            touched.carrier = true;
                        }
                        Node::Base => {
                            record_frame(sink, now, Device::Base, frame);
                            controller.receive(now, Port::Base, Input::Frame(frame));
                            touched.controller = true;
                        }
                    }
                }
            }
            (BaseLink::Serial { to_base, to_controller }, Carrier::Base(base)) => {
                while let Some(packet) = to_base.arrived(now) {
                    sink.bytes(now, Device::Controller, packet.as_slice());
                    base.receive_bytes(now, packet.as_slice());
                    touched.carrier = true;
                }
                while let Some(packet) = to_controller.arrived(now) {
                    sink.bytes(now, Device::Base, packet.as_slice());
                    controller.receive(now, Port::Base, Input::Bytes(packet.as_slice()));
                    touched.controller = true;
                }
            }
            _ => {}
        }
        // Without a table nobody is at the end of its line, and what is sent is lost there.
        while let Some(packet) = lines.to_table.arrived(now) {
            sink.bytes(now, Device::Plan, packet.as_slice());
            if let Carrier::Table(table) = &mut bench.carrier {
                table.receive(now, packet.as_slice());
                touched.carrier = true;
            }
        }
        while let Some(packet) = lines.from_table.arrived(now) {
            sink.bytes(now, Device::Table, packet.as_slice());
            self.table_answers.feed(packet.as_slice(), |answer| engine.table(now, answer));
            touched.engine = true;
        }
    }

    fn wake(&mut self) {
        let now = self.now;
        if self.carrier_due <= now {
            self.bench.carrier.wake(now);
            self.touched.carrier = true;
        }
        while self.bench.gyro.next_wakeup() <= now {
            let heading = self.bench.carrier.heading_at(now);
            if let Some(packet) = self.bench.gyro.wake(now, heading) {
                self.lines.gyro.send(now, packet);
            }
        }
        if self.controller_due <= now {
            self.controller.wake(now);
            self.touched.controller = true;
        }
        if self.engine_due <= now {
            self.engine.wake(now);
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
                self.engine.broke(self.now, "two devices answer each other without end");
                return;
            }
            if std::mem::take(&mut self.touched.controller) {
                while let Some(output) = self.controller.transmit(self.now) {
                    self.carry(output);
                }
                while let Some(report) = self.controller.report() {
                    self.record_report(sink, report);
                    self.engine.report(self.now, &report);
                    self.touched.engine = true;
                }
                self.controller_due = self.controller.next_wakeup();
            }
            if std::mem::take(&mut self.touched.carrier) {
                while let Some(sent) = self.bench.carrier.transmit() {
                    self.carry_sent(sent);
                }
                self.carrier_due = self.bench.carrier.next_wakeup();
            }
            if std::mem::take(&mut self.touched.engine) {
                while let Some(action) = self.engine.action() {
                    self.act(sink, keep, action);
                }
                self.engine_due = self.engine.next_wakeup();
            }
        }
    }

    fn carry(&mut self, output: Output) {
        match (output, &mut self.lines.base) {
            (Output::Bytes(Port::Gyro, packet), _) => {
                self.lines.gyro_commands.send(self.now, packet);
            }
            (Output::Bytes(Port::Base, packet), BaseLink::Serial { to_base, .. }) => {
                to_base.send(self.now, packet);
            }
            (Output::Frame(frame), BaseLink::Can(bus)) => {
                bus.send(self.now, Node::Controller, frame);
            }
            _ => {}
        }
    }

    fn carry_sent(&mut self, sent: Sent) {
        match (sent, &mut self.lines.base) {
            (Sent::Frame(frame), BaseLink::Can(bus)) => bus.send(self.now, Node::Base, frame),
            (Sent::BaseBytes(packet), BaseLink::Serial { to_controller, .. }) => {
                to_controller.send(self.now, packet);
            }
            (Sent::TableBytes(packet), _) => self.lines.from_table.send(self.now, packet),
            _ => {}
        }
    }

    fn act(&mut self, sink: &mut impl RecordSink, keep: &mut impl FnMut(&Action), action: Action) {
        let now = self.now;
        self.touched = Touched { controller: true, carrier: true, engine: true };
        match action {
            Action::Mission(mission) => self.controller.command(now, mission),
            Action::Table(command) => self.lines.to_table.send(now, command.encode()),
            Action::MeasureAbsolute => match self.bench.measure_absolute(now) {
                Some(pose) => self.engine.absolute(now, pose),
                None => {
                    self.engine.broke(now, "this bench has no base whose pose could be measured")
                }
            },
            Action::Place(pose) => match self.bench.place(now, pose) {
                Ok(()) => self.engine.answered(now),
                Err(why) => self.engine.broke(now, why),
            },
            Action::SetParameter { device, parameter, value } => {
                match self.bench.set_parameter(now, &device, &parameter, value) {
                    Ok(()) => self.engine.answered(now),
                    Err(why) => self.engine.broke(now, &why),
                }
            }
            Action::PowerCycle { device, .. } => {
                let why = format!("this bench cannot switch the power of \"{device}\"");
                self.engine.broke(now, &why);
            }
            // Nobody stands beside a simulated bench: what a person is asked to do is done, and a
            // number must have been given before.
            Action::Prompt { answer: None, .. } => self.engine.answered(now),
            Action::Prompt { answer: Some(answer), .. } => {
                match self.answers.get(answer.name.as_str()) {
                    Some(value) => self.engine.answered_with(now, *value),
                    None => {
                        let why = format!("no answer \"{}\" was given", answer.name);
                        self.engine.broke(now, &why);
                    }
                }
            }
            Action::SaveCalibration { .. } => keep(&action),
            Action::Record(device, kind) => sink.record(Record { at: now, device, kind }),
        }
    }

    fn record_report(&mut self, sink: &mut impl RecordSink, report: Report) {
        if let Report::State(state) = &report {
            let period = if state.activity == Activity::Idle && !state.moving {
                STATE_PERIOD_AT_REST
            } else {
                STATE_PERIOD_MOVING
            };
            let due = self.state_kept.is_none_or(|kept| self.now - kept >= period);
            if !due && sink.level() != Level::Full {
                return;
            }
            self.state_kept = Some(self.now);
            let truth = self.bench.truth(self.now);
            sink.record(Record { at: self.now, device: Device::Gyro, kind: truth });
        }
        let kind = RecordKind::Report(report);
        sink.record(Record { at: self.now, device: Device::Controller, kind });
    }
}

fn record_frame(sink: &mut impl RecordSink, at: Timestamp, device: Device, frame: CanFrame) {
    if sink.level() == Level::Full {
        sink.record(Record { at, device, kind: RecordKind::Frame(frame.into()) });
    }
}
