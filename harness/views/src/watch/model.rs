//! The model of a run in progress.

use super::estimate::Estimate;
use super::gauge::Gauge;
use super::news::{News, NewsKind};
use super::robot::Robot;
use super::traffic::Traffic;
use controller::health::Health;
use controller::mission::{MissionId, Report};
use plan::Plan;
use record::Device;
use record::Progress;
use record::header::{Header, StepNote};
use record::text::{cause_names, name_of};
use record::{FaultEvent, FaultRecord, Record, RecordKind, Violation};
use serde::Serialize;
use std::collections::BTreeMap;
use wire::time::Timestamp;

/// Maximum number of active faults that are named; the others are counted.
pub const FAULTS_MAX: usize = 16;
/// Maximum number of broken properties that are named: there are fewer kinds of them.
pub const BROKEN_MAX: usize = 32;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnderWay {
    pub path: String,
    pub label: Option<String>,
    pub title: String,
    /// Bench time at its begin.
    pub since: Timestamp,
}

/// Everything that can be shown of a run, in its current state.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub plan: String,
    pub title: String,
    pub seed: u64,
    /// Whether the plan is for a custom device, not for the robot or the table.
    pub is_of_device: bool,
    pub now: Timestamp,
    pub steps_done: u64,
    /// Total number of steps so far known.
    pub steps: u64,
    pub under_way: Option<UnderWay>,
    pub estimate: Estimate,
    pub robot: Robot,
    /// Quantities that the plan measures, in its order.
    pub gauges: Vec<Gauge>,
    pub traffic: Traffic,
    /// Health that the device under test reports.
    pub health: Option<Health>,
    /// Active faults: index in the schedule, and name.
    pub faults: Vec<(u32, String)>,
    /// Number of active faults beyond [`FAULTS_MAX`].
    pub faults_unnamed: u64,
    pub broken: Vec<(String, Violation)>,
    pub news: News,
    pub records: u64,
    notes: BTreeMap<String, StepNote>,
}

impl Model {
    /// Creates the model of a run of `plan` that has not begun.
    pub fn new(plan: &Plan, header: &Header) -> Self {
        Self {
            plan: header.plan.clone(),
            title: plan.title.clone(),
            seed: header.seed,
            // A rig may contain the robot.
            is_of_device: plan.devices.is_none()
                && header.lines.iter().all(|line| line.device != Device::Gyro),
            now: Timestamp::ZERO,
            steps_done: 0,
            steps: 0,
            under_way: None,
            estimate: Estimate::new(plan),
            robot: Robot::default(),
            gauges: header.quantities.iter().map(|one| Gauge::new(one, plan)).collect(),
            traffic: Traffic::new(header),
            health: None,
            faults: Vec::new(),
            faults_unnamed: 0,
            broken: Vec::new(),
            news: News::default(),
            records: 0,
            notes: header.steps.clone(),
        }
    }

    pub(super) fn progress(&mut self, progress: Progress) {
        let Progress { now, steps_done, steps } = progress;
        self.now = self.now.max(now);
        self.steps_done = steps_done;
        self.steps = steps;
    }

    pub(super) fn take(&mut self, record: &Record) {
        let at = record.at;
        self.now = self.now.max(at);
        self.records += 1;
        match &record.kind {
            RecordKind::StepBegan { path, title } => {
                self.estimate.began(path);
                self.news.add(at, NewsKind::StepBegan, &format!("begin {path}: {title}"));
                let place = path.split(" (").next().unwrap_or(path);
                let label = self.notes.get(place).and_then(|note| note.label.clone());
                let (path, title) = (path.clone(), title.clone());
                self.under_way = Some(UnderWay { path, label, title, since: at });
            }
            RecordKind::StepEnded { path } => {
                self.estimate.ended(path, at);
                self.news.add(at, NewsKind::StepEnded, &format!("end {path}"));
                self.under_way = None;
                self.steps_done += 1;
            }
            RecordKind::Command(command) => self.robot.command(command),
            RecordKind::Report(report) => self.report(at, report),
            RecordKind::Observation(observation) => {
                let named = |gauge: &&mut Gauge| gauge.quantity.name == observation.quantity;
                if let Some(gauge) = self.gauges.iter_mut().find(named) {
                    gauge.take(at, observation);
                }
            }
            RecordKind::Truth { pose, .. } => self.robot.truth(*pose),
            RecordKind::Note(text) => self.news.add(at, NewsKind::Note, text),
            RecordKind::Reply(reply) => self.news.add(at, NewsKind::Note, &reply.to_string()),
            RecordKind::Fault(fault) => self.fault(at, fault),
            RecordKind::Bytes(_) | RecordKind::Frame(_) => {}
        }
    }

    fn report(&mut self, at: Timestamp, report: &Report) {
        match report {
            Report::State(state) => {
                self.robot.state(at, state);
                self.health.get_or_insert(state.health);
            }
            Report::Health(health) => {
                self.health = Some(*health);
                self.news.add(at, NewsKind::Health, &in_words(health));
            }
            Report::Refused { id, reason } => self.turned_down(at, "refused", *id, reason),
            Report::Aborted { id, reason } => self.turned_down(at, "broken off", *id, reason),
            Report::Done { .. } => {}
        }
    }

    fn turned_down(&mut self, at: Timestamp, how: &str, id: MissionId, reason: &impl Serialize) {
        let text = format!("mission {id} {how}: {}", name_of(reason));
        self.news.add(at, NewsKind::Refusal, &text);
    }

    fn fault(&mut self, at: Timestamp, fault: &FaultRecord) {
        self.news.add(at, NewsKind::Fault, &fault.to_string());
        match fault.event {
            FaultEvent::Began if self.faults.len() < FAULTS_MAX => {
                self.faults.push((fault.index, fault.name.clone()));
            }
            FaultEvent::Began => self.faults_unnamed += 1,
            FaultEvent::Ended { .. } => {
                let named = self.faults.len();
                self.faults.retain(|(index, _)| *index != fault.index);
                if self.faults.len() == named {
                    self.faults_unnamed = self.faults_unnamed.saturating_sub(1);
                }
            }
            FaultEvent::NeverHappened { .. } | FaultEvent::Confinement { .. } => {}
        }
    }

    pub(super) fn broken(&mut self, name: &str, violation: &Violation) {
        let known = self.broken.iter().any(|(known, _)| *known == name);
        if known || self.broken.len() == BROKEN_MAX {
            return;
        }
        let text = format!("broke {name}: {}", violation.what);
        self.news.add(violation.at, NewsKind::Broken, &text);
        self.broken.push((name.to_owned(), violation.clone()));
    }
}

/// Formats health as `fault: gyro silent`.
pub fn in_words(health: &Health) -> String {
    let (level, causes) = (name_of(&health.level), cause_names(&health.causes));
    if causes.is_empty() { level } else { format!("{level}: {}", causes.join(", ")) }
}
