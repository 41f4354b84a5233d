//! Runs a plan: steps in, missions and actions out, reports and answers back in.
//!
//! The engine does no IO and reads no clock, so that the simulated and the live world run the same code. Its owner
//! calls [`Engine::wake`] whenever [`Engine::next_wakeup`] is due, passes it every report and answer, and carries out
//! every [`Action`] until there are no more. In any case the engine ends by stopping the base and waiting until it
//! stands still.

mod action;
mod execute;
mod fit;
mod gaps;
mod gathered;
mod identify;
mod lost;
pub mod observe;
mod past;
mod phases;
pub mod program;
mod reactions;
mod rest_watch;
mod robot;
mod sdo;
mod segment;
mod signals;
mod strays;
mod teardown;
#[cfg(test)]
mod tests;
mod uds;
mod unexpected;
mod waiting;

pub use crate::bench::{BenchFacts, Look};
pub use action::{Action, Ending};

use crate::node::Woken;
use described::Decoded;
use gaps::Gaps;
use identification::model::Model;
use observe::{Collector, Tags};
use phases::Phases;
use plan::observation::Observations;
use plan::{Action as StepAction, Op, Order, Plan, QuantityName, Segment, Speaker};
use program::Program;
use reactions::Reactions;
use record::outcome::Outcome;
use record::{Device, RecordKind};
use robot::Robot;
use sdo::Transfers;
use signals::Signals;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use unexpected::Unexpected;
use waiting::Waiting;
use wire::time::{Span, Timestamp};

pub(crate) use lost::is_of_lost;
pub use strays::FIRST_MISSION;

#[derive(Debug, Clone)]
pub struct Engine {
    plan: Arc<Plan>,
    program: Program,
    ops: VecDeque<Op>,
    waiting: Waiting,
    /// The step in progress, when it began, its own limit, and the nearest one.
    step: Option<(StepAction, Timestamp, Timestamp)>,
    step_deadline: Timestamp,
    /// Limit of each answer to a mission of this step, unless the plan gives the step a limit: that of the step may be a
    /// person's.
    answer_limit: Option<Span>,
    answer_deadline: Timestamp,
    plan_deadline: Timestamp,
    began: Timestamp,
    /// Nothing is known of what the nodes sent after this: a log that plays them ends there.
    pub known_until: Timestamp,
    signals: Signals,
    gaps: Gaps,
    reactions: Reactions,
    unexpected: Unexpected,
    transfers: Transfers,
    /// State of a robot: its controller must report before the first step, and brings the base to rest at the end.
    /// `None` if no node takes missions.
    robot: Option<Box<Robot>>,
    /// Nodes under test other than the robot's controller.
    under_test: Vec<String>,
    /// Models that can be used by name.
    models: BTreeMap<String, Model>,
    corrected: BTreeSet<QuantityName>,
    tags: Tags,
    /// Number of rounds begun of the innermost repeats and sweeps, and whether one began since the last step.
    rounds: u64,
    round_begun: bool,
    /// Quantities that a measurement or a fit of the plan needs.
    wanted: BTreeSet<String>,
    observations: Observations,
    ending: Option<Ending>,
    actions: VecDeque<Action>,
    phases: Phases,
}

impl Engine {
    /// Creates an engine that begins `plan` at `now`, on a rig without a controller for missions.
    pub fn new(plan: Arc<Plan>, now: Timestamp) -> Self {
        let plan_deadline = now + plan.time_limit();
        Self {
            program: Program::new(Arc::clone(&plan), now, plan_deadline),
            wanted: identify::wanted(&plan),
            phases: Phases::new(!plan.faults.is_empty()),
            unexpected: Unexpected::of(&plan),
            plan,
            ops: VecDeque::new(),
            waiting: Waiting::Nothing,
            step: None,
            step_deadline: Timestamp::MAX,
            answer_limit: None,
            answer_deadline: Timestamp::MAX,
            plan_deadline,
            began: now,
            known_until: Timestamp::MAX,
            signals: Signals::default(),
            gaps: Gaps::default(),
            reactions: Reactions::default(),
            transfers: Transfers::default(),
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

    /// A harness in real time did at `then` what it should have done earlier by this time.
    pub fn heard_late(&mut self, then: Timestamp, by: Span) {
        self.reactions.heard_late(then, by);
    }

    /// Adds the speakers whose messages are decoded.
    #[must_use]
    pub fn hearing(mut self, speakers: &[Speaker]) -> Self {
        self.signals = Signals::of(&self.plan, speakers);
        self.gaps = Gaps::of(&self.plan, speakers, self.began);
        self.reactions = Reactions::of(&self.plan, speakers);
        self.transfers = Transfers::of(speakers);
        self
    }

    /// Names the nodes under test: a wait for them that runs out of time is a failure, not an error.
    #[must_use]
    pub fn awaiting(mut self, under_test: Vec<String>) -> Self {
        self.under_test = under_test;
        self
    }

    /// Ends the run as failed: the device under test did something forbidden.
    pub fn failed(&mut self, now: Timestamp, why: &str) {
        self.end(now, Outcome::Failed, Some(why.to_owned()));
    }

    /// Says when phases begin and end, though the plan has no faults that wait for them.
    pub const fn watch_phases(&mut self) {
        self.phases.watch();
    }

    /// Whether the controller has reported, or need not report.
    pub fn is_heard(&self) -> bool {
        self.robot.as_ref().is_none_or(|robot| robot.is_heard())
    }

    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The observations so far.
    pub const fn observations(&self) -> &Observations {
        &self.observations
    }

    /// Takes the observations of a run that has ended.
    pub fn take_observations(&mut self) -> Observations {
        std::mem::take(&mut self.observations)
    }

    /// How the run ended; `None` while it runs.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref().filter(|_| self.teardown().is_none())
    }

    /// Why the run has come to its end, if there is a reason: before it begins, that something did not start.
    pub fn why_ending(&self) -> Option<&str> {
        self.ending.as_ref()?.reason.as_deref()
    }

    /// Whether the run has come to its end, though the base may not have stopped yet.
    pub const fn is_ending(&self) -> bool {
        self.ending.is_some()
    }

    /// Steps done and steps in all, repetitions counted.
    pub const fn progress(&self) -> (u64, u64) {
        self.program.progress()
    }

    /// The next action for the owner to carry out.
    pub fn action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// When [`Self::wake`] has something to do, if nothing arrives earlier.
    pub fn next_wakeup(&self) -> Timestamp {
        if let Some(teardown) = self.teardown() {
            return teardown.next_wakeup();
        }
        if self.ending.is_some() {
            return Timestamp::MAX;
        }
        let due = match self.waiting {
            // The first step waits for a report of the controller; see `report`.
            Waiting::Nothing if self.is_heard() => Timestamp::ZERO,
            Waiting::Until(at)
            | Waiting::Residual(at)
            | Waiting::FirstRest(at)
            | Waiting::TableRest { ask_at: at } => at,
            Waiting::Log { until, due, .. } => until.min(due),
            Waiting::Sdo => self.transfers.deadline(),
            Waiting::Reaction => self.reactions.due(),
            Waiting::Mission(_) => self.answer_deadline,
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
        // Something done just in time has not missed its limit.
        self.advance(now);
        if self.ending.is_some() {
            return;
        }
        // Of two limits that end together, the step's says more.
        let is_own = self.step.as_ref().is_some_and(|(_, _, until)| *until <= self.plan_deadline);
        if now >= self.plan_deadline && !is_own {
            self.end(now, Outcome::Timeout, Some("the plan took longer than its limit".to_owned()));
        } else if now >= self.step_deadline {
            let why = match self.waiting {
                Waiting::Rest => ": the controller does not report rest",
                Waiting::Reaction if self.reactions.is_asked() => {
                    ": what it waits for did not come"
                }
                Waiting::Reaction => ": nothing asked for it",
                Waiting::Reply(_) => ": no final response came",
                _ => "",
            };
            let instead = self.instead_of_an_answer();
            let reason = format!("{} took longer than its limit{why}{instead}", self.place());
            // A node under test that misses a limit has failed.
            let has_failed = match &self.waiting {
                Waiting::Condition(_) | Waiting::Reaction => !self.under_test.is_empty(),
                Waiting::Reply(asked) => self.under_test.iter().any(|node| node == asked.node()),
                _ => false,
            };
            let outcome = if has_failed { Outcome::Failed } else { Outcome::Timeout };
            self.end(now, outcome, Some(reason));
        } else if matches!(self.waiting, Waiting::Mission(_)) && now >= self.answer_deadline {
            let instead = self.instead_of_an_answer();
            let why = format!("the controller did not answer the mission{instead}");
            self.end_here(now, Outcome::Failed, &why);
        }
    }

    /// Stops the run at the user's request.
    pub fn abort(&mut self, now: Timestamp) {
        self.end(now, Outcome::Aborted, Some("stopped by request".to_owned()));
    }

    /// Ends the run with an error: the world could not carry out an action, or lost something that it needs.
    pub fn broke(&mut self, now: Timestamp, why: &str) {
        self.end(now, Outcome::Error, Some(why.to_owned()));
    }

    pub fn message(&mut self, now: Timestamp, speaker: usize, decoded: &Decoded<'_>) {
        if self.ending.is_some() {
            return;
        }
        self.answer_sdo(now, speaker, decoded);
        let waited = self.gaps.heard(now, (speaker, decoded.message));
        let brought = self.signals.take(now, (speaker, decoded.message), decoded.values);
        let took = self.reactions.take(now, speaker, decoded);
        if !brought.is_empty() || !took.is_empty() || !waited.is_empty() {
            self.observe(now, |collector| {
                waited.iter().for_each(|waited| collector.waited(waited, None));
                for (name, value) in &brought {
                    collector.add_named(name, *value, 0.0, &[]);
                }
                took.into_iter().for_each(|took| collector.reaction(took));
            });
        }
        // What was known before the step shows nothing of a node that has fallen silent.
        let is_old = matches!(&self.waiting, Waiting::Condition(condition)
            if brought.iter().all(|(name, _)| name != condition.quantity().as_str()));
        if !is_old && self.ends_wait() {
            self.advance(now);
        }
    }

    /// Ends the wait if the awaited condition holds; returns whether it did.
    fn ends_wait(&mut self) -> bool {
        let holds = match &self.waiting {
            Waiting::Condition(condition) => self.signals.holds(condition),
            Waiting::Reaction => self.reactions.has_come(),
            _ => false,
        };
        if holds {
            self.waiting = Waiting::Nothing;
        }
        holds
    }

    /// Takes what has become of an emulated device.
    pub fn woken(&mut self, now: Timestamp, woken: Woken) {
        match woken {
            Woken::Back => self.answered(now),
            Woken::Failed(why) => self.broke(now, &why),
        }
    }

    /// Takes the world's confirmation of an order.
    pub fn answered(&mut self, now: Timestamp) {
        if self.waiting == Waiting::Answer(None) {
            self.waiting = Waiting::Nothing;
            self.advance(now);
        }
    }

    fn place(&self) -> String {
        match &self.step {
            Some((action, ..)) => format!("{} ({action})", self.program.place()),
            None => self.program.place(),
        }
    }

    /// Keeps and records the observations that the plan needs.
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

    /// Ends the run for a reason that concerns the step in progress.
    fn end_here(&mut self, now: Timestamp, outcome: Outcome, why: &str) {
        self.end(now, outcome, Some(format!("{}: {why}", self.place())));
    }

    fn end(&mut self, now: Timestamp, outcome: Outcome, reason: Option<String>) {
        if self.ending.is_some() {
            return;
        }
        if let Some(reason) = &reason {
            let note = RecordKind::Note(reason.clone());
            self.actions.push_back(Action::Record(Device::Plan, note));
        }
        self.ending = Some(Ending { outcome, reason, lost: false });
        self.observe_whole_run(now);
        self.ops.clear();
        self.phases.all_ended(&mut self.actions);
        // Last, the messages that the plan sends finally.
        let last = self.plan.finally.iter().cloned().map(Order::Send);
        self.actions.extend(last.map(Action::Order));
        self.begin_teardown(now);
    }
}
