//! State of a run with a robot: its controller takes missions and reports, a base or a table carries a gyro, and all of
//! it must stand still at the end.

use super::fit::Fitted;
use super::lost::CONTROLLER_LOST;
use super::observe::Ends;
use super::rest_watch::RestWatch;
use super::strays::{FIRST_MISSION, Strays};
use super::teardown::Teardown;
use super::{Action, Engine, Waiting};
use crate::bench::{BenchFacts, Look};
use controller::calibration::Calibration;
use controller::health::{Health, Level};
use controller::mission::{BiasTestResult, HeadingSource, MissionId, MissionResult, Report, State};
use identification::model::Model;
use plan::Op;
use plan::quantities as q;
use record::outcome::Outcome;
use record::text::name_of;
use record::{Device, RecordKind};
use std::collections::BTreeMap;
use wire::base::HEADING_STEP;
use wire::table;
use wire::time::Timestamp;
use wire::units::{Angle, Pose, Temperature};

/// Reason of an error when the base was not seen at rest after the end.
pub(super) const NO_REST: &str = "the controller never reported that it stands still";
/// Reason of a failure when the controller goes on reporting motion, of a base or of the gyro on a table.
pub(super) const MOVES_ON: &str =
    "long after the order to stop, the controller still reports motion";

#[derive(Debug, Clone)]
pub(super) struct Robot {
    pub(super) facts: BenchFacts,
    pub(super) next_id: MissionId,
    pub(super) state: Option<State>,
    pub(super) ends: Ends,
    /// Sum of the angles that the table was commanded to turn by.
    pub(super) table_heading: Angle,
    pub(super) rest: RestWatch,
    pub(super) bias_test: Option<(Timestamp, BiasTestResult)>,
    pub(super) calibration: Calibration,
    /// When the calibration came into force.
    pub(super) calibration_since: Timestamp,
    pub(super) heading_source: HeadingSource,
    /// Calibrations that can be used by name.
    pub(super) calibrations: BTreeMap<String, Calibration>,
    pub(super) fits: BTreeMap<String, Fitted>,
    pub(super) model: Option<Model>,
    times_degraded: u32,
    times_fault: u32,
    level: Level,
    /// A mission was refused or aborted.
    declined: bool,
    /// Health has said that samples were lost.
    says_lost: bool,
    /// Rest was awaited before the first mission, or need not be.
    pub(super) awaited: bool,
    pub(super) strays: Strays,
    teardown: Option<Teardown>,
}

impl Robot {
    /// Whether the controller has reported a state.
    pub(super) const fn is_heard(&self) -> bool {
        self.state.is_some()
    }

    fn take_health(&mut self, Health { level, causes }: &Health) {
        let level = *level;
        self.says_lost |= causes.samples_lost;
        self.times_degraded += u32::from(level >= Level::Degraded && self.level < Level::Degraded);
        self.times_fault += u32::from(level == Level::Fault && self.level < Level::Fault);
        self.level = level;
    }
}

impl Engine {
    /// Adds a robot, and calibrations that the plan can use by name.
    #[must_use]
    pub fn with_robot(
        mut self,
        facts: BenchFacts,
        calibrations: BTreeMap<String, Calibration>,
    ) -> Self {
        self.robot = Some(Box::new(Robot {
            facts,
            next_id: FIRST_MISSION,
            state: None,
            ends: Ends::default(),
            table_heading: Angle::ZERO,
            rest: RestWatch::default(),
            bias_test: None,
            calibration: Calibration::default(),
            calibration_since: self.began,
            heading_source: HeadingSource::default(),
            calibrations,
            fits: BTreeMap::new(),
            model: None,
            times_degraded: 0,
            times_fault: 0,
            level: Level::Starting,
            declined: false,
            says_lost: false,
            awaited: false,
            strays: Strays::default(),
            teardown: None,
        }));
        self
    }

    /// Whether the controller has reported a problem: degraded health after good health, or a mission that it did not
    /// carry out.
    pub fn has_announced(&self) -> bool {
        let said = |robot: &Robot| robot.declined || robot.times_degraded + robot.times_fault > 0;
        self.robot.as_deref().is_some_and(said)
    }

    /// What the controller answered instead of the mission that the engine awaits, as the end of a sentence.
    pub(super) fn instead_of_an_answer(&self) -> String {
        let robot = self.robot.as_ref().filter(|_| matches!(self.waiting, Waiting::Mission(_)));
        robot.map_or_else(String::new, |robot| robot.strays.instead())
    }

    pub(super) fn teardown(&self) -> Option<&Teardown> {
        self.robot.as_ref()?.teardown.as_ref()
    }

    /// Brings the robot to rest. Without a controller nothing would confirm that it stands still.
    pub(super) fn begin_teardown(&mut self, now: Timestamp) {
        if let Some(robot) = &mut self.robot {
            robot.teardown = Some(Teardown::begin(now));
            self.step_teardown(now);
        }
    }

    /// As [`Self::lost_node`], for a robot's controller: nothing can confirm rest any more, and only the command time-out
    /// of the base stops it.
    pub fn lost_controller(&mut self, now: Timestamp, how: &str) {
        self.lost(now, &format!("{CONTROLLER_LOST}{how}"));
        if let Some(robot) = &mut self.robot {
            robot.teardown = None;
        }
    }

    pub fn report(&mut self, now: Timestamp, report: &Report) {
        let Some(robot) = &mut self.robot else { return };
        if let Some(teardown) = &mut robot.teardown {
            teardown.report(now, report);
            self.step_teardown(now);
            return;
        }
        if self.ending.is_some() {
            return;
        }
        match report {
            Report::State(state) => self.take_state(now, state),
            Report::Health(health) => robot.take_health(health),
            Report::Done { id, result } if self.waiting == Waiting::Mission(*id) => {
                self.phases.mission_ended(&mut self.actions);
                self.take_result(now, result);
                self.waiting = Waiting::Nothing;
                self.advance(now);
            }
            Report::Refused { id, reason } if self.waiting == Waiting::Mission(*id) => {
                robot.declined = true;
                let why = format!("the controller refused: {}", words(reason));
                self.end_here(now, Outcome::Failed, &why);
            }
            Report::Aborted { id, reason } if self.waiting == Waiting::Mission(*id) => {
                robot.declined = true;
                let why = format!("the controller broke off: {}", words(reason));
                self.end_here(now, Outcome::Failed, &why);
            }
            Report::Done { id, .. } | Report::Refused { id, .. } | Report::Aborted { id, .. } => {
                if let Some(note) = robot.strays.take(*id, robot.next_id) {
                    self.record(RecordKind::Note(note));
                }
            }
        }
    }

    pub fn table(&mut self, now: Timestamp, answer: table::Answer) {
        match (&self.waiting, answer) {
            (Waiting::TableWord, table::Answer::Done(_))
            | (Waiting::TableRest { .. }, table::Answer::State { moving: false, .. }) => {
                self.waiting = Waiting::Nothing;
            }
            (Waiting::TableWord | Waiting::TableRest { .. }, table::Answer::Refused(_)) => {
                self.end_here(now, Outcome::Error, "the table refused a command");
            }
            _ => {}
        }
        self.advance(now);
    }

    /// Takes the pose found by the absolute measurement.
    pub fn absolute(&mut self, now: Timestamp, pose: Pose) {
        let (Waiting::Absolute(op), Some(robot)) = (&self.waiting, &mut self.robot) else { return };
        match op {
            Op::AbsoluteBefore => robot.ends.pose_before = Some(pose),
            Op::AbsoluteAfter => robot.ends.pose_after = Some(pose),
            _ => {
                let facts = robot.facts;
                self.observe(now, |collector| collector.pose(&pose, &facts));
            }
        }
        self.waiting = Waiting::Nothing;
        self.advance(now);
    }

    /// Takes the result of a look at the base; `None` if it cannot be seen.
    pub fn looked(&mut self, now: Timestamp, look: Option<Look>) {
        let Waiting::Look(segment) = self.waiting else { return };
        if let Some(robot) = &mut self.robot {
            let before = std::mem::replace(&mut robot.ends.look_after, look);
            robot.ends.look_before = robot.ends.look_before.or(look);
            if let (Some(segment), Some(before), Some(after)) = (segment, before, look) {
                self.observe(now, |collector| collector.segment(segment, &before, &after));
            }
        }
        self.waiting = Waiting::Nothing;
        self.advance(now);
    }

    /// Whether the plan needs the truth during straight lines.
    pub fn wants_truth(&self) -> bool {
        self.wanted.contains(q::STRAIGHT_TRUE_HEADING_ERROR.name)
    }

    /// Takes the true pose of the base on a straight line.
    pub fn true_on_line(&mut self, now: Timestamp, truth: &Pose) {
        let Some(look) = self.robot.as_ref().and_then(|robot| robot.ends.look_after) else {
            return;
        };
        let error = (truth.heading - look.truth.heading).deg();
        self.observe(now, |collector| {
            collector.add(&q::STRAIGHT_TRUE_HEADING_ERROR, error, 0.0, &[]);
        });
    }

    fn take_state(&mut self, now: Timestamp, state: &State) {
        let Some(robot) = &mut self.robot else { return };
        let first = robot.state.replace(*state).is_none();
        robot.ends.take(now, state);
        let rests = robot.rest.take(state);
        let temperature = state.temperature.filter(|_| rests).map(Temperature::celsius);
        self.signals.hear(now, q::GYRO_TEMPERATURE.name, temperature);
        self.signals.hear(now, q::GYRO_RATE.name, rests.then(|| state.raw_rate.deg_per_s()));
        if let Some(error) = state.heading_error
            && self.wanted.contains(q::STRAIGHT_HEADING_ERROR.name)
        {
            self.observe(now, |collector| {
                collector.add(&q::STRAIGHT_HEADING_ERROR, -error.deg(), 0.0, &[]);
            });
        }
        self.ends_wait();
        if matches!(self.waiting, Waiting::Rest | Waiting::FirstRest(_)) && !state.moving {
            self.waiting = Waiting::Nothing;
        }
        if first || self.waiting == Waiting::Nothing {
            self.advance(now);
        }
    }

    fn take_result(&mut self, now: Timestamp, result: &MissionResult) {
        // The resolution of the gyro is far below its drift in a few seconds; that of the odometry is a step of 0.3 deg
        // (uniform).
        let Some(robot) = &mut self.robot else { return };
        let heading_u_deg = match robot.heading_source {
            HeadingSource::Gyro => 0.0,
            HeadingSource::Odometry => HEADING_STEP.deg() / 12f64.sqrt(),
        };
        match result {
            MissionResult::BiasTest(result) => {
                robot.bias_test = Some((now, *result));
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

    /// Observes quantities of the run as a whole.
    pub(super) fn observe_whole_run(&mut self, now: Timestamp) {
        let (degraded, fault, says_lost, state) = match &self.robot {
            Some(robot) => (robot.times_degraded, robot.times_fault, robot.says_lost, robot.state),
            None => Default::default(),
        };
        let known = now.min(self.known_until);
        let reactions = self.reactions.finish(known);
        let (gaps, waited) = (self.gaps.finish(known), self.gaps.waited(known));
        let unexpected = self.unexpected_until(now);
        self.observe(now, |collector| {
            collector.gaps(gaps, q::OPEN_AT_END);
            waited.iter().for_each(|waited| collector.waited(waited, Some(q::OPEN_AT_END)));
            unexpected.iter().for_each(|(line, count)| collector.add_named(line, *count, 0.0, &[]));
            reactions.into_iter().for_each(|took| collector.reaction(took));
            collector.add(&q::HEALTH_DEGRADED, f64::from(degraded), 0.0, &[]);
            collector.add(&q::HEALTH_FAULT, f64::from(fault), 0.0, &[]);
            let Some(state) = state else { return };
            collector.add(&q::SAMPLES_USED, state.samples as f64, 0.0, &[]);
            // A controller that does not know how many were lost, and says so in its health, has lost at least one. Those
            // of a gyro that is still silent are not counted yet.
            let says_lost = says_lost || state.health.causes.gyro_silent;
            let lost = state.samples_lost.max(u64::from(says_lost));
            collector.add(&q::SAMPLES_LOST, lost as f64, 0.0, &[]);
            let overflows = f64::from(u8::from(state.health.causes.overflow));
            collector.add(&q::QUEUE_OVERFLOWS, overflows, 0.0, &[]);
            if let Some(ratio) = state.clock_ratio {
                collector.add(&q::CLOCK_RATIO, ratio, 0.0, &[]);
            }
        });
    }

    pub(super) fn step_teardown(&mut self, now: Timestamp) {
        let Some(robot) = &mut self.robot else { return };
        let Some(teardown) = &mut robot.teardown else { return };
        if !teardown.step(now, &mut robot.next_id, &mut self.actions) {
            return;
        }
        let at_rest = teardown.at_rest();
        let why = if teardown.moves(now) { MOVES_ON } else { NO_REST };
        robot.teardown = None;
        if !at_rest && let Some(ending) = &mut self.ending {
            // A failure or a time-out is more important than what comes afterwards.
            if ending.outcome == Outcome::Passed {
                ending.outcome = Outcome::Failed;
            }
            self.actions.push_back(Action::Record(Device::Plan, RecordKind::Note(why.to_owned())));
            ending.reason = Some(match ending.reason.take() {
                Some(reason) => format!("{reason}; {why}"),
                None => why.to_owned(),
            });
        }
    }
}

/// An enumerator of the mission protocol as in JSON, with spaces instead of underscores.
fn words(reason: &impl serde::Serialize) -> String {
    name_of(reason).replace('_', " ")
}
