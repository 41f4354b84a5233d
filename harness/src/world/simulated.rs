//! The simulated world: virtual time, the same bytes as on real lines, one event after another.
//!
//! Time jumps to the next event. At equal times the order is: deliver what has arrived, wake what is
//! due, transmit until nothing moves any more, record. Nothing here reads a clock or draws a number,
//! so plan, seed and version determine every byte of the record.

use super::bench::{Bench, Carrier, Sent};
use crate::engine::{Action, Ending, Engine};
use crate::link::{CanBus, SerialLine};
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
/// Without the full record, states are kept this far apart in motion and at rest.
const STATE_PERIOD_MOVING: Span = Span::from_millis(200);
/// See [`STATE_PERIOD_MOVING`].
const STATE_PERIOD_AT_REST: Span = Span::from_secs(30);

/// Who put a frame on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Node {
    Controller,
    Base,
}

/// How the controller and the base are joined.
#[derive(Debug)]
enum BaseLink {
    None,
    Can(CanBus<Node>),
    Serial { to_base: SerialLine, to_controller: SerialLine },
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
    gyro_line: SerialLine,
    gyro_commands: SerialLine,
    base_link: BaseLink,
    to_table: SerialLine,
    from_table: SerialLine,
    table_answers: AnswerDecoder,
    answers: BTreeMap<String, f64>,
    state_kept: Option<Timestamp>,
    events: u64,
}

impl SimulatedWorld {
    /// A world at time zero.
    pub fn new(bench: Bench, engine: Engine) -> Self {
        let now = Timestamp::ZERO;
        let gyro = bench.gyro_stream().format.serial();
        let base_link = match bench.base_transport() {
            None => BaseLink::None,
            Some(controller::config::Transport::Can) => BaseLink::Can(CanBus::new()),
            Some(controller::config::Transport::Serial) => {
                let settings = wire::base::serial_link::SETTINGS;
                BaseLink::Serial {
                    to_base: SerialLine::new(settings),
                    to_controller: SerialLine::new(settings),
                }
            }
        };
        let table = wire::table::SETTINGS;
        Self {
            now,
            controller: Controller::new(bench.controller_config(), now),
            engine,
            gyro_line: SerialLine::new(gyro),
            gyro_commands: SerialLine::new(gyro),
            base_link,
            to_table: SerialLine::new(table),
            from_table: SerialLine::new(table),
            bench,
            table_answers: AnswerDecoder::new(),
            answers: BTreeMap::new(),
            state_kept: None,
            events: 0,
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

    /// Calibrations and other things that the engine asks to be kept are handed to `keep`. Between two
    /// events `pulse` is called now and then; when it says false, the run is aborted.
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
                let (steps_done, steps) = self.engine.progress();
                if !pulse(Progress { now: self.now, steps_done, steps }) {
                    self.engine.abort(self.now);
                }
                if let Some(error) = sink.failed() {
                    let why = format!("failed to write the record: {error}");
                    self.engine.broke(self.now, &why);
                }
            }
            let next = self.next_event();
            if next == Timestamp::MAX {
                self.engine.broke(self.now, "nothing is left that could happen");
                continue;
            }
            self.now = self.now.max(next);
            self.events += 1;
            self.deliver(sink);
            self.wake();
            self.transmit(sink, keep);
        }
    }

    fn next_event(&self) -> Timestamp {
        let links = match &self.base_link {
            BaseLink::None => Timestamp::MAX,
            BaseLink::Can(bus) => bus.next_arrival(),
            BaseLink::Serial { to_base, to_controller } => {
                to_base.next_arrival().min(to_controller.next_arrival())
            }
        };
        links
            .min(self.gyro_line.next_arrival())
            .min(self.gyro_commands.next_arrival())
            .min(self.to_table.next_arrival())
            .min(self.from_table.next_arrival())
            .min(self.bench.gyro.next_wakeup())
            .min(self.bench.carrier.next_wakeup())
            .min(self.controller.next_wakeup())
            .min(self.engine.next_wakeup())
    }

    fn deliver(&mut self, sink: &mut impl RecordSink) {
        let now = self.now;
        while let Some(packet) = self.gyro_line.arrived(now) {
            sink.bytes(now, Device::Gyro, packet.as_slice());
            self.controller.receive(now, Port::Gyro, Input::Bytes(packet.as_slice()));
        }
        while let Some(packet) = self.gyro_commands.arrived(now) {
            sink.bytes(now, Device::Controller, packet.as_slice());
            self.bench.gyro.receive(now, packet.as_slice());
        }
        match (&mut self.base_link, &mut self.bench.carrier) {
            (BaseLink::Can(bus), Carrier::Base(base)) => {
                while let Some((from, frame)) = bus.arrived(now) {
                    match from {
                        Node::Controller => {
                            record_frame(sink, now, Device::Controller, frame);
                            base.receive_frame(now, &frame);
                        }
                        Node::Base => {
                            record_frame(sink, now, Device::Base, frame);
                            self.controller.receive(now, Port::Base, Input::Frame(frame));
                        }
                    }
                }
            }
            (BaseLink::Serial { to_base, to_controller }, Carrier::Base(base)) => {
                while let Some(packet) = to_base.arrived(now) {
                    sink.bytes(now, Device::Controller, packet.as_slice());
                    base.receive_bytes(now, packet.as_slice());
                }
                while let Some(packet) = to_controller.arrived(now) {
                    sink.bytes(now, Device::Base, packet.as_slice());
                    self.controller.receive(now, Port::Base, Input::Bytes(packet.as_slice()));
                }
            }
            _ => {}
        }
        if let Carrier::Table(table) = &mut self.bench.carrier {
            while let Some(packet) = self.to_table.arrived(now) {
                sink.bytes(now, Device::Plan, packet.as_slice());
                table.receive(now, packet.as_slice());
            }
        }
        while let Some(packet) = self.from_table.arrived(now) {
            sink.bytes(now, Device::Table, packet.as_slice());
            self.table_answers.feed(packet.as_slice(), |answer| self.engine.table(now, answer));
        }
    }

    fn wake(&mut self) {
        let now = self.now;
        if self.bench.carrier.next_wakeup() <= now {
            self.bench.carrier.wake(now);
        }
        while self.bench.gyro.next_wakeup() <= now {
            let heading = self.bench.carrier.heading_at(now);
            if let Some(packet) = self.bench.gyro.wake(now, heading) {
                self.gyro_line.send(now, packet);
            }
        }
        if self.controller.next_wakeup() <= now {
            self.controller.wake(now);
        }
        if self.engine.next_wakeup() <= now {
            self.engine.wake(now);
        }
    }

    /// Carries everything that anybody has to say, until nobody has.
    fn transmit(&mut self, sink: &mut impl RecordSink, keep: &mut impl FnMut(&Action)) {
        for _ in 0..ROUNDS_MAX {
            let mut quiet = true;
            while let Some(output) = self.controller.transmit(self.now) {
                quiet = false;
                self.carry(output);
            }
            while let Some(report) = self.controller.report() {
                quiet = false;
                self.record_report(sink, report);
                self.engine.report(self.now, &report);
            }
            while let Some(sent) = self.bench.carrier.transmit() {
                quiet = false;
                match (sent, &mut self.base_link) {
                    (Sent::Frame(frame), BaseLink::Can(bus)) => {
                        bus.send(self.now, Node::Base, frame)
                    }
                    (Sent::BaseBytes(packet), BaseLink::Serial { to_controller, .. }) => {
                        to_controller.send(self.now, packet);
                    }
                    (Sent::TableBytes(packet), _) => self.from_table.send(self.now, packet),
                    _ => {}
                }
            }
            while let Some(action) = self.engine.action() {
                quiet = false;
                self.act(sink, keep, action);
            }
            if quiet {
                return;
            }
        }
        self.engine.broke(self.now, "two devices answer each other without end");
    }

    fn carry(&mut self, output: Output) {
        match (output, &mut self.base_link) {
            (Output::Bytes(Port::Gyro, packet), _) => self.gyro_commands.send(self.now, packet),
            (Output::Bytes(Port::Base, packet), BaseLink::Serial { to_base, .. }) => {
                to_base.send(self.now, packet);
            }
            (Output::Frame(frame), BaseLink::Can(bus)) => {
                bus.send(self.now, Node::Controller, frame)
            }
            _ => {}
        }
    }

    fn act(&mut self, sink: &mut impl RecordSink, keep: &mut impl FnMut(&Action), action: Action) {
        let now = self.now;
        match action {
            Action::Mission(mission) => self.controller.command(now, mission),
            Action::Table(command) => self.to_table.send(now, command.encode()),
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

impl SimulatedWorld {
    /// What the lines between the devices have dropped for want of room.
    pub fn dropped(&self) -> u64 {
        let base = match &self.base_link {
            BaseLink::None => 0,
            BaseLink::Can(bus) => bus.dropped(),
            BaseLink::Serial { to_base, to_controller } => {
                to_base.dropped() + to_controller.dropped()
            }
        };
        base + self.gyro_line.dropped()
            + self.gyro_commands.dropped()
            + self.to_table.dropped()
            + self.from_table.dropped()
    }
}

fn record_frame(sink: &mut impl RecordSink, at: Timestamp, device: Device, frame: CanFrame) {
    if sink.level() == Level::Full {
        sink.record(Record { at, device, kind: RecordKind::Frame(frame.into()) });
    }
}
