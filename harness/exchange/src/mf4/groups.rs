//! Turns records into those of channel groups.

use crate::tables::cell::{self, Cell, Column};
use crate::tables::events;
use crate::tables::row::time;
use crate::tables::rows;
use crate::tables::survey::Survey;
use crate::tables::{Ears, Heard, Row, Table};
use crate::wide::{Observed, with_signals};
use bus_log::LogError;
use bus_log::mdf4::channels::{Form, GroupId, Kind, Value, Writer};
use controller::mission::Report;
use plan::observation::Observation;
use record::outcome::Summary;
use record::{Record, RecordKind};
use std::collections::BTreeMap;
use std::io::{Seek, Write};
use wire::time::Timestamp;

/// Text columns with a small set of values.
const CHOICES: [&str; 8] =
    ["activity", "health", "level", "causes", "device", "event", "unit", "verdict"];

/// Writes the records of one run, taken in order.
pub(super) struct Groups<W: Write + Seek> {
    writer: Writer<W>,
    survey: Survey,
    ears: Ears,
    tables: BTreeMap<Table, GroupId>,
    observed: BTreeMap<String, (GroupId, Observed)>,
    /// By sender and index of the message.
    messages: BTreeMap<(String, usize), GroupId>,
}

impl<W: Write + Seek> Groups<W> {
    pub(super) fn new(writer: Writer<W>, survey: Survey, ears: Ears) -> Self {
        let (tables, observed, messages) = Default::default();
        Self { writer, survey, ears, tables, observed, messages }
    }

    pub(super) fn into_parts(self) -> (Writer<W>, Survey) {
        (self.writer, self.survey)
    }

    pub(super) fn take(&mut self, record: &Record) -> Result<(), LogError> {
        let at = record.at;
        match &record.kind {
            RecordKind::Report(Report::State(state)) => {
                self.row(Table::States, &rows::of_state(at, state))?;
            }
            RecordKind::Report(Report::Health(health)) => {
                self.row(Table::Health, &rows::of_health(at, health))?;
            }
            RecordKind::Truth { pose, bias_rad_per_s, coil_celsius } => {
                let row = rows::of_truth(at, *pose, *bias_rad_per_s, *coil_celsius);
                self.row(Table::Truth, &row)?;
            }
            RecordKind::Observation(observation) => self.observe(at, observation)?,
            _ => {}
        }
        if let Some(event) = events::of(record) {
            self.row(Table::Events, &event.row())?;
        }
        let mut done = Ok(());
        let Self { ears, writer, messages, .. } = self;
        ears.take(record, &mut |heard| {
            if done.is_ok() {
                done = say(writer, messages, at, heard);
            }
        });
        done
    }

    pub(super) fn finish(&mut self, summary: &Summary) -> Result<(), LogError> {
        let end = self.survey.end;
        for measurement in &summary.measurements {
            self.row(Table::Measurements, &rows::of_measurement(end, measurement))?;
        }
        for event in events::of_summary(end, summary) {
            self.row(Table::Events, &event.row())?;
        }
        Ok(())
    }

    fn row(&mut self, table: Table, row: &Row<'_>) -> Result<(), LogError> {
        let writer = &mut self.writer;
        let group = *self.tables.entry(table).or_insert_with(|| {
            writer.group(table.name(), table.doc(), forms(table.fixed_columns()))
        });
        writer.record(group, &values(row))
    }

    fn observe(&mut self, at: Timestamp, observation: &Observation) -> Result<(), LogError> {
        let quantity = &observation.quantity;
        if !self.observed.contains_key(quantity) {
            let Some(observed) = Observed::new(&self.survey, quantity) else { return Ok(()) };
            let name = format!("observations/{quantity}");
            let doc = self.survey.title(quantity);
            let group = self.writer.group(&name, doc, forms(&observed.columns));
            self.observed.insert(quantity.clone(), (group, observed));
        }
        let Some((group, observed)) = self.observed.get(quantity) else { return Ok(()) };
        self.writer.record(*group, &values(&observed.row(at, observation)))
    }
}

/// Writes a record of a message's group, which is created with the first one.
fn say<W: Write + Seek>(
    writer: &mut Writer<W>,
    messages: &mut BTreeMap<(String, usize), GroupId>,
    at: Timestamp,
    heard: &Heard<'_>,
) -> Result<(), LogError> {
    let key = (heard.who.to_owned(), heard.index);
    let group = *messages.entry(key).or_insert_with(|| {
        let time = &Table::Signals.fixed_columns()[..1];
        let mut channels = forms(&with_signals(time, heard.form));
        for (channel, signal) in channels[1..].iter_mut().zip(&heard.form.signals) {
            channel.names.clone_from(&signal.names);
        }
        let name = format!("messages/{}.{}", heard.who, heard.form.name);
        writer.group(&name, &heard.form.doc, channels)
    });
    let mut row = vec![time(at)];
    row.extend(heard.values.iter().map(|value| Cell::maybe(*value)));
    writer.record(group, &values(&row))
}

fn forms(columns: &[Column]) -> Vec<Form> {
    let form = |column: &Column| Form {
        name: column.name.to_string(),
        kind: match column.kind {
            cell::Kind::Float => Kind::Float,
            cell::Kind::Integer => Kind::Integer,
            cell::Kind::Bool => Kind::Bool,
            cell::Kind::Text if CHOICES.contains(&&*column.name) => Kind::Choice,
            cell::Kind::Text => Kind::Text,
        },
        unit: column.unit.to_string(),
        doc: column.doc.to_string(),
        names: Vec::new(),
    };
    columns.iter().map(form).collect()
}

fn values<'a>(row: &'a Row<'_>) -> Vec<Value<'a>> {
    let value = |cell: &'a Cell<'_>| match cell {
        Cell::Missing => Value::Missing,
        Cell::Float(number) => Value::Float(*number),
        Cell::Integer(number) => Value::Integer(*number),
        Cell::Bool(yes) => Value::Bool(*yes),
        Cell::Text(text) => Value::Text(text),
    };
    row.iter().map(value).collect()
}
