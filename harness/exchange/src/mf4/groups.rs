//! Turns rows into records of channel groups.

use crate::tables::cell::{self, Cell, Column, time};
use crate::tables::survey::Survey;
use crate::tables::{Heard, Row, RowSink, Table};
use crate::wide::{Observed, with_signals};
use bus_log::LogError;
use bus_log::mdf4::channels::{Form, GroupId, Kind, Value, Writer};
use plan::observation::Observation;
use std::collections::BTreeMap;
use wire::time::Timestamp;

/// Text columns with a small set of values.
const CHOICES: [&str; 8] =
    ["activity", "health", "level", "causes", "device", "event", "unit", "verdict"];

/// Writes the rows of one run, taken in order.
pub(super) struct Groups<'w> {
    writer: Writer<'w>,
    tables: BTreeMap<Table, GroupId>,
    observed: BTreeMap<String, (GroupId, Observed)>,
    /// By sender and index of the message.
    messages: BTreeMap<(String, usize), GroupId>,
}

impl<'w> Groups<'w> {
    pub(super) fn new(writer: Writer<'w>) -> Self {
        let (tables, observed, messages) = Default::default();
        Self { writer, tables, observed, messages }
    }

    pub(super) fn into_writer(self) -> Writer<'w> {
        self.writer
    }
}

impl RowSink for Groups<'_> {
    type Error = LogError;

    fn row(&mut self, _: Timestamp, table: Table, row: &Row<'_>) -> Result<(), LogError> {
        // Raw traffic is no measured value.
        if matches!(table, Table::Frames | Table::Packets) {
            return Ok(());
        }
        let writer = &mut self.writer;
        let group = *self.tables.entry(table).or_insert_with(|| {
            writer.group(table.name(), table.doc(), forms(table.fixed_columns()))
        });
        writer.record(group, &values(row))
    }

    fn observe(
        &mut self,
        survey: &Survey,
        at: Timestamp,
        observation: &Observation,
        _: &dyn Fn() -> Row<'static>,
    ) -> Result<(), LogError> {
        let quantity = &observation.quantity;
        if !self.observed.contains_key(quantity) {
            let Some(observed) = Observed::new(survey, quantity) else { return Ok(()) };
            let name = format!("observations/{quantity}");
            let group = self.writer.group(&name, survey.title(quantity), forms(&observed.columns));
            self.observed.insert(quantity.clone(), (group, observed));
        }
        let Some((group, observed)) = self.observed.get(quantity) else { return Ok(()) };
        self.writer.record(*group, &values(&observed.row(at, observation)))
    }

    /// The group of a message is created with the first one.
    fn hear(&mut self, at: Timestamp, heard: &Heard<'_>) -> Result<(), LogError> {
        let writer = &mut self.writer;
        let key = (heard.who.to_owned(), heard.index);
        let group = *self.messages.entry(key).or_insert_with(|| {
            let time = &Table::Signals.fixed_columns()[..1];
            let mut channels = forms(&with_signals(time, heard.form));
            for (channel, signal) in channels[1..].iter_mut().zip(&heard.form.signals) {
                channel.names.clone_from(&signal.names);
            }
            let name = format!("messages/{}.{}", heard.who, heard.form.full_name());
            writer.group(&name, &heard.form.doc, channels)
        });
        let mut row = vec![time(at)];
        row.extend(heard.values.iter().map(|value| Cell::maybe(*value)));
        writer.record(group, &values(&row))
    }
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
