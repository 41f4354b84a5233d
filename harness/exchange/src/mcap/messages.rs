//! Turns records into messages, each on its topic.

use super::channels::Channels;
use super::foxglove::{
    self, BASE, BENCH, FrameTransform, LAP_START, Log, LogLevel, PoseInFrame, PosesInFrame,
    TRUE_BASE,
};
use super::measured::Measured;
use super::names::Topics;
use super::schema::{Fields, Schema};
use super::trail::Trail;
use crate::tables::cell::{Cell, Column};
use crate::tables::events::{self, Event, EventKind, Severity};
use crate::tables::row::time;
use crate::tables::rows;
use crate::tables::survey::Survey;
use crate::tables::{Ears, Heard, MessageForm, Row, Table};
use crate::wide::{Observed, with_signals};
use controller::mission::Report;
use mcap::McapResult;
use plan::observation::Observation;
use record::outcome::Summary;
use record::text::{cause_names, name_of};
use record::{Record, RecordKind};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use wire::time::Timestamp;
use wire::units::Pose;

/// Makes messages from the records of one run, taken in order.
pub(super) struct Messages<W: Write + Seek> {
    channels: Channels<W>,
    survey: Survey,
    ears: Ears,
    /// Columns of the observations of each quantity, made at the first one.
    observed: BTreeMap<String, Observed>,
    /// Format of each message of the layout, made at the first one.
    spoken: BTreeMap<usize, Spoken>,
    topics: Topics,
    believed: Trail,
    truth: Trail,
    measured: Measured,
    /// Whether the last step that began holds no others so far.
    innermost: bool,
}

impl<W: Write + Seek> Messages<W> {
    pub(super) fn new(channels: Channels<W>, survey: Survey, ears: Ears) -> Self {
        Self {
            channels,
            survey,
            ears,
            observed: BTreeMap::new(),
            spoken: BTreeMap::new(),
            topics: Topics::default(),
            believed: Trail::default(),
            truth: Trail::default(),
            measured: Measured::default(),
            innermost: false,
        }
    }

    pub(super) fn into_parts(self) -> (Channels<W>, Survey) {
        (self.channels, self.survey)
    }

    pub(super) fn take(&mut self, record: &Record) -> McapResult<()> {
        let at = record.at;
        let who = self.survey.header.name_of(record.device).to_owned();
        match &record.kind {
            RecordKind::Report(Report::State(state)) => {
                self.row("/controller/state", Table::States, &rows::of_state(at, state), at)?;
                if state.pose.is_finite() {
                    self.believed.add(state.pose);
                    self.pose("/base/pose", BENCH, at, state.pose)?;
                    self.transform(BASE, at, state.pose)?;
                }
            }
            RecordKind::Report(Report::Health(health)) => {
                self.row("/controller/health", Table::Health, &rows::of_health(at, health), at)?;
                let causes = cause_names(&health.causes).join(" ");
                let message = format!("health {} {causes}", name_of(&health.level));
                let level = match health.level {
                    controller::health::Level::Fault => LogLevel::Error,
                    controller::health::Level::Degraded => LogLevel::Warning,
                    _ => LogLevel::Info,
                };
                self.log(at, level, record.device.name(), message.trim_end())?;
            }
            RecordKind::Truth { pose, bias_rad_per_s, coil_celsius } => {
                let row = rows::of_truth(at, *pose, *bias_rad_per_s, *coil_celsius);
                self.row("/base/truth", Table::Truth, &row, at)?;
                if pose.is_finite() {
                    self.truth.add(*pose);
                    self.pose("/base/true_pose", BENCH, at, *pose)?;
                    self.transform(TRUE_BASE, at, *pose)?;
                }
            }
            RecordKind::Observation(observation) => self.observe(at, observation)?,
            RecordKind::Frame(frame) => {
                self.row("/can/frames", Table::Frames, &rows::of_frame(at, &who, frame), at)?;
            }
            RecordKind::Bytes(bytes) => {
                let row = rows::of_bytes(at, &who, bytes);
                self.row("/serial/packets", Table::Packets, &row, at)?;
            }
            RecordKind::StepBegan { .. } => {
                self.believed.begin();
                self.truth.begin();
                self.innermost = true;
            }
            RecordKind::StepEnded { .. } if std::mem::take(&mut self.innermost) => {
                let (believed, truth) = (self.believed.path(), self.truth.path());
                self.path("/base/path", at, believed)?;
                self.path("/base/true_path", at, truth)?;
            }
            _ => {}
        }
        if let Some(event) = events::of(record) {
            self.event(&event)?;
        }
        self.hear(record)
    }

    pub(super) fn finish(&mut self, summary: &Summary) -> McapResult<()> {
        let end = self.survey.end;
        for measurement in &summary.measurements {
            let row = rows::of_measurement(end, measurement);
            self.row("/plan/measurements", Table::Measurements, &row, end)?;
        }
        for event in events::of_summary(end, summary) {
            self.event(&event)?;
        }
        Ok(())
    }

    fn row(&mut self, topic: &str, table: Table, row: &Row<'_>, at: Timestamp) -> McapResult<()> {
        let columns = table.fixed_columns();
        let schema = || Schema::of_columns(schema_name(table), table.doc(), columns);
        self.channels.send(topic, at, schema, &Fields(columns, row))
    }

    fn pose(
        &mut self,
        topic: &str,
        frame_id: &'static str,
        at: Timestamp,
        pose: Pose,
    ) -> McapResult<()> {
        let message = PoseInFrame { timestamp: at.into(), frame_id, pose: pose.into() };
        self.channels.send(topic, at, foxglove::pose_in_frame, &message)
    }

    fn transform(&mut self, child: &'static str, at: Timestamp, pose: Pose) -> McapResult<()> {
        let message = FrameTransform::of(child, at, pose);
        self.channels.send("/tf", at, foxglove::frame_transform, &message)
    }

    fn path(
        &mut self,
        topic: &str,
        at: Timestamp,
        poses: Option<Vec<foxglove::Pose3>>,
    ) -> McapResult<()> {
        let Some(poses) = poses else { return Ok(()) };
        let message = PosesInFrame { timestamp: at.into(), frame_id: BENCH, poses };
        self.channels.send(topic, at, foxglove::poses_in_frame, &message)
    }

    fn log(&mut self, at: Timestamp, level: LogLevel, name: &str, message: &str) -> McapResult<()> {
        let message = Log { timestamp: at.into(), level, message, name, file: "", line: 0 };
        self.channels.send("/log", at, foxglove::log, &message)
    }

    fn observe(&mut self, at: Timestamp, observation: &Observation) -> McapResult<()> {
        let quantity = &observation.quantity;
        if !self.observed.contains_key(quantity) {
            // Quantities beyond the survey's limit have no messages; the survey has counted them.
            let Some(observed) = Observed::new(&self.survey, quantity) else { return Ok(()) };
            self.observed.insert(quantity.clone(), observed);
        }
        let Some(observed) = self.observed.get(quantity) else { return Ok(()) };
        let row = observed.row(at, observation);
        let columns = &observed.columns;
        let schema = || {
            let name = format!("hil.observation.{quantity}");
            Schema::of_columns(name, self.survey.title(quantity), columns)
        };
        let topic = self.topics.of("/observations", quantity);
        self.channels.send(topic, at, schema, &Fields(columns, &row))?;
        match self.measured.take(at, observation) {
            Some((measured, pose)) if measured.frame == LAP_START => {
                let start = self.believed.first();
                start.map_or(Ok(()), |start| self.transform(LAP_START, at, start))?;
                self.pose(measured.topic, LAP_START, at, pose)
            }
            Some((measured, pose)) => self.pose(measured.topic, measured.frame, at, pose),
            None => Ok(()),
        }
    }

    fn event(&mut self, event: &Event<'_>) -> McapResult<()> {
        let topic = match event.kind {
            EventKind::StepBegan | EventKind::StepEnded => "/plan/steps",
            EventKind::Command | EventKind::Done | EventKind::Refused | EventKind::Aborted => {
                "/controller/missions"
            }
            EventKind::FaultBegan
            | EventKind::FaultEnded
            | EventKind::FaultNeverHappened
            | EventKind::Confinement => "/plan/faults",
            EventKind::Note | EventKind::Reply => "/plan/notes",
            EventKind::Verdict | EventKind::Property | EventKind::Outcome => "/plan/verdicts",
        };
        self.row(topic, Table::Events, &event.row(), event.at)?;
        // A person does not need lines that follow from earlier ones.
        if matches!(event.kind, EventKind::StepEnded | EventKind::Command | EventKind::Done) {
            return Ok(());
        }
        let level = match event.severity() {
            Severity::Info => LogLevel::Info,
            Severity::Warning => LogLevel::Warning,
            Severity::Error => LogLevel::Error,
        };
        self.log(event.at, level, event.device.name(), &event.text)
    }

    fn hear(&mut self, record: &Record) -> McapResult<()> {
        let mut done = Ok(());
        let Self { ears, channels, topics, spoken, .. } = self;
        ears.take(record, &mut |heard| {
            if done.is_ok() {
                let one = spoken.entry(heard.index);
                let one = one.or_insert_with(|| Spoken::new(heard.form, topics));
                done = one.say(channels, record.at, heard);
            }
        });
        done
    }
}

/// Format of a layout's message: its topic, and a field per signal.
struct Spoken {
    topic: String,
    columns: Vec<Column>,
}

impl Spoken {
    fn new(form: &MessageForm, topics: &mut Topics) -> Self {
        let columns = with_signals(&Table::Signals.fixed_columns()[..2], form);
        Self { topic: topics.of("/messages", &form.name).to_owned(), columns }
    }

    fn say<W: Write + Seek>(
        &self,
        channels: &mut Channels<W>,
        at: Timestamp,
        heard: &Heard<'_>,
    ) -> McapResult<()> {
        let mut row = vec![time(at), Cell::text(heard.who)];
        row.extend(heard.values.iter().map(|value| Cell::maybe(*value)));
        let schema = || {
            let name = format!("hil.message.{}", heard.form.name);
            Schema::of_columns(name, &heard.form.doc, &self.columns)
        };
        channels.send(&self.topic, at, schema, &Fields(&self.columns, &row))
    }
}

const fn schema_name(table: Table) -> &'static str {
    match table {
        Table::States => "hil.State",
        Table::Truth => "hil.Truth",
        Table::Health => "hil.Health",
        Table::Observations => "hil.Observation",
        Table::Events => "hil.Event",
        Table::Measurements => "hil.Measurement",
        Table::Frames => "hil.Frame",
        Table::Packets => "hil.Packet",
        Table::Signals => "hil.Signal",
    }
}
