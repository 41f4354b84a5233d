//! Runs a plan: steps in, missions and actions out, reports and answers back in.
//!
//! The engine does no IO and reads no clock, so that the simulated and the live world run the same
//! one. Its owner calls [`Engine::wake`] whenever [`Engine::next_wakeup`] is due, hands it every
//! report and answer, and carries out every [`Action`] until there are none. Whatever happens, the
//! engine ends with the base told to stop ([`teardown`]).

mod action;
mod observe;
mod op;
mod program;
mod teardown;

pub use action::Action;
pub use observe::Uncertainties;

use crate::observation::Observation;
use crate::outcome::Outcome;
use crate::plan::Plan;
use crate::record::{Device, RecordKind};
use controller::calibration::Calibration;
use controller::mission::{
    BiasTestResult, Command, HeadingSource, Mission, MissionId, MissionResult, Report, State,
};
use observe::{Collector, Ends, Tags};
use op::Op;
use program::Program;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use teardown::Teardown;
use wire::base::HEADING_STEP;
use wire::table;
use wire::time::{Span, Timestamp};
use wire::units::Pose;

/// Between two questions to a table that turns.
const TABLE_POLL: Span = Span::from_millis(100);
/// Stream quantities are kept at most this many times each; a plan that makes more is cut off there,
/// and says so. 16 hours of 1 Hz are 57,600; a lap's heading errors are 2,500.
pub const STREAM_OBSERVATIONS_MAX: usize = 2_000_000;

/// How a run ended, and why if it did not simply end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ending {
    /// `Passed` here means that every step was carried out; the checks come after.
    pub outcome: Outcome,
    /// One sentence.
    pub reason: Option<String>,
}

#[derive(Debug, Clone, PartialEq)]
enum Waiting {
    /// Nothing: the next operation can begin.
    Nothing,
    /// The controller's answer to this mission.
    Mission(MissionId),
    /// This instant.
    Until(Timestamp),
    /// The absolute measurement; true: before, false: after.
    Absolute { before: bool },
    /// The world's confirmation.
    Answer,
    /// The table's word on a command.
    TableWord,
    /// The table's state, asked again at this instant while it turns.
    TableRest { ask_at: Timestamp },
}

/// Runs one plan once.
#[derive(Debug)]
pub struct Engine {
    plan: Arc<Plan>,
    program: Program,
    ops: VecDeque<Op>,
    waiting: Waiting,
    step_deadline: Timestamp,
    plan_deadline: Timestamp,
    began: Timestamp,
    next_id: MissionId,
    state: Option<State>,
    ends: Ends,
    bias_test: Option<BiasTestResult>,
    heading_source: HeadingSource,
    tags: Tags,
    /// Quantities that a measurement or a fit of the plan asks for.
    wanted: BTreeSet<String>,
    observations: BTreeMap<String, Vec<Observation>>,
    calibrations: BTreeMap<String, Calibration>,
    fits: BTreeMap<String, program::Fit>,
    uncertainties: Uncertainties,
    teardown: Option<Teardown>,
    ending: Option<Ending>,
    actions: VecDeque<Action>,
}

impl Engine {
    /// An engine that begins `plan` at `now`. `calibrations` are those that the plan names;
    /// `uncertainties` those of the bench's measuring devices.
    pub fn new(
        plan: Arc<Plan>,
        calibrations: BTreeMap<String, Calibration>,
        uncertainties: Uncertainties,
        now: Timestamp,
    ) -> Self {
        let plan_deadline = now + plan.time_limit();
        Self {
            program: Program::new(Arc::clone(&plan)),
            wanted: plan.wanted_quantities(),
            plan,
            ops: VecDeque::new(),
            waiting: Waiting::Nothing,
            step_deadline: Timestamp::MAX,
            plan_deadline,
            began: now,
            next_id: 1,
            state: None,
            ends: Ends::default(),
            bias_test: None,
            heading_source: HeadingSource::default(),
            tags: Tags::new(),
            observations: BTreeMap::new(),
            calibrations,
            fits: BTreeMap::new(),
            uncertainties,
            teardown: None,
            ending: None,
            actions: VecDeque::new(),
        }
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What has been observed, by quantity.
    pub const fn observations(&self) -> &BTreeMap<String, Vec<Observation>> {
        &self.observations
    }

    /// How it ended; `None` while it runs.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref().filter(|_| self.teardown.is_none())
    }

    /// Steps done and steps in all, as far as they can be told.
    pub fn progress(&self) -> (u64, u64) {
        self.program.progress()
    }

    /// The next thing to be done by the world.
    pub fn action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// When [`Self::wake`] has something to do, if nothing arrives before.
    pub fn next_wakeup(&self) -> Timestamp {
        if let Some(teardown) = &self.teardown {
            return teardown.next_wakeup();
        }
        if self.ending.is_some() {
            return Timestamp::MAX;
        }
        let due = match self.waiting {
            Waiting::Nothing => Timestamp::ZERO,
            Waiting::Until(at) | Waiting::TableRest { ask_at: at } => at,
            Waiting::Mission(_) | Waiting::Absolute { .. } | Waiting::Answer | Waiting::TableWord => {
                Timestamp::MAX
            }
        };
        due.min(self.step_deadline).min(self.plan_deadline)
    }

    /// Does what is due `now`.
    pub fn wake(&mut self, now: Timestamp) {
        if self.teardown.is_some() {
            self.step_teardown(now);
            return;
        }
        if self.ending.is_some() {
            return;
        }
        match self.waiting {
            Waiting::Until(at) if now >= at => self.waiting = Waiting::Nothing,
            Waiting::TableRest { ask_at } if now >= ask_at => {
                self.actions.push_back(Action::Table(table::Command::State));
                self.waiting = Waiting::TableRest { ask_at: now + TABLE_POLL };
            }
            _ => {}
        }
        // An operation that is done in time has not missed its limit.
        self.advance(now);
        if self.ending.is_none() && now >= self.step_deadline {
            let step = self.program.place();
            self.end(now, Outcome::Timeout, Some(format!("{step} took longer than its limit")));
        } else if self.ending.is_none() && now >= self.plan_deadline {
            self.end(now, Outcome::Timeout, Some("the plan took longer than its limit".to_owned()));
        }
    }

    /// Stops the run: somebody asked for it.
    pub fn abort(&mut self, now: Timestamp) {
        if self.ending.is_none() {
            self.end(now, Outcome::Aborted, Some("stopped by request".to_owned()));
        }
    }

    /// The world could not do what was asked, or lost what it needs.
    pub fn broke(&mut self, now: Timestamp, why: &str) {
        if self.ending.is_none() {
            self.end(now, Outcome::Error, Some(why.to_owned()));
        }
    }

    /// Takes a report of the controller.
    pub fn report(&mut self, now: Timestamp, report: &Report) {
        if let Some(teardown) = &mut self.teardown {
            teardown.report(report);
            self.step_teardown(now);
            return;
        }
        match report {
            Report::State(state) => self.take_state(now, state),
            Report::Health(_) => {}
            Report::Done { id, result } if self.waiting == Waiting::Mission(*id) => {
                self.take_result(now, result);
                self.waiting = Waiting::Nothing;
                self.advance(now);
            }
            Report::Refused { id, reason } if self.waiting == Waiting::Mission(*id) => {
                let reason = format!("{}: the controller refused: {}", self.program.place(), words(reason));
                self.end(now, Outcome::Failed, Some(reason));
            }
            Report::Aborted { id, reason } if self.waiting == Waiting::Mission(*id) => {
                let reason = format!("{}: the controller broke off: {}", self.program.place(), words(reason));
                self.end(now, Outcome::Failed, Some(reason));
            }
            // An answer to a mission that nobody waits for any more.
            Report::Done { .. } | Report::Refused { .. } | Report::Aborted { .. } => {}
        }
    }

    /// Takes the table's answer.
    pub fn table(&mut self, now: Timestamp, answer: table::Answer) {
        match (&self.waiting, answer) {
            (Waiting::TableWord, table::Answer::Accepted(_)) => self.waiting = Waiting::Nothing,
            (Waiting::TableRest { .. }, table::Answer::State { moving: false, .. }) => {
                self.waiting = Waiting::Nothing;
            }
            (Waiting::TableWord | Waiting::TableRest { .. }, table::Answer::Refused(_)) => {
                let reason = format!("{}: the table refused a command", self.program.place());
                self.end(now, Outcome::Error, Some(reason));
            }
            _ => {}
        }
        self.advance(now);
    }

    /// Takes what the absolute measurement found.
    pub fn absolute(&mut self, now: Timestamp, pose: Pose) {
        if let Waiting::Absolute { before } = self.waiting {
            let end = if before { &mut self.ends.pose_before } else { &mut self.ends.pose_after };
            *end = Some(pose);
            self.waiting = Waiting::Nothing;
            self.advance(now);
        }
    }

    /// Takes the world's confirmation of a `Place`, `SetParameter` or `Prompt`.
    pub fn answered(&mut self, now: Timestamp) {
        if self.waiting == Waiting::Answer {
            self.waiting = Waiting::Nothing;
            self.advance(now);
        }
    }

    /// Begins operations until one has to be waited for.
    fn advance(&mut self, now: Timestamp) {
        while self.waiting == Waiting::Nothing && self.ending.is_none() {
            match self.ops.pop_front() {
                Some(op) => self.begin(now, op),
                None => self.next_step(now),
            }
        }
    }

    fn begin(&mut self, now: Timestamp, op: Op) {
        match op {
            Op::Mission(command) => self.send(command),
            Op::StateBefore => {
                self.ends.state_before = None;
                self.send(Command::RequestState);
            }
            Op::StateAfter => {
                self.ends.state_after = None;
                self.send(Command::RequestState);
            }
            Op::AbsoluteBefore | Op::AbsoluteAfter => {
                self.actions.push_back(Action::MeasureAbsolute);
                self.waiting = Waiting::Absolute { before: op == Op::AbsoluteBefore };
            }
            Op::SetMeasuredPose => match self.ends.pose_before {
                Some(pose) => self.send(Command::SetPose(pose)),
                None => self.broke(now, "no pose has been measured that could be set"),
            },
            Op::Pause(span) => self.waiting = Waiting::Until(now + span),
            Op::PauseUntil(at) => self.waiting = Waiting::Until(at),
            Op::Table(command) => {
                self.actions.push_back(Action::Table(command));
                self.waiting = Waiting::TableWord;
            }
            Op::TableAtRest => {
                self.actions.push_back(Action::Table(table::Command::State));
                self.waiting = Waiting::TableRest { ask_at: now + TABLE_POLL };
            }
            Op::ObserveLap(direction) => {
                let (ends, uncertainties) = (self.ends, self.uncertainties);
                self.observe(now, |collector| collector.lap(&ends, direction, &uncertainties));
            }
            Op::ObserveTableTurn { angle_deg } => {
                let (ends, uncertainties) = (self.ends, self.uncertainties);
                self.observe(now, |collector| collector.table_turn(&ends, angle_deg, &uncertainties));
            }
            Op::Place(pose) => {
                self.actions.push_back(Action::Place(pose));
                self.waiting = Waiting::Answer;
            }
            Op::SetParameter { device, parameter, value } => {
                self.actions.push_back(Action::SetParameter { device, parameter, value });
                self.waiting = Waiting::Answer;
            }
            Op::Prompt(text) => {
                self.actions.push_back(Action::Prompt(text));
                self.waiting = Waiting::Answer;
            }
        }
    }

    fn send(&mut self, command: Command) {
        let id = self.next_id;
        self.next_id = self.next_id.wrapping_add(1);
        if let Command::SetHeadingSource(source) = command {
            self.heading_source = source;
        }
        let record = RecordKind::Command(command.clone());
        self.actions.push_back(Action::Record(Device::Plan, record));
        self.actions.push_back(Action::Mission(Mission { id, command }));
        self.waiting = Waiting::Mission(id);
    }

    fn take_state(&mut self, now: Timestamp, state: &State) {
        self.state = Some(*state);
        if self.ends.state_before.is_none() {
            self.ends.state_before = Some(*state);
        }
        if self.ends.state_after.is_none() {
            self.ends.state_after = Some(*state);
        }
        match state.heading_error {
            Some(error) if self.wants("controller.heading_error") => {
                self.observe(now, |collector| collector.heading_error(error));
            }
            None if !state.moving && (self.wants("gyro.rate") || self.wants("gyro.temperature")) => {
                self.observe(now, |collector| collector.log(state));
            }
            _ => {}
        }
    }

    fn take_result(&mut self, now: Timestamp, result: &MissionResult) {
        // By the gyro the resolution is far below its drift in a few seconds; by the odometry it is a
        // step of 0.3 deg (uniform).
        let heading_u_deg = match self.heading_source {
            HeadingSource::Gyro => 0.0,
            HeadingSource::Odometry => HEADING_STEP.deg() / 12f64.sqrt(),
        };
        match result {
            MissionResult::BiasTest(result) => {
                let before = self.bias_test.replace(*result);
                self.observe(now, |collector| collector.bias_test(result, before.as_ref()));
            }
            MissionResult::Straight(result) => {
                self.observe(now, |collector| collector.straight(result, heading_u_deg));
            }
            MissionResult::Turn(result) => {
                self.observe(now, |collector| collector.turn(result, heading_u_deg));
            }
            MissionResult::Applied => {}
        }
    }

    fn wants(&self, quantity: &str) -> bool {
        self.wanted.contains(quantity)
    }

    /// Keeps the observations that the plan asks for, and records them.
    fn observe(&mut self, now: Timestamp, make: impl FnOnce(&mut Collector<'_>)) {
        let elapsed = now - self.began;
        self.tags.insert("time".to_owned(), elapsed.as_secs_f64());
        let mut collector = Collector::new(&self.tags);
        make(&mut collector);
        for observation in collector.out {
            if !self.wanted.contains(&observation.quantity) {
                continue;
            }
            let kept = self.observations.entry(observation.quantity.clone()).or_default();
            if kept.len() < STREAM_OBSERVATIONS_MAX {
                kept.push(observation.clone());
                let record = RecordKind::Observation(observation);
                self.actions.push_back(Action::Record(Device::Plan, record));
            }
        }
    }

    fn end(&mut self, now: Timestamp, outcome: Outcome, reason: Option<String>) {
        if let Some(reason) = &reason {
            let note = RecordKind::Note(reason.clone());
            self.actions.push_back(Action::Record(Device::Plan, note));
        }
        self.ending = Some(Ending { outcome, reason });
        self.teardown = Some(Teardown::begin(now));
        self.step_teardown(now);
    }

    fn step_teardown(&mut self, now: Timestamp) {
        let Some(teardown) = &mut self.teardown else { return };
        let done = teardown.step(now, &mut self.next_id, &mut self.actions);
        if !done {
            return;
        }
        let at_rest = teardown.at_rest();
        self.teardown = None;
        if !at_rest && let Some(ending) = &mut self.ending {
            ending.outcome = ending.outcome.max(Outcome::Error);
            let reason = ending.reason.get_or_insert_default();
            if !reason.is_empty() {
                reason.push_str("; ");
            }
            reason.push_str("the controller never confirmed that the base stands still");
        }
    }
}

/// An enumerator of the mission protocol as it stands in JSON, with spaces for underscores.
fn words(reason: &impl serde::Serialize) -> String {
    serde_json::to_value(reason)
        .ok()
        .and_then(|value| value.as_str().map(|text| text.replace('_', " ")))
        .unwrap_or_default()
}
