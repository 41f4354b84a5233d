//! What both worlds share: the plan's engine, the emulated devices, the lines between them.

use super::bench::{Bench, Carrier, Sent};
#[cfg(feature = "live")]
use super::crossing::Memory;
use super::crossing::{Crossing, Line, Toward};
use super::faults::Slips;
use super::lines::{BaseLink, Lines, Node};
use crate::engine::{Action, Engine};
use crate::operator::by_hand::{self, Survey};
use crate::operator::{Asked, Operator, RealRoles};
use crate::plan::Answer;
use crate::record::sink::{Level, RecordSink};
use crate::record::{Device, Record, RecordKind};
use controller::mission::{Activity, Mission, Report};
use wire::table::AnswerDecoder;
use wire::time::{Span, Timestamp};

/// Without the full record, states are kept this far apart in motion and at rest.
const STATE_PERIOD_MOVING: Span = Span::from_millis(200);
/// See [`STATE_PERIOD_MOVING`].
const STATE_PERIOD_AT_REST: Span = Span::from_secs(30);

/// Everything on the bench but the device under test.
#[derive(Debug)]
pub(super) struct Stage {
    pub(super) engine: Engine,
    pub(super) bench: Bench,
    pub(super) lines: Lines,
    /// Answers what a person is asked.
    pub(super) operator: Operator,
    /// Roles whose devices are real: what these are told to be, a person has to make them.
    pub(super) real: RealRoles,
    /// What a person gets wrong.
    pub(super) slips: Slips,
    /// What a person has measured so far.
    survey: Option<Survey>,
    table_answers: AnswerDecoder,
    state_kept: Option<Timestamp>,
}

impl Stage {
    pub(super) fn new(bench: Bench, engine: Engine) -> Self {
        Self {
            engine,
            lines: Lines::new(bench.gyro_stream(), bench.base_transport()),
            bench,
            operator: Operator::default(),
            real: RealRoles::default(),
            slips: Slips::default(),
            survey: None,
            table_answers: AnswerDecoder::new(),
            state_kept: None,
        }
    }

    /// Delivers what has come through to and from the table; says whether the table and the engine were
    /// reached.
    #[cfg(feature = "live")]
    pub(super) fn deliver_table(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
    ) -> (bool, bool) {
        self.deliver_table_across(now, &mut Memory, sink)
    }

    /// The same, through `crossing`.
    pub(super) fn deliver_table_across(
        &mut self,
        now: Timestamp,
        crossing: &mut impl Crossing,
        sink: &mut impl RecordSink,
    ) -> (bool, bool) {
        let (mut table_reached, mut engine_reached) = (false, false);
        // Where there is no table nobody listens, but every run ends with a command to it: left in the
        // line it would be due for ever, and time would stand still.
        while let Some(mut packet) = self.lines.to_table.arrived(now) {
            if let Carrier::Table(table) = &mut self.bench.carrier {
                if !crossing.bytes(Line::Table, Toward::Device, &mut packet) {
                    continue;
                }
                sink.bytes(now, Device::Plan, packet.as_slice());
                table.receive(now, packet.as_slice());
                table_reached = true;
            }
        }
        while let Some(mut packet) = self.lines.from_table.arrived(now) {
            if !crossing.bytes(Line::Table, Toward::Host, &mut packet) {
                continue;
            }
            self.hear_table(now, sink, packet.as_slice());
            engine_reached = true;
        }
        (table_reached, engine_reached)
    }

    /// Takes what the table has said.
    pub(super) fn hear_table(&mut self, now: Timestamp, sink: &mut impl RecordSink, bytes: &[u8]) {
        sink.bytes(now, Device::Table, bytes);
        let engine = &mut self.engine;
        self.table_answers.feed(bytes, |answer| engine.table(now, answer));
    }

    /// The gyro's outputs up to `now`, each at its own instant, onto its line.
    pub(super) fn wake_gyro(&mut self, now: Timestamp) {
        while self.bench.gyro.next_wakeup() <= now {
            let at = self.bench.gyro.next_wakeup();
            let heading = self.bench.carrier.heading_at(at);
            if self.bench.gyro.feels_motors() {
                self.bench.gyro.set_motor_current(self.bench.carrier.motor_current_at(at));
            }
            if let Some(packet) = self.bench.gyro.wake(at, heading) {
                self.lines.gyro.send(at, packet);
            }
        }
    }

    /// Puts what a carrier sends on its line.
    pub(super) fn carry(&mut self, now: Timestamp, sent: Sent) {
        match (sent, &mut self.lines.base) {
            (Sent::Frame(frame), BaseLink::Can(bus)) => bus.send(now, Node::Base, frame),
            (Sent::BaseBytes(packet), BaseLink::Serial { to_controller, .. }) => {
                to_controller.send(now, packet);
            }
            (Sent::TableBytes(packet), _) => self.lines.from_table.send(now, packet),
            _ => {}
        }
    }

    /// Carries out what the engine asks; a mission is handed back for the device under test.
    pub(super) fn act(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        action: Action,
    ) -> Option<Mission> {
        match action {
            Action::Mission(mission) => return Some(mission),
            Action::Table(command) => self.lines.to_table.send(now, command.encode()),
            Action::MeasureAbsolute if self.real.base => {
                self.survey = Some(Survey::default());
                self.go_on_measuring(now, sink);
            }
            Action::Place(pose) if self.real.base => {
                self.ask(now, sink, &by_hand::place(pose), None);
            }
            Action::SetParameter { device, parameter, value } if self.real.has(&device) => {
                let text = by_hand::set_parameter(&device, &parameter, value);
                self.ask(now, sink, &text, None);
            }
            Action::PowerCycle { device, off } if self.real.has(&device) => {
                self.ask(now, sink, &by_hand::power_cycle(&device, off), None);
            }
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
            Action::Prompt { text, answer } => {
                self.survey = None;
                self.ask(now, sink, &text, answer.as_ref());
            }
            // A plan of a robot or a table says nothing of one; it was checked.
            Action::Send(_) | Action::StopSending(_) => {
                self.engine.broke(now, "this bench has no device of one's own");
            }
            Action::SaveCalibration { .. } | Action::KeepFound { .. } => keep(&action),
            // Whoever injects faults has taken it before.
            Action::Phase(_) => {}
            Action::Record(device, kind) => sink.record(Record { at: now, device, kind }),
        }
        None
    }

    fn ask(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        text: &str,
        answer: Option<&Answer>,
    ) {
        let asked = self.operator.ask(text, answer);
        self.asked(now, sink, asked);
    }

    /// Asks for the next number of a pose; hands the pose on once all is measured.
    fn go_on_measuring(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        let Some(survey) = &self.survey else { return };
        if let Some(pose) = survey.pose() {
            self.survey = None;
            self.engine.absolute(now, pose);
        } else if let Some((text, answer)) = survey.next() {
            self.ask(now, sink, &text, answer.as_ref());
        }
    }

    /// Hands on what came of a question to a person.
    fn asked(&mut self, now: Timestamp, sink: &mut impl RecordSink, asked: Asked) {
        match asked {
            Asked::Waiting => {}
            Asked::Assumed => self.engine.answered(now),
            Asked::Nobody(why) => self.engine.broke(now, &why),
            Asked::Replied(mut reply) => {
                self.slips.change(&mut reply);
                let value = reply.number.as_ref().map(|number| number.value);
                let kind = RecordKind::Reply(Box::new(reply));
                sink.record(Record { at: now, device: Device::Plan, kind });
                match (value, &mut self.survey) {
                    (Some(value), Some(survey)) => {
                        survey.take(value);
                        self.go_on_measuring(now, sink);
                    }
                    (Some(value), None) => self.engine.answered_with(now, value),
                    (None, _) => self.engine.answered(now),
                }
            }
        }
    }

    /// Takes what the person beside the bench has said by now.
    #[cfg(feature = "live")]
    pub(super) fn listen_to_operator(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        if let Some(asked) = self.operator.heard() {
            self.asked(now, sink, asked);
        }
    }

    /// Records what went wrong without ending the run.
    #[cfg(feature = "live")]
    pub(super) fn note(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        device: Device,
        what: String,
    ) {
        sink.record(Record { at: now, device, kind: RecordKind::Note(what) });
    }

    /// Records a report, the truth beside a state. Without the full record, states are thinned.
    pub(super) fn record_report(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        report: &Report,
    ) {
        if let Report::State(state) = report {
            let period = if state.activity == Activity::Idle && !state.moving {
                STATE_PERIOD_AT_REST
            } else {
                STATE_PERIOD_MOVING
            };
            let due = self.state_kept.is_none_or(|kept| now - kept >= period);
            if !due && sink.level() != Level::Full {
                return;
            }
            self.state_kept = Some(now);
            // Of real devices nobody knows the truth.
            if !(self.real.gyro || self.real.base) {
                let truth = self.bench.truth(now);
                sink.record(Record { at: now, device: Device::Gyro, kind: truth });
            }
        }
        let kind = RecordKind::Report(*report);
        sink.record(Record { at: now, device: Device::Controller, kind });
    }
}
