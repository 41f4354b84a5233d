//! Runs a plan: steps in, missions and actions out, reports and answers back in.
//!
//! The engine does no IO and reads no clock, so that the simulated and the live world run the same
//! one. Its owner calls [`Engine::wake`] whenever [`Engine::next_wakeup`] is due, hands it every
//! report and answer, and carries out every [`Action`] until there are none. Whatever happens, the
//! engine ends with the base told to stop, and waits until it stands.

mod action;
mod execute;
mod fit;
mod gathered;
mod identify;
pub mod observe;
mod op;
mod phases;
pub mod program;
mod rest_watch;
mod signals;
mod teardown;

pub use action::Action;

use crate::observation::Observation;
use crate::outcome::Outcome;
use crate::plan::{Action as StepAction, Answer, Condition, Plan, Speaker, Step, quantities as q};
use crate::record::{Device, RecordKind};
use controller::calibration::Calibration;
use controller::health::Level;
use controller::mission::{BiasTestResult, HeadingSource, MissionId, MissionResult, Report, State};
use fit::Fitted;
use identification::model::Model;
use observe::{Collector, Ends, Tags};
use op::Op;
use phases::Phases;
use program::Program;
use rest_watch::RestWatch;
use signals::Signals;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use teardown::Teardown;
use wire::base::HEADING_STEP;
use wire::table;
use wire::time::{Span, Timestamp};
use wire::units::{Angle, Pose};

/// A quantity is kept at most this often; a plan that makes more of one is cut off there, and the
/// record says so. 16 hours of 1 Hz are 57,600; the heading errors of 80 laps 130,000.
pub const OBSERVATIONS_MAX: usize = 1_000_000;
/// The first mission's number; the others follow in the order in which they are recorded.
pub(crate) const FIRST_MISSION: MissionId = 1;

/// What is said of a run after whose end nobody could see the base at rest.
const NO_REST: &str = "the controller never confirmed that the base stands still";

/// What the engine must know of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BenchFacts {
    /// Standard uncertainty of a position by the absolute measurement, m.
    pub absolute_position_u_m: f64,
    /// Standard uncertainty of a heading by the absolute measurement, deg.
    pub absolute_heading_u_deg: f64,
    /// Standard uncertainty of the table's angle at rest, deg.
    pub table_u_deg: f64,
    /// What one step of the table's motor turns the table by.
    pub table_step: Angle,
}

/// How a run ended, and why if it did not simply end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ending {
    /// `Passed` here means that every step was carried out; the checks come after.
    pub outcome: Outcome,
    /// One sentence.
    pub reason: Option<String>,
}

/// What the engine waits for.
#[derive(Debug, Clone, PartialEq)]
enum Waiting {
    /// Nothing: the next operation can begin.
    Nothing,
    /// The controller's answer to this mission.
    Mission(MissionId),
    /// This instant.
    Until(Timestamp),
    /// The end of a log, and of its interval.
    Log { until: Timestamp, interval: Span, due: Timestamp },
    /// The end of a window at rest.
    Residual(Timestamp),
    /// The step's condition.
    Condition,
    /// A state in which nothing moves.
    Rest,
    /// The absolute measurement.
    Absolute(op::Op),
    /// The world's confirmation, and a number if one is asked for.
    Answer(Option<Answer>),
    /// The table's word on a command.
    TableWord,
    /// The table's state, asked again at this instant while it turns.
    TableRest { ask_at: Timestamp },
}

/// Runs one plan once.
#[derive(Debug)]
pub struct Engine {
    plan: Arc<Plan>,
    facts: BenchFacts,
    program: Program,
    ops: VecDeque<Op>,
    waiting: Waiting,
    /// The step that is under way, since when, and until when at most.
    step: Option<(StepAction, Timestamp)>,
    step_deadline: Timestamp,
    plan_deadline: Timestamp,
    began: Timestamp,
    next_id: MissionId,
    state: Option<State>,
    ends: Ends,
    /// Sum of the angles that the table was told to turn by.
    table_heading: Angle,
    rest: RestWatch,
    /// What nodes said.
    signals: Signals,
    /// A controller is there that takes missions: it has to be heard before the first step, and brings the base to rest at
    /// the end.
    has_controller: bool,
    /// Other nodes that are under test.
    under_test: Vec<String>,
    bias_test: Option<(Timestamp, BiasTestResult)>,
    calibration: Calibration,
    heading_source: HeadingSource,
    tags: Tags,
    /// Rounds of the innermost repeats and sweeps begun, and whether one has begun since the last step.
    rounds: u64,
    round_begun: bool,
    /// Quantities that a measurement or a fit of the plan asks for.
    wanted: BTreeSet<String>,
    observations: BTreeMap<String, Vec<Observation>>,
    calibrations: BTreeMap<String, Calibration>,
    /// Since when the calibration is in force.
    calibration_since: Timestamp,
    /// Models that can be used by name, and the one in force.
    models: BTreeMap<String, Model>,
    model: Option<Model>,
    fits: BTreeMap<String, Fitted>,
    times_degraded: u32,
    times_fault: u32,
    level: Level,
    teardown: Option<Teardown>,
    ending: Option<Ending>,
    actions: VecDeque<Action>,
    phases: Phases,
}

impl Engine {
    /// An engine that begins `plan` at `now`. `calibrations` are those that can be used by name.
    pub fn new(
        plan: Arc<Plan>,
        calibrations: BTreeMap<String, Calibration>,
        facts: BenchFacts,
        now: Timestamp,
    ) -> Self {
        let plan_deadline = now + plan.time_limit();
        Self {
            program: Program::new(Arc::clone(&plan), now, plan_deadline),
            wanted: wanted(&plan),
            phases: Phases::new(!plan.faults.is_empty()),
            plan,
            facts,
            ops: VecDeque::new(),
            waiting: Waiting::Nothing,
            step: None,
            step_deadline: Timestamp::MAX,
            plan_deadline,
            began: now,
            next_id: FIRST_MISSION,
            state: None,
            ends: Ends::default(),
            table_heading: Angle::ZERO,
            rest: RestWatch::default(),
            signals: Signals::default(),
            has_controller: true,
            under_test: Vec::new(),
            bias_test: None,
            calibration: Calibration::default(),
            heading_source: HeadingSource::default(),
            tags: Tags::new(),
            rounds: 0,
            round_begun: false,
            observations: BTreeMap::new(),
            calibrations,
            calibration_since: now,
            models: BTreeMap::new(),
            model: None,
            fits: BTreeMap::new(),
            times_degraded: 0,
            times_fault: 0,
            level: Level::Starting,
            teardown: None,
            ending: None,
            actions: VecDeque::new(),
        }
    }

    /// With what these speakers say.
    #[must_use]
    pub fn hearing(mut self, speakers: &[Speaker]) -> Self {
        self.signals = Signals::of(&self.plan, speakers);
        self
    }

    /// Of a rig in which nobody takes missions; these nodes are under test.
    #[must_use]
    pub fn without_controller(mut self, under_test: Vec<String>) -> Self {
        self.has_controller = false;
        self.under_test = under_test;
        self
    }

    /// A node under test is gone: it did not do what it should, and nothing broke but itself.
    pub fn lost_node(&mut self, now: Timestamp, node: &str, how: &str) {
        self.end(now, Outcome::Failed, Some(format!("`{node}` is under test and ended: {how}")));
    }

    /// With identified models that can be used by name.
    #[must_use]
    pub fn with_models(mut self, models: BTreeMap<String, Model>) -> Self {
        self.models = models;
        self
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What has been observed, by quantity.
    pub const fn observations(&self) -> &BTreeMap<String, Vec<Observation>> {
        &self.observations
    }

    /// The last state that the controller reported.
    pub const fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// How it ended; `None` while it runs.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref().filter(|_| self.teardown.is_none())
    }

    /// It has come to an end, though the base may not have been stopped yet.
    pub const fn is_ending(&self) -> bool {
        self.ending.is_some()
    }

    /// Steps done and steps in all, repetitions counted.
    pub const fn progress(&self) -> (u64, u64) {
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
            // The first step waits for the controller to be heard; see `report`.
            Waiting::Nothing if self.state.is_some() || !self.has_controller => Timestamp::ZERO,
            Waiting::Until(at) | Waiting::Residual(at) | Waiting::TableRest { ask_at: at } => at,
            Waiting::Log { until, due, .. } => until.min(due),
            _ => Timestamp::MAX,
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
        self.pass_time(now);
        // What is done in time has not missed its limit.
        self.advance(now);
        if self.ending.is_some() {
            return;
        }
        if now >= self.plan_deadline {
            self.end(now, Outcome::Timeout, Some("the plan took longer than its limit".to_owned()));
        } else if now >= self.step_deadline {
            let why = match self.waiting {
                Waiting::Rest => ": the controller does not report rest",
                _ => "",
            };
            let reason = format!("{} took longer than its limit{why}", self.place());
            // What a node under test does not do in time, it does not do.
            let awaited = self.waiting == Waiting::Condition && !self.under_test.is_empty();
            let outcome = if awaited { Outcome::Failed } else { Outcome::Timeout };
            self.end(now, outcome, Some(reason));
        }
    }

    /// Stops the run: somebody asked for it.
    pub fn abort(&mut self, now: Timestamp) {
        self.end(now, Outcome::Aborted, Some("stopped by request".to_owned()));
    }

    /// The world could not do what was asked, or lost what it needs.
    pub fn broke(&mut self, now: Timestamp, why: &str) {
        self.end(now, Outcome::Error, Some(why.to_owned()));
    }

    /// The controller is gone: nothing can be confirmed any more, and nobody is left to stop the base
    /// but its own command time-out.
    pub fn lost_controller(&mut self, now: Timestamp, how: &str) {
        self.broke(now, &format!("lost the device under test: {how}"));
        self.teardown = None;
    }

    /// Takes a report of the controller.
    pub fn report(&mut self, now: Timestamp, report: &Report) {
        if let Some(teardown) = &mut self.teardown {
            teardown.report(now, report);
            self.step_teardown(now);
            return;
        }
        match report {
            Report::State(state) => self.take_state(now, state),
            Report::Health(health) => {
                self.times_degraded +=
                    u32::from(health.level >= Level::Degraded && self.level < Level::Degraded);
                self.times_fault +=
                    u32::from(health.level == Level::Fault && self.level < Level::Fault);
                self.level = health.level;
            }
            Report::Done { id, result } if self.waiting == Waiting::Mission(*id) => {
                self.phases.mission_ended(&mut self.actions);
                self.take_result(now, result);
                self.waiting = Waiting::Nothing;
                self.advance(now);
            }
            Report::Refused { id, reason } if self.waiting == Waiting::Mission(*id) => {
                let reason = format!("{}: the controller refused: {}", self.place(), words(reason));
                self.end(now, Outcome::Failed, Some(reason));
            }
            Report::Aborted { id, reason } if self.waiting == Waiting::Mission(*id) => {
                let reason =
                    format!("{}: the controller broke off: {}", self.place(), words(reason));
                self.end(now, Outcome::Failed, Some(reason));
            }
            // An answer to a mission that nobody waits for any more.
            Report::Done { .. } | Report::Refused { .. } | Report::Aborted { .. } => {}
        }
    }

    /// Takes a message: its speaker and its place in that one's layout, and the values of its signals as far as it carries
    /// them.
    pub fn message(&mut self, now: Timestamp, which: (usize, usize), values: &[Option<f64>]) {
        if self.ending.is_some() {
            return;
        }
        let brought = self.signals.take(now, which, values);
        if !brought.is_empty() {
            self.observe(now, |collector| {
                for (name, value) in &brought {
                    collector.add_named(name, *value, 0.0, &[]);
                }
            });
        }
        if self.ends_wait() {
            self.advance(now);
        }
    }

    /// The condition that is waited for holds, so that nothing is waited for any more.
    fn ends_wait(&mut self) -> bool {
        let holds = self.waiting == Waiting::Condition
            && matches!(&self.step, Some((StepAction::WaitUntil(condition), _))
                if holds(&self.signals, &self.rest, condition));
        if holds {
            self.waiting = Waiting::Nothing;
        }
        holds
    }

    /// Takes the table's answer.
    pub fn table(&mut self, now: Timestamp, answer: table::Answer) {
        match (&self.waiting, answer) {
            (Waiting::TableWord, table::Answer::Done(_))
            | (Waiting::TableRest { .. }, table::Answer::State { moving: false, .. }) => {
                self.waiting = Waiting::Nothing;
            }
            (Waiting::TableWord | Waiting::TableRest { .. }, table::Answer::Refused(_)) => {
                let reason = format!("{}: the table refused a command", self.place());
                self.end(now, Outcome::Error, Some(reason));
            }
            _ => {}
        }
        self.advance(now);
    }

    /// Takes what the absolute measurement found.
    pub fn absolute(&mut self, now: Timestamp, pose: Pose) {
        let Waiting::Absolute(op) = &self.waiting else { return };
        match op {
            Op::AbsoluteBefore => self.ends.pose_before = Some(pose),
            Op::AbsoluteAfter => self.ends.pose_after = Some(pose),
            _ => {
                let facts = self.facts;
                self.observe(now, |collector| collector.pose(&pose, &facts));
            }
        }
        self.waiting = Waiting::Nothing;
        self.advance(now);
    }

    /// Takes the world's confirmation that something is done.
    pub fn answered(&mut self, now: Timestamp) {
        if self.waiting == Waiting::Answer(None) {
            self.waiting = Waiting::Nothing;
            self.advance(now);
        }
    }

    /// Takes the number that a person was asked for; one out of range is asked for again by whoever
    /// asks, and refused here.
    pub fn answered_with(&mut self, now: Timestamp, value: f64) {
        let Waiting::Answer(Some(answer)) = &self.waiting else { return };
        let answer = answer.clone();
        if !answer.range.contains(value) {
            let (name, range, unit) = (&answer.name, answer.range, &answer.unit);
            let why = format!("the answer {name} = {value} {unit} is not in {range}");
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

    fn place(&self) -> String {
        match &self.step {
            Some((action, _)) => format!("{} ({action})", self.program.place()),
            None => self.program.place(),
        }
    }

    fn take_state(&mut self, now: Timestamp, state: &State) {
        let first = self.state.replace(*state).is_none();
        self.ends.take(now, state);
        self.rest.take(now, state);
        if let Some(error) = state.heading_error
            && self.wanted.contains(q::STRAIGHT_HEADING_ERROR.name)
        {
            self.observe(now, |collector| {
                collector.add(&q::STRAIGHT_HEADING_ERROR, -error.deg(), 0.0, &[]);
            });
        }
        self.ends_wait();
        if self.waiting == Waiting::Rest && !state.moving {
            self.waiting = Waiting::Nothing;
        }
        if first || self.waiting == Waiting::Nothing {
            self.advance(now);
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
                self.bias_test = Some((now, *result));
                self.observe(now, |collector| collector.bias_test(result));
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

    /// Keeps the observations that the plan asks for, and records them.
    fn observe(&mut self, now: Timestamp, make: impl FnOnce(&mut Collector<'_>)) {
        self.tags.insert("time".to_owned(), (now - self.began).as_secs_f64());
        let mut collector = Collector::new(&self.tags);
        make(&mut collector);
        for observation in collector.out {
            if !self.wanted.contains(&observation.quantity) {
                continue;
            }
            let kept = self.observations.entry(observation.quantity.clone()).or_default();
            if kept.len() == OBSERVATIONS_MAX {
                let note = format!("more than {OBSERVATIONS_MAX} of {}", observation.quantity);
                self.end(now, Outcome::Error, Some(note));
                return;
            }
            kept.push(observation.clone());
            let record = RecordKind::Observation(observation);
            self.actions.push_back(Action::Record(Device::Plan, record));
        }
    }

    fn end(&mut self, now: Timestamp, outcome: Outcome, reason: Option<String>) {
        if self.ending.is_some() {
            return;
        }
        if let Some(reason) = &reason {
            let note = RecordKind::Note(reason.clone());
            self.actions.push_back(Action::Record(Device::Plan, note));
        }
        self.ending = Some(Ending { outcome, reason });
        self.observe_whole_run(now);
        self.ops.clear();
        self.phases.all_ended(&mut self.actions);
        // What is sent last is what the plan says.
        self.actions.extend(self.plan.finally.iter().cloned().map(Action::Send));
        if !self.has_controller {
            // Nobody would confirm that anything stands still.
            return;
        }
        self.teardown = Some(Teardown::begin(now));
        self.step_teardown(now);
    }

    /// What is known of the run as a whole.
    fn observe_whole_run(&mut self, now: Timestamp) {
        let (degraded, fault) = (self.times_degraded, self.times_fault);
        let state = self.state;
        self.observe(now, |collector| {
            collector.add(&q::HEALTH_DEGRADED, f64::from(degraded), 0.0, &[]);
            collector.add(&q::HEALTH_FAULT, f64::from(fault), 0.0, &[]);
            let Some(state) = state else { return };
            collector.add(&q::SAMPLES_USED, state.samples as f64, 0.0, &[]);
            collector.add(&q::SAMPLES_LOST, state.samples_lost as f64, 0.0, &[]);
            let overflows = f64::from(u8::from(state.health.causes.overflow));
            collector.add(&q::QUEUE_OVERFLOWS, overflows, 0.0, &[]);
            if let Some(ratio) = state.clock_ratio {
                collector.add(&q::CLOCK_RATIO, ratio, 0.0, &[]);
            }
        });
    }

    fn step_teardown(&mut self, now: Timestamp) {
        let Some(teardown) = &mut self.teardown else { return };
        if !teardown.step(now, &mut self.next_id, &mut self.actions) {
            return;
        }
        let at_rest = teardown.at_rest();
        self.teardown = None;
        if !at_rest && let Some(ending) = &mut self.ending {
            // A failure or a time-out says more than that the bench fell silent afterwards.
            if ending.outcome == Outcome::Passed {
                ending.outcome = Outcome::Error;
            }
            self.actions
                .push_back(Action::Record(Device::Plan, RecordKind::Note(NO_REST.to_owned())));
            ending.reason = Some(match ending.reason.take() {
                Some(reason) => format!("{reason}; {NO_REST}"),
                None => NO_REST.to_owned(),
            });
        }
    }
}

/// Does this hold by what was heard last: in messages of nodes, or from the controller?
fn holds(signals: &Signals, rest: &RestWatch, condition: &Condition) -> bool {
    match condition.quantity().of_message() {
        Some(_) => signals.holds(condition),
        None => rest.holds(condition),
    }
}

/// Quantities that the plan judges, fits or identifies from, and those of turns and laps: a later
/// identification reads them whatever the plan makes of them.
fn wanted(plan: &Plan) -> BTreeSet<String> {
    fn fitted(steps: &[Step], names: &mut BTreeSet<String>) {
        for step in steps {
            if let StepAction::Fit(fit) = &step.action {
                names.insert(fit.quantity.as_str().to_owned());
            }
            fitted(step.action.steps(), names);
        }
    }
    let by_turn_or_lap = |made_by| matches!(made_by, "table_turn" | "lap");
    let always = q::QUANTITIES.iter().filter(|quantity| by_turn_or_lap(quantity.made_by));
    let mut names: BTreeSet<String> = always.map(|quantity| quantity.name.to_owned()).collect();
    for declared in &plan.measurements {
        names.insert(declared.quantity.as_str().to_owned());
        names.extend(declared.check.second_quantity().map(|(_, name)| name.as_str().to_owned()));
    }
    fitted(&plan.steps, &mut names);
    identify::needed(&plan.steps, &mut names);
    names
}

/// An enumerator of the mission protocol as it stands in JSON, with spaces for underscores.
fn words(reason: &impl serde::Serialize) -> String {
    serde_json::to_value(reason)
        .ok()
        .and_then(|value| value.as_str().map(|text| text.replace('_', " ")))
        .unwrap_or_default()
}
