//! Turns rows into messages, each on its topic, and records into poses and lines of a log.

use super::channels::Channels;
use super::foxglove::{
    self, BASE, BENCH, FrameTransform, LAP_START, Log, LogLevel, PoseInFrame, PosesInFrame,
    TRUE_BASE,
};
use super::measured::Measured;
use super::names::Topics;
use super::schema::{Fields, Schema};
use super::trail::Trail;
use crate::tables::cell::{Cell, Column, time};
use crate::tables::events::{Event, EventKind, Severity};
use crate::tables::survey::Survey;
use crate::tables::{Heard, Row, RowSink, Table};
use crate::wide::{Observed, with_signals};
use controller::mission::Report;
use mcap::{McapError, McapResult};
use plan::observation::Observation;
use record::text::{cause_names, name_of};
use record::{Record, RecordKind};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use wire::time::Timestamp;
use wire::units::Pose;

/// Makes messages of one run, taken in order.
pub(super) struct Messages<W: Write + Seek> {
    channels: Channels<W>,
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
    pub(super) fn new(channels: Channels<W>) -> Self {
        Self {
            channels,
            observed: BTreeMap::new(),
            spoken: BTreeMap::new(),
            topics: Topics::default(),
            believed: Trail::default(),
            truth: Trail::default(),
            measured: Measured::default(),
            innermost: false,
        }
    }

    pub(super) fn into_channels(self) -> Channels<W> {
        self.channels
    }

    fn send_row(
        &mut self,
        topic: &str,
        at: Timestamp,
        table: Table,
        row: &Row<'_>,
    ) -> McapResult<()> {
        let columns = table.fixed_columns();
        let schema = || Schema::of_columns(table.schema_name(), table.doc(), columns);
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
}

impl<W: Write + Seek> RowSink for Messages<W> {
    type Error = McapError;

    fn row(&mut self, at: Timestamp, table: Table, row: &Row<'_>) -> McapResult<()> {
        let topic = match table {
            Table::States => "/controller/state",
            Table::Health => "/controller/health",
            Table::Truth => "/base/truth",
            Table::Frames => "/can/frames",
            Table::Packets => "/serial/packets",
            Table::Measurements => "/plan/measurements",
            // They have topics of their own.
            Table::Observations | Table::Events | Table::Signals => return Ok(()),
        };
        self.send_row(topic, at, table, row)
    }

    fn observe(
        &mut self,
        survey: &Survey,
        at: Timestamp,
        observation: &Observation,
        _: &dyn Fn() -> Row<'static>,
    ) -> McapResult<()> {
        let quantity = &observation.quantity;
        if !self.observed.contains_key(quantity) {
            // Quantities beyond the survey's limit have no messages; the survey has counted them.
            let Some(observed) = Observed::new(survey, quantity) else { return Ok(()) };
            self.observed.insert(quantity.clone(), observed);
        }
        let Some(observed) = self.observed.get(quantity) else { return Ok(()) };
        let row = observed.row(at, observation);
        let columns = &observed.columns;
        let schema = || {
            let name = format!("hil.observation.{quantity}");
            Schema::of_columns(name, survey.title(quantity), columns)
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

    fn beside(&mut self, record: &Record) -> McapResult<()> {
        let at = record.at;
        match &record.kind {
            RecordKind::Report(Report::State(state)) if state.pose.is_finite() => {
                self.believed.add(state.pose);
                self.pose("/base/pose", BENCH, at, state.pose)?;
                self.transform(BASE, at, state.pose)
            }
            RecordKind::Report(Report::Health(health)) => {
                let causes = cause_names(&health.causes).join(" ");
                let message = format!("health {} {causes}", name_of(&health.level));
                let level = match health.level {
                    controller::health::Level::Fault => LogLevel::Error,
                    controller::health::Level::Degraded => LogLevel::Warning,
                    _ => LogLevel::Info,
                };
                self.log(at, level, record.device.name(), message.trim_end())
            }
            RecordKind::Truth { pose, .. } if pose.is_finite() => {
                self.truth.add(*pose);
                self.pose("/base/true_pose", BENCH, at, *pose)?;
                self.transform(TRUE_BASE, at, *pose)
            }
            RecordKind::StepBegan { .. } => {
                self.believed.begin();
                self.truth.begin();
                self.innermost = true;
                Ok(())
            }
            RecordKind::StepEnded { .. } if std::mem::take(&mut self.innermost) => {
                let (believed, truth) = (self.believed.path(), self.truth.path());
                self.path("/base/path", at, believed)?;
                self.path("/base/true_path", at, truth)
            }
            _ => Ok(()),
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
        self.send_row(topic, event.at, Table::Events, &event.row())?;
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

    fn hear(&mut self, at: Timestamp, heard: &Heard<'_>) -> McapResult<()> {
        let Spoken { topic, columns } = self.spoken.entry(heard.index).or_insert_with(|| {
            let columns = with_signals(&Table::Signals.fixed_columns()[..2], heard.form);
            let topic = self.topics.of("/messages", &heard.form.full_name()).to_owned();
            Spoken { topic, columns }
        });
        let mut row = vec![time(at), Cell::text(heard.who)];
        row.extend(heard.values.iter().map(|value| Cell::maybe(*value)));
        let schema = || {
            let name = format!("hil.message.{}", heard.form.full_name());
            Schema::of_columns(name, &heard.form.doc, columns)
        };
        self.channels.send(topic, at, schema, &Fields(columns, &row))
    }
}

/// Format of a layout's message: its topic, and a field per signal.
struct Spoken {
    topic: String,
    columns: Vec<Column>,
}
