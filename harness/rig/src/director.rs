//! Carries out the orders of the plan's engine on a rig.

use super::Rig;
use super::node::Part;
use super::slips::{Slips, slip};
use crate::engine::{Action, Engine};
use crate::operator::by_hand::{self, Survey};
use crate::operator::{Asked, Operator, RealRoles};
use crate::talk::Talk;
use crate::{Keep, Sink};
use controller::mission::{Activity, Mission, Report};
use identification::finding::Compensation;
use plan::models;
use plan::{Answer, Order, Send};
use record::outcome::CommandSummary;
use record::sink::Level;
use record::{Device, Record, RecordKind};
use wire::device::{PortId, Transmit};
use wire::table::AnswerDecoder;
use wire::time::{Span, Timestamp};

/// Without the full record, states in motion are kept this far apart.
const STATE_PERIOD_MOVING: Span = Span::from_millis(200);
/// Without the full record, states at rest are kept this far apart.
const STATE_PERIOD_AT_REST: Span = Span::from_secs(30);

#[derive(Debug)]
pub struct Director {
    pub engine: Engine,
    pub operator: Operator,
    /// Roles that real devices play: a person carries out the orders to them.
    pub real: RealRoles,
    pub commands: Vec<CommandSummary>,
    pub talk: Talk,
    pub(super) slips: Slips,
    /// The measurement that a person is making.
    survey: Option<Survey>,
    table_answers: AnswerDecoder,
    state_kept: Option<Timestamp>,
}

impl Director {
    pub fn new(engine: Engine, operator: Operator) -> Self {
        Self {
            engine,
            operator,
            real: RealRoles::default(),
            commands: Vec::new(),
            talk: Talk::default(),
            slips: Slips::default(),
            survey: None,
            table_answers: AnswerDecoder::default(),
            state_kept: None,
        }
    }

    /// A copy in the same state. `None` where a person answers.
    pub(super) fn copied(&self) -> Option<Self> {
        Some(Self {
            engine: self.engine.clone(),
            operator: self.operator.copied()?,
            real: self.real,
            commands: self.commands.clone(),
            talk: self.talk.clone(),
            slips: self.slips.clone(),
            survey: self.survey.clone(),
            table_answers: self.table_answers.clone(),
            state_kept: self.state_kept,
        })
    }

    pub fn hear_table(&mut self, now: Timestamp, bytes: &[u8]) {
        let engine = &mut self.engine;
        self.table_answers.feed(bytes, |answer| engine.table(now, answer));
    }

    /// Carries out the engine's actions on `rig`; returns a mission for the device under test.
    pub fn act(
        &mut self,
        now: Timestamp,
        rig: &mut Rig,
        sink: Sink<'_>,
        keep: Keep<'_>,
        action: Action,
    ) -> Option<Mission> {
        match action {
            Action::Mission(mission) => return Some(*mission),
            Action::Table(command) => {
                if let Some(plan) = place_of_plan(rig) {
                    rig.send(now, plan, PortId(0), Transmit::Bytes(command.encode()));
                }
            }
            Action::MeasureAbsolute if self.real.base => {
                self.survey = Some(Survey::default());
                self.go_on_measuring(now, sink);
            }
            Action::Correct { node, signal, compensation } if self.real.has(&node) => {
                let text = by_hand::correct(&node, &signal, compensation.as_deref());
                self.ask(now, sink, &text, None);
            }
            Action::MeasureAbsolute => {
                let pose = rig.robot_mut().and_then(|robot| robot.bench.measure_absolute(now));
                match pose {
                    Some(pose) => self.engine.absolute(now, pose),
                    None => self
                        .engine
                        .broke(now, "this bench has no base whose pose could be measured"),
                }
            }
            Action::Look => {
                let robot = rig.robot().filter(|_| !self.real.base);
                let look = robot.and_then(|robot| robot.bench.look(now));
                self.engine.looked(now, look);
            }
            Action::Order(order) => self.carry_out(now, rig, sink, order),
            Action::Correct { node, signal, compensation } => {
                match correct(rig, &node, &signal, compensation.as_deref()) {
                    Ok(()) => self.engine.answered(now),
                    Err(why) => self.engine.broke(now, &why),
                }
            }
            Action::SaveCalibration { .. } | Action::KeepFound { .. } => keep(&action),
            // The injector of faults has already taken it.
            Action::Phase(_) => {}
            Action::Record(device, kind) => sink.record(Record { at: now, device, kind }),
        }
        None
    }

    fn carry_out(&mut self, now: Timestamp, rig: &mut Rig, sink: Sink<'_>, order: Order) {
        if let Some((text, answer)) = by_hand::question(&order, self.real) {
            self.survey = None;
            return self.ask(now, sink, &text, answer.as_ref());
        }
        let done = match order {
            Order::Place(pose) => match rig.robot_mut() {
                Some(robot) => robot.bench.place(now, pose).map_err(str::to_owned),
                None => Err("this bench has no robot that could be carried".to_owned()),
            },
            Order::SetParameter { device, .. } if is_replayed(rig, &device) => Ok(()),
            Order::SetParameter { device, parameter, value } => {
                set_parameter(rig, now, &device, &parameter, value)
            }
            Order::PowerCycle { device, off } => {
                let node = rig.find(&device).and_then(|place| rig.nodes.get_mut(place));
                let Some(node) = node.filter(|node| node.is_powered()) else {
                    let why = format!("this bench cannot switch the power of \"{device}\"");
                    return self.engine.broke(now, &why);
                };
                // The plan goes on once it is on again.
                return node.cut_for(now, off);
            }
            Order::Send(send) => match send_message(rig, now, &send) {
                Ok(()) => return,
                failed => failed,
            },
            Order::StopSending(message) => {
                for node in &mut rig.nodes {
                    if let Part::Tester(tester) = &mut node.part {
                        tester.stop(&message);
                    }
                }
                return;
            }
            Order::Ask { node, request } => {
                let asked = rig.nodes.iter_mut().position(|known| match &mut known.part {
                    Part::Tester(tester) => tester.ask(now, &node, &request),
                    Part::Replayed(replaying) => replaying.ask(now, &node, &request),
                    _ => false,
                });
                match asked {
                    Some(place) => return rig.empty(now, place),
                    None => Err(format!("nobody on this bench can ask \"{node}\"")),
                }
            }
            Order::Command(name) => {
                self.pass_over(now, sink, &name);
                Ok(())
            }
            Order::Prompt { .. } => return,
        };
        match done {
            Ok(()) => self.engine.answered(now),
            Err(why) => self.engine.broke(now, &why),
        }
    }

    /// Records that a command was not run, for worlds without a bench. A world with a bench runs it before this call.
    fn pass_over(&mut self, now: Timestamp, sink: Sink<'_>, command: &str) {
        if CommandSummary::passed_over(&mut self.commands, command) {
            let note = format!("`{command}` was not run: in virtual time there is no bench");
            sink.record(Record { at: now, device: Device::Plan, kind: RecordKind::Note(note) });
        }
    }

    fn ask(&mut self, now: Timestamp, sink: Sink<'_>, text: &str, answer: Option<&Answer>) {
        let asked = self.operator.ask(text, answer);
        self.asked(now, sink, asked);
    }

    /// Asks for the next number of a pose; passes the pose on once it is complete.
    fn go_on_measuring(&mut self, now: Timestamp, sink: Sink<'_>) {
        let Some(survey) = &self.survey else { return };
        if let Some(pose) = survey.pose() {
            self.survey = None;
            self.engine.absolute(now, pose);
        } else if let Some((text, answer)) = survey.next() {
            self.ask(now, sink, &text, answer.as_ref());
        }
    }

    /// Handles the outcome of a question to a person.
    fn asked(&mut self, now: Timestamp, sink: Sink<'_>, asked: Asked) {
        match asked {
            Asked::Waiting => {}
            Asked::Assumed => self.engine.answered(now),
            Asked::Nobody(why) => self.engine.broke(now, &why),
            Asked::Replied(mut reply) => {
                slip(&mut self.slips, &mut reply);
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

    /// Handles what the person beside the bench has typed by now.
    pub fn listen_to_operator(&mut self, now: Timestamp, sink: Sink<'_>) {
        if let Some(asked) = self.operator.heard() {
            self.asked(now, sink, asked);
        }
    }

    /// Records a report, and the truth with a state. Without the full record, states are thinned.
    pub fn record_report(
        &mut self,
        now: Timestamp,
        rig: &mut Rig,
        sink: Sink<'_>,
        report: &Report,
    ) {
        if let Report::State(state) = report {
            if state.heading_error.is_some()
                && !self.real.base
                && self.engine.wants_truth()
                && let Some(truth) = rig.robot().and_then(|robot| robot.bench.true_pose(now))
            {
                self.engine.true_on_line(now, &truth);
            }
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
            // The truth of real devices is unknown.
            let robot = rig.robot_mut().filter(|_| !(self.real.gyro || self.real.base));
            if let Some(robot) = robot {
                let kind = robot.bench.truth(now);
                sink.record(Record { at: now, device: Device::Gyro, kind });
            }
        }
        let kind = RecordKind::Report(*report);
        sink.record(Record { at: now, device: Device::Controller, kind });
    }
}

/// Whether a log plays the device: orders to it were carried out when it was recorded.
fn is_replayed(rig: &Rig, device: &str) -> bool {
    rig.find(device).is_some_and(|place| matches!(rig.nodes[place].part, Part::Replayed(_)))
}

fn place_of_plan(rig: &Rig) -> Option<usize> {
    rig.nodes.iter().position(|node| matches!(node.part, Part::Plan))
}

fn set_parameter(
    rig: &mut Rig,
    now: Timestamp,
    device: &str,
    parameter: &str,
    value: f64,
) -> Result<(), String> {
    if let Some(place) = rig.find(device)
        && let Part::Described(described) = &mut rig.nodes[place].part
    {
        let taken = described.set_parameter(now, parameter, value);
        return taken
            .then_some(())
            .ok_or_else(|| format!("the device takes no {parameter} = {value}"));
    }
    match rig.robot_mut() {
        Some(robot) => robot.bench.set_parameter(now, device, parameter, value),
        None => Err(format!("this bench has no device \"{device}\"")),
    }
}

/// Makes the node's emulator correct its signal, as its firmware would.
fn correct(
    rig: &mut Rig,
    node: &str,
    signal: &str,
    compensation: Option<&Compensation>,
) -> Result<(), String> {
    let part = rig.find(node).and_then(|place| rig.nodes.get_mut(place)).map(|node| &mut node.part);
    let Some(Part::Described(described)) = part else {
        return Err(format!(
            "`{node}` is no emulated node that a file describes: its own firmware takes the errors off, by the steps in \
             the finding"
        ));
    };
    described.correct(signal, compensation.map(models::correction).as_ref())
}

/// The tester that sends this message puts it on its line at once.
fn send_message(rig: &mut Rig, now: Timestamp, send: &Send) -> Result<(), String> {
    let speaks = |part: &Part| matches!(part, Part::Tester(tester) if tester.knows(&send.message));
    let place = rig.nodes.iter().position(|node| speaks(&node.part));
    let Some(place) = place else {
        if rig.nodes.iter().any(|node| matches!(node.part, Part::Replayed(_))) {
            return Ok(());
        }
        return Err(format!("nobody on this bench sends `{}`", send.message));
    };
    if let Part::Tester(tester) = &mut rig.nodes[place].part {
        tester.send(now, send)?;
    }
    rig.empty(now, place);
    Ok(())
}
