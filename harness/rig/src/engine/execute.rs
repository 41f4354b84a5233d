//! Begins operations, and goes from step to step.

use super::program::Next;
use super::rest_watch::Window;
use super::strays::FIRST_MISSION;
use super::{Action, Engine, StepAction, Waiting, fit};
use controller::mission::{Command, Mission};
use plan::quantities::{self as q, OPEN_AT_STEP};
use plan::{Fit, Known, Op, Order, SaveCalibration};
use record::outcome::Outcome;
use record::{Device, RecordKind, figures};
use wire::table;
use wire::time::{Span, Timestamp};
use wire::units::Temperature;

/// Longest wait for rest before the first mission. Assumption: a base at rest tells of itself once a second, and the
/// controller its state.
const FIRST_REST_MAX: Span = Span::from_secs(5);
/// Time between two queries to a turning table.
const TABLE_POLL: Span = Span::from_millis(100);

impl Engine {
    /// Begins operations until one has to wait.
    pub(super) fn advance(&mut self, now: Timestamp) {
        while self.waiting == Waiting::Nothing && self.ending.is_none() {
            match self.ops.pop_front() {
                Some(op) => self.begin(now, op),
                None => self.next_step(now),
            }
        }
    }

    pub(super) fn pass_time(&mut self, now: Timestamp) {
        match self.waiting {
            Waiting::Until(at) | Waiting::FirstRest(at) if now >= at => {
                self.waiting = Waiting::Nothing;
            }
            Waiting::Residual(at) if now >= at => {
                self.waiting = Waiting::Nothing;
                self.end_residual(now);
            }
            Waiting::Log { until, interval, due } if now >= due => {
                if let Some(window) = self.close_window() {
                    self.observe(now, |collector| collector.log(&window));
                }
                let state = self.robot.as_ref().and_then(|robot| robot.state);
                let is_silent = state.is_some_and(|state| state.health.causes.gyro_silent);
                self.waiting = if now >= until && is_silent {
                    return self.end_here(now, Outcome::Failed, "the gyro was silent at its end");
                } else if now >= until {
                    Waiting::Nothing
                } else {
                    Waiting::Log { until, interval, due: (due + interval).min(until) }
                };
            }
            Waiting::TableRest { ask_at } if now >= ask_at => {
                self.actions.push_back(Action::Table(table::Command::State));
                self.waiting = Waiting::TableRest { ask_at: now + TABLE_POLL };
            }
            Waiting::Sdo => self.check_sdo(now),
            Waiting::Reaction => {
                let took = self.reactions.pass_time(now);
                self.observe(now, |collector| {
                    took.into_iter().for_each(|took| collector.reaction(took));
                });
                self.ends_wait();
            }
            _ => {}
        }
    }

    fn next_step(&mut self, now: Timestamp) {
        if let Some((_, since, _)) = self.step.take() {
            let duration_s = (now - since).as_secs_f64();
            self.observe(now, |collector| collector.add(&q::STEP_DURATION, duration_s, 0.0, &[]));
            let path = self.program.place();
            self.record(RecordKind::StepEnded { path });
            self.phases.step_ended(&mut self.actions);
            self.program.step_done();
        }
        let is_over = |action: &StepAction| match action {
            StepAction::Repeat(repeat) => {
                let until = repeat.until.as_ref();
                until.is_some_and(|until| self.signals.holds(until))
            }
            _ => false,
        };
        match self.program.next(now, is_over) {
            Next::Done => self.end(now, Outcome::Passed, None),
            Next::Round { set, not_before, overrun_s } => {
                self.round_begun = true;
                self.step_deadline = self.program.deadline();
                if let Some(overrun_s) = overrun_s {
                    self.observe(now, |collector| {
                        collector.add(&q::REPEAT_OVERRUN, overrun_s, 0.0, &[]);
                    });
                }
                if not_before > now {
                    self.ops.push_back(Op::PauseUntil(not_before));
                }
                self.ops.extend(set.map(Op::Order));
            }
            Next::Step(step) => {
                // A round that begins with another repeat is not counted on its own.
                self.rounds += u64::from(std::mem::take(&mut self.round_begun));
                let label = step.label.as_ref().map(|label| label.as_str());
                let tags = self.program.tags(&step.action, label, self.rounds);
                let gaps = self.gaps.left(now.min(self.known_until), &self.tags, &tags);
                self.observe(now, |collector| collector.gaps(gaps, OPEN_AT_STEP));
                self.tags = tags;
                self.reactions.step_began(now, &self.tags);
                let until = now + step.time_limit();
                self.step_deadline = until.min(self.program.deadline());
                self.answer_limit = step.answer_limit();
                self.record(RecordKind::StepBegan {
                    path: self.program.place(),
                    title: step.action.to_string(),
                });
                self.phases.step_began(&self.program, &mut self.actions);
                self.step = Some((step.action.clone(), now, until));
                let known = match &self.robot {
                    None => Known::default(),
                    Some(robot) => Known {
                        table_step: robot.facts.table_step,
                        calibrations: &robot.calibrations,
                    },
                };
                match step.action.script(&known) {
                    Ok(ops) => self.ops.extend(ops),
                    Err(why) => {
                        self.end_here(now, Outcome::Error, &why);
                    }
                }
            }
        }
    }

    /// Takes the number that a person gave. The operator asks again for a number out of range; here it is an error.
    pub fn answered_with(&mut self, now: Timestamp, value: f64) {
        let Waiting::Answer(Some(answer)) = &self.waiting else { return };
        let answer = answer.clone();
        if !answer.range.contains(value) {
            let given = figures::with_unit(value.to_string(), &answer.unit);
            let why = format!("the answer {} = {given} is not in {}", answer.name, answer.range);
            self.end(now, Outcome::Error, Some(why));
            return;
        }
        let name = format!("{}{}", q::OPERATOR_PREFIX, answer.name);
        self.observe(now, |collector| {
            collector.add_named(&name, value, answer.uncertainty, &[]);
        });
        self.waiting = Waiting::Nothing;
        self.advance(now);
    }

    fn begin(&mut self, now: Timestamp, op: Op) {
        match op {
            Op::Mission(command) => {
                self.first_rest(now);
                match self.waiting {
                    Waiting::Nothing => self.send(now, *command),
                    _ => self.ops.push_front(Op::Mission(command)),
                }
            }
            Op::StateBefore | Op::StateAfter => {
                if let Some(robot) = &mut self.robot {
                    match op {
                        Op::StateBefore => robot.ends.state_before = None,
                        _ => robot.ends.state_after = None,
                    }
                }
                self.send(now, Command::RequestState);
            }
            Op::AbsoluteBefore | Op::AbsoluteAfter | Op::AbsoluteNamed => {
                if let (Op::AbsoluteBefore, Some(robot)) = (&op, &mut self.robot) {
                    robot.ends.look_before = None;
                }
                self.actions.push_back(Action::MeasureAbsolute);
                self.waiting = Waiting::Absolute(op);
            }
            Op::Look(segment) => {
                self.actions.push_back(Action::Look);
                self.waiting = Waiting::Look(segment);
            }
            Op::Pause(span) => self.waiting = Waiting::Until(now + span),
            Op::PauseUntil(at) => self.waiting = Waiting::Until(at),
            Op::Log { duration, interval } => {
                self.open_window();
                let until = now + duration;
                let due = (now + interval).min(until);
                self.waiting = Waiting::Log { until, interval, due };
            }
            Op::Residual(duration) => {
                self.open_window();
                self.waiting = Waiting::Residual(now + duration);
            }
            Op::Condition(condition) => self.waiting = Waiting::Condition(condition),
            Op::Reaction(name) => {
                self.reactions.await_one(&name, now, self.step_deadline);
                self.waiting = Waiting::Reaction;
            }
            Op::Rest => {
                let state = self.robot.as_ref().and_then(|robot| robot.state);
                if state.is_some_and(|state| state.moving) {
                    self.waiting = Waiting::Rest;
                }
            }
            Op::Table(command) => {
                self.actions.push_back(Action::Table(command));
                self.waiting = Waiting::TableWord;
            }
            Op::TableAtRest => {
                self.actions.push_back(Action::Table(table::Command::State));
                self.waiting = Waiting::TableRest { ask_at: now + TABLE_POLL };
            }
            Op::ObserveLap(direction) => {
                let Some(robot) = &self.robot else { return };
                let (ends, facts) = (robot.ends, robot.facts);
                self.observe(now, |collector| collector.lap(&ends, direction, &facts));
            }
            Op::ObserveTableTurn(turn) => {
                let Some(robot) = &mut self.robot else { return };
                let (ends, facts, heading) = (robot.ends, robot.facts, robot.table_heading);
                robot.table_heading += turn.angle;
                self.observe(now, |collector| {
                    collector.table_turn(&ends, &turn, heading, &facts);
                });
            }
            Op::Order(order) => {
                match &order {
                    Order::Send(_) | Order::StopSending(_) | Order::Ask { .. } => {}
                    Order::Prompt { answer, .. } => self.waiting = Waiting::Answer(answer.clone()),
                    _ => self.waiting = Waiting::Answer(None),
                }
                self.actions.push_back(Action::Order(order));
            }
            Op::Uds(step) => {
                let (node, request) = (step.node().to_owned(), step.request());
                self.actions.push_back(Action::Order(Order::Ask { node, request }));
                self.waiting = Waiting::Reply(step);
            }
            Op::Sdo(step) => self.begin_sdo(now, step),
            Op::Fit(step) => self.fit(now, &step),
            Op::SaveCalibration(step) => self.save_calibration(now, &step),
            Op::Identify(step) => self.identify(now, &step),
            Op::UseModel(name) => self.use_model(now, name.as_deref()),
        }
    }

    /// Before the first mission, waits a while for a state at rest: a controller that has just started says that its base
    /// moves until it has heard from it, and refuses.
    fn first_rest(&mut self, now: Timestamp) {
        let Some(robot) = &mut self.robot else { return };
        let is_first =
            robot.next_id == FIRST_MISSION && !std::mem::replace(&mut robot.awaited, true);
        if is_first && robot.state.is_some_and(|state| state.moving) {
            self.waiting = Waiting::FirstRest(now + FIRST_REST_MAX);
        }
    }

    pub(super) fn record(&mut self, kind: RecordKind) {
        self.actions.push_back(Action::Record(Device::Plan, kind));
    }

    pub(super) fn send(&mut self, now: Timestamp, command: Command) {
        let Some(robot) = &mut self.robot else { return };
        let id = robot.next_id;
        robot.next_id = robot.next_id.wrapping_add(1);
        match &command {
            Command::SetHeadingSource(source) => robot.heading_source = *source,
            Command::SetCalibration(calibration) => {
                if *calibration != robot.calibration {
                    robot.calibration_since = now;
                }
                robot.calibration = calibration.clone();
                robot.model = None;
            }
            _ => {}
        }
        self.record(RecordKind::Command(Box::new(command.clone())));
        self.phases.mission_began(&command, &mut self.actions);
        self.actions.push_back(Action::Mission(Box::new(Mission { id, command })));
        self.waiting = Waiting::Mission(id);
        self.answer_deadline = self.answer_limit.map_or(Timestamp::MAX, |limit| now + limit);
    }

    fn open_window(&mut self) {
        if let Some(robot) = &mut self.robot {
            robot.rest.open();
        }
    }

    fn close_window(&mut self) -> Option<Window> {
        self.robot.as_mut()?.rest.close()
    }

    fn end_residual(&mut self, now: Timestamp) {
        let Some(window) = self.close_window() else {
            self.end_here(now, Outcome::Failed, "no gyro sample came at rest");
            return;
        };
        let Some(robot) = &self.robot else { return };
        let test = robot.bias_test;
        let table = window
            .temperature
            .and_then(|t: Temperature| robot.calibration.table_bias(t))
            .map(|bias| bias.deg_per_s());
        self.observe(now, |collector| {
            let test = test.as_ref().map(|(at, result)| (result, (now - *at).as_secs_f64()));
            collector.bias_residual(&window, test, table);
        });
    }

    fn fit(&mut self, now: Timestamp, step: &Fit) {
        match fit::fit(step, self.observations.of(step.quantity.as_str())) {
            Ok(fitted) => {
                let (name, note) = (step.name.as_str().to_owned(), fitted.to_string());
                self.record(RecordKind::Note(format!("fit {name}: {note}")));
                if let Some(robot) = &mut self.robot {
                    robot.fits.insert(name, fitted);
                }
            }
            Err(why) => {
                self.end_here(now, Outcome::Failed, &why);
            }
        }
    }

    fn save_calibration(&mut self, now: Timestamp, step: &SaveCalibration) {
        let Some(robot) = &mut self.robot else { return };
        let fits = step.from.iter().filter_map(|name| robot.fits.get(name.as_str()));
        match fit::calibration(fits) {
            Ok(calibration) => {
                let name = step.name.as_str().to_owned();
                robot.calibrations.insert(name.clone(), calibration.clone());
                self.actions.push_back(Action::SaveCalibration {
                    name,
                    calibration: Box::new(calibration),
                });
            }
            Err(why) => {
                self.end_here(now, Outcome::Failed, &why);
            }
        }
    }
}
