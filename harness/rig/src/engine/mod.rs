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
mod of_nodes;
mod phases;
pub mod program;
mod reactions;
mod rest_watch;
mod robot;
mod segment;
mod signals;
mod teardown;

pub use action::Action;
pub use segment::Look;

use controller::mission::MissionId;
use described::Decoded;
use execute::holds;
use identification::model::Model;
use observe::{Collector, Tags};
use phases::Phases;
use plan::observation::Observations;
use plan::{
    Action as StepAction, Answer, Condition, Op, Order, Plan, QuantityName, Segment, Speaker,
    quantities as q,
};
use program::Program;
use reactions::Reactions;
use record::outcome::Outcome;
use record::{Device, RecordKind};
use robot::Robot;
use signals::Signals;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use wire::time::{Span, Timestamp};

pub use robot::BenchFacts;
pub use robot::FIRST_MISSION;

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
    /// This condition.
    Condition(Condition),
    /// The step's reaction.
    Reaction,
    /// A state in which nothing moves.
    Rest,
    /// The absolute measurement.
    Absolute(Op),
    /// A look at the base.
    Look(Option<Segment>),
    /// The world's confirmation, and a number if one is asked for.
    Answer(Option<Answer>),
    /// The table's word on a command.
    TableWord,
    /// The table's state, asked again at this instant while it turns.
    TableRest { ask_at: Timestamp },
}

/// Runs one plan once.
#[derive(Debug, Clone)]
pub struct Engine {
    plan: Arc<Plan>,
    program: Program,
    ops: VecDeque<Op>,
    waiting: Waiting,
    /// The step that is under way, since when, and until when at most.
    step: Option<(StepAction, Timestamp)>,
    step_deadline: Timestamp,
    plan_deadline: Timestamp,
    began: Timestamp,
    /// What nodes said.
    signals: Signals,
    reactions: Reactions,
    /// What a robot adds: whoever takes missions has to be heard before the first step, and brings it to rest at the end. None
    /// where nobody takes missions.
    robot: Option<Box<Robot>>,
    /// Nodes that are under test, but for the robot's controller.
    under_test: Vec<String>,
    /// Models that can be used by name.
    models: BTreeMap<String, Model>,
    /// The signals off which errors are taken.
    corrected: BTreeSet<QuantityName>,
    tags: Tags,
    /// Rounds of the innermost repeats and sweeps begun, and whether one has begun since the last step.
    rounds: u64,
    round_begun: bool,
    /// Quantities that a measurement or a fit of the plan asks for.
    wanted: BTreeSet<String>,
    observations: Observations,
    ending: Option<Ending>,
    actions: VecDeque<Action>,
    phases: Phases,
}

impl Engine {
    /// An engine that begins `plan` at `now`, of a rig in which nobody takes missions.
    pub fn new(plan: Arc<Plan>, now: Timestamp) -> Self {
        let plan_deadline = now + plan.time_limit();
        Self {
            program: Program::new(Arc::clone(&plan), now, plan_deadline),
            wanted: identify::wanted(&plan),
            phases: Phases::new(!plan.faults.is_empty()),
            plan,
            ops: VecDeque::new(),
            waiting: Waiting::Nothing,
            step: None,
            step_deadline: Timestamp::MAX,
            plan_deadline,
            began: now,
            signals: Signals::default(),
            reactions: Reactions::default(),
            robot: None,
            under_test: Vec::new(),
            models: BTreeMap::new(),
            corrected: BTreeSet::new(),
            tags: Tags::new(),
            rounds: 0,
            round_begun: false,
            observations: Observations::default(),
            ending: None,
            actions: VecDeque::new(),
        }
    }

    /// With what these speakers say.
    #[must_use]
    pub fn hearing(mut self, speakers: &[Speaker]) -> Self {
        self.signals = Signals::of(&self.plan, speakers);
        self.reactions = Reactions::of(&self.plan, speakers);
        self
    }

    /// These nodes are under test: what they do not do in time, they do not do.
    #[must_use]
    pub fn awaiting(mut self, under_test: Vec<String>) -> Self {
        self.under_test = under_test;
        self
    }

    /// A node under test is gone: it did not do what it should, and nothing broke but itself.
    pub fn lost_node(&mut self, now: Timestamp, node: &str, how: &str) {
        self.end(now, Outcome::Failed, Some(format!("`{node}` is under test and ended: {how}")));
    }

    /// The device under test did what none may do.
    pub fn failed(&mut self, now: Timestamp, why: &str) {
        self.end(now, Outcome::Failed, Some(why.to_owned()));
    }

    /// Says when phases begin and end, though the plan has no faults that wait for them.
    pub const fn watch_phases(&mut self) {
        self.phases.watch();
    }

    /// Nothing has to be heard before the first step, or it has been.
    pub fn is_heard(&self) -> bool {
        self.robot.as_ref().is_none_or(|robot| robot.is_heard())
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What has been observed.
    pub const fn observations(&self) -> &Observations {
        &self.observations
    }

    /// The same, of a run that has ended.
    pub fn take_observations(&mut self) -> Observations {
        std::mem::take(&mut self.observations)
    }

    /// How it ended; `None` while it runs.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref().filter(|_| self.teardown().is_none())
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
        if let Some(teardown) = self.teardown() {
            return teardown.next_wakeup();
        }
        if self.ending.is_some() {
            return Timestamp::MAX;
        }
        let due = match self.waiting {
            // The first step waits for the controller to be heard; see `report`.
            Waiting::Nothing if self.is_heard() => Timestamp::ZERO,
            Waiting::Until(at) | Waiting::Residual(at) | Waiting::TableRest { ask_at: at } => at,
            Waiting::Log { until, due, .. } => until.min(due),
            _ => Timestamp::MAX,
        };
        due.min(self.step_deadline).min(self.plan_deadline)
    }

    /// Does what is due `now`.
    pub fn wake(&mut self, now: Timestamp) {
        if self.teardown().is_some() {
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
                Waiting::Reaction if self.reactions.is_asked() => {
                    ": what it waits for did not come"
                }
                Waiting::Reaction => ": nothing asked for it",
                _ => "",
            };
            let reason = format!("{} took longer than its limit{why}", self.place());
            // What a node under test does not do in time, it does not do.
            let awaited = matches!(self.waiting, Waiting::Condition(_) | Waiting::Reaction);
            let outcome = if awaited && !self.under_test.is_empty() {
                Outcome::Failed
            } else {
                Outcome::Timeout
            };
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

    /// Takes a message of a speaker.
    pub fn message(&mut self, now: Timestamp, speaker: usize, decoded: &Decoded<'_>) {
        if self.ending.is_some() {
            return;
        }
        let mut brought = self.signals.take(now, (speaker, decoded.message), decoded.values);
        brought.extend(self.reactions.take(now, speaker, decoded));
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
        let holds = match &self.waiting {
            Waiting::Condition(condition) => holds(&self.signals, self.robot.as_deref(), condition),
            Waiting::Reaction => self.reactions.has_come(),
            _ => false,
        };
        if holds {
            self.waiting = Waiting::Nothing;
        }
        holds
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

    /// Keeps the observations that the plan asks for, and records them.
    fn observe(&mut self, now: Timestamp, make: impl FnOnce(&mut Collector<'_>)) {
        self.tags.insert("time".to_owned(), (now - self.began).as_secs_f64());
        let mut collector = Collector::new(&self.tags);
        make(&mut collector);
        for observation in collector.out {
            if !self.wanted.contains(&observation.quantity) {
                continue;
            }
            if let Err(full) = self.observations.push(&observation) {
                self.end(now, Outcome::Error, Some(full.to_string()));
                return;
            }
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
        let last = self.plan.finally.iter().cloned().map(Order::Send);
        self.actions.extend(last.map(Action::Order));
        self.begin_teardown(now);
    }
}
