//! Turns records into rows of tables.

use super::cell::{Cell, Row, time};
use super::columns::Table;
use super::events::{self, Event};
use super::heard::{Ears, Heard};
use super::survey::Survey;
use controller::health::Health;
use controller::mission::{Report, State};
use data_encoding::HEXLOWER;
use plan::observation::Observation;
use record::outcome::{Measurement, Summary};
use record::text::{cause_names, name_of};
use record::{Record, RecordKind};
use wire::can::{CanFrame, Id};
use wire::time::Timestamp;
use wire::units::{AngularRate, Pose};

/// What is written of a run. The defaults give the tables; a format with a place per quantity, per message or for poses
/// has its own.
pub trait RowSink {
    type Error;

    /// Takes a row of `table`, with a cell per column.
    ///
    /// # Errors
    /// When the row cannot be written.
    fn row(&mut self, at: Timestamp, table: Table, row: &Row<'_>) -> Result<(), Self::Error>;

    /// Takes an observation; `row` is that of its table.
    ///
    /// # Errors
    /// When it cannot be written.
    fn observe(
        &mut self,
        _: &Survey,
        at: Timestamp,
        _: &Observation,
        row: &dyn Fn() -> Row<'static>,
    ) -> Result<(), Self::Error> {
        self.row(at, Table::Observations, &row())
    }

    /// Takes what a record means beside its row.
    ///
    /// # Errors
    /// When it cannot be written.
    fn beside(&mut self, _: &Record) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Takes an event.
    ///
    /// # Errors
    /// When it cannot be written.
    fn event(&mut self, event: &Event<'_>) -> Result<(), Self::Error> {
        self.row(event.at, Table::Events, &event.row())
    }

    /// Takes a decoded message.
    ///
    /// # Errors
    /// When it cannot be written.
    fn hear(&mut self, at: Timestamp, heard: &Heard<'_>) -> Result<(), Self::Error> {
        of_signals(at, heard).try_for_each(|row| self.row(at, Table::Signals, &row))
    }
}

/// Makes rows from the records of one run, taken in order.
#[derive(Debug)]
pub struct Rows {
    tags: Vec<String>,
    survey: Survey,
    ears: Ears,
}

impl Rows {
    /// For the records that `survey` saw; `ears` decode their traffic.
    pub fn new(survey: Survey, ears: Ears) -> Self {
        let tags = survey.tags().into_iter().map(str::to_owned).collect();
        Self { tags, survey, ears }
    }

    pub const fn survey(&self) -> &Survey {
        &self.survey
    }

    /// The survey of the records, after the last one.
    pub fn into_survey(self) -> Survey {
        self.survey
    }

    /// Makes the rows of a record.
    ///
    /// # Errors
    /// Errors of `sink`.
    pub fn take<S: RowSink>(&mut self, record: &Record, sink: &mut S) -> Result<(), S::Error> {
        let at = record.at;
        let header = &self.survey.header;
        let who = || header.name_of(record.device);
        let line = header.line_of(record.device);
        match &record.kind {
            RecordKind::Report(Report::State(state)) => {
                sink.row(at, Table::States, &of_state(at, state))?;
            }
            RecordKind::Report(Report::Health(health)) => {
                sink.row(at, Table::Health, &of_health(at, health))?;
            }
            RecordKind::Truth { pose, bias_rad_per_s, coil_celsius } => {
                sink.row(at, Table::Truth, &of_truth(at, *pose, *bias_rad_per_s, *coil_celsius))?;
            }
            RecordKind::Observation(observation) => {
                let row = || self.of_observation(at, observation);
                sink.observe(&self.survey, at, observation, &row)?;
            }
            RecordKind::Frame(frame) => {
                sink.row(at, Table::Frames, &of_frame(at, who(), frame, line))?;
            }
            RecordKind::Bytes(bytes) => {
                sink.row(at, Table::Packets, &of_bytes(at, who(), bytes, line))?;
            }
            _ => {}
        }
        sink.beside(record)?;
        if let Some(event) = events::of(record) {
            sink.event(&event)?;
        }
        let mut done = Ok(());
        self.ears.take(record, &self.survey.header, &mut |heard| {
            if done.is_ok() {
                done = sink.hear(at, heard);
            }
        });
        done
    }

    /// Makes the rows of the run's results.
    ///
    /// # Errors
    /// Errors of `sink`.
    pub fn finish<S: RowSink>(&self, summary: &Summary, sink: &mut S) -> Result<(), S::Error> {
        let end = self.survey.end;
        for measurement in &summary.measurements {
            sink.row(end, Table::Measurements, &of_measurement(end, measurement))?;
        }
        events::of_summary(end, summary).try_for_each(|event| sink.event(&event))
    }

    fn of_observation(&self, at: Timestamp, observation: &Observation) -> Row<'static> {
        let unit = self.survey.unit(&observation.quantity).to_owned();
        let mut row = vec![
            time(at),
            Cell::text(observation.quantity.clone()),
            observation.value.into(),
            observation.uncertainty.into(),
            Cell::text(unit),
        ];
        row.extend(self.tags.iter().map(|tag| Cell::maybe(observation.tags.get(tag).copied())));
        row
    }
}

fn of_state<'a>(at: Timestamp, state: &State) -> Row<'a> {
    vec![
        time(at),
        Cell::text(name_of(&state.activity)),
        state.moving.into(),
        state.pose.x.m().into(),
        state.pose.y.m().into(),
        state.pose.heading.deg().into(),
        state.gyro_heading.deg().into(),
        state.odometry_heading.deg().into(),
        state.displacement.m().into(),
        Cell::maybe(state.heading_error.map(|error| error.deg())),
        state.raw_rate.deg_per_s().into(),
        state.bias.deg_per_h().into(),
        Cell::maybe(state.temperature.map(|temperature| temperature.celsius())),
        Cell::count(state.samples),
        Cell::count(state.samples_lost),
        Cell::maybe(state.clock_ratio),
        Cell::text(name_of(&state.health.level)),
        Cell::maybe(state.uncertainty.map(|uncertainty| uncertainty.heading.deg())),
        Cell::maybe(state.uncertainty.map(|uncertainty| uncertainty.x.m())),
        Cell::maybe(state.uncertainty.map(|uncertainty| uncertainty.y.m())),
    ]
}

fn of_truth<'a>(at: Timestamp, pose: Pose, bias_rad_per_s: f64, coil_celsius: f64) -> Row<'a> {
    vec![
        time(at),
        pose.x.m().into(),
        pose.y.m().into(),
        pose.heading.deg().into(),
        AngularRate::from_rad_per_s(bias_rad_per_s).deg_per_h().into(),
        coil_celsius.into(),
    ]
}

fn of_health<'a>(at: Timestamp, health: &Health) -> Row<'a> {
    let causes = cause_names(&health.causes).join(" ");
    vec![time(at), Cell::text(name_of(&health.level)), Cell::text(causes)]
}

fn of_frame<'a>(at: Timestamp, who: &'a str, frame: &CanFrame, line: Option<&'a str>) -> Row<'a> {
    let (id, extended) = match frame.id() {
        Id::Standard(id) => (i64::from(id.as_raw()), false),
        Id::Extended(id) => (i64::from(id.as_raw()), true),
    };
    vec![
        time(at),
        Cell::text(who),
        Cell::Integer(id),
        extended.into(),
        frame.is_remote().into(),
        frame.fd_flags().is_some().into(),
        Cell::Integer(embedded_can::Frame::dlc(frame) as i64),
        Cell::text(HEXLOWER.encode(frame.data())),
        line.map_or(Cell::Missing, Cell::text),
    ]
}

fn of_bytes<'a>(at: Timestamp, who: &'a str, bytes: &[u8], line: Option<&'a str>) -> Row<'a> {
    vec![
        time(at),
        Cell::text(who),
        Cell::count(bytes.len() as u64),
        Cell::text(HEXLOWER.encode(bytes)),
        line.map_or(Cell::Missing, Cell::text),
    ]
}

fn of_measurement(at: Timestamp, measurement: &Measurement) -> Row<'_> {
    let text = |text: &Option<String>| text.clone().map_or(Cell::Missing, Cell::text);
    vec![
        time(at),
        Cell::text(&measurement.name),
        Cell::maybe(measurement.value),
        measurement.uncertainty.into(),
        Cell::text(&measurement.unit),
        Cell::maybe(measurement.lower),
        Cell::maybe(measurement.upper),
        Cell::maybe(measurement.margin()),
        Cell::text(measurement.verdict.name()),
        text(&measurement.paper),
        Cell::text(&measurement.statistic),
    ]
}

/// One row per signal that the message carries.
fn of_signals<'a>(at: Timestamp, heard: &'a Heard<'_>) -> impl Iterator<Item = Row<'a>> {
    heard.form.signals.iter().zip(&heard.values).filter(|(_, value)| value.is_some()).map(
        move |(signal, value)| {
            vec![
                time(at),
                Cell::text(heard.who),
                Cell::text(&heard.form.name),
                Cell::text(&signal.name),
                Cell::maybe(*value),
                Cell::text(&signal.unit),
                heard.line.map_or(Cell::Missing, Cell::text),
            ]
        },
    )
}
