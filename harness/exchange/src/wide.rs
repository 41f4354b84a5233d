//! Quantities and messages as separate tables, with a column per tag or signal, for formats with many tables.

use crate::mcap::names::Names;
use crate::tables::cell::{Cell, Column, Kind, time};
use crate::tables::survey::Survey;
use crate::tables::{MessageForm, Row, Table, tagged};
use plan::observation::Observation;
use wire::time::Timestamp;

/// Format of the observations of one quantity: time, value, uncertainty and the tags.
#[derive(Debug)]
pub(crate) struct Observed {
    pub(crate) columns: Vec<Column>,
    tags: Vec<String>,
}

impl Observed {
    /// Format of a quantity in the survey; `None` for one beyond its limit, which it has counted.
    pub(crate) fn new(survey: &Survey, quantity: &str) -> Option<Self> {
        let tags = survey.quantities.get(quantity)?;
        let unit = survey.unit(quantity);
        let tags: Vec<&str> = tags.iter().map(String::as_str).collect();
        let number = |name: &'static str, doc: &str| Column {
            unit: unit.to_owned().into(),
            doc: doc.to_owned().into(),
            ..Column::new(name, Kind::Float, "", "")
        };
        let fixed = vec![
            Table::Observations.fixed_columns()[0].clone(),
            number("value", &format!("{quantity}: {}", survey.title(quantity))),
            number("uncertainty", "its standard uncertainty"),
        ];
        let columns = tagged(fixed, &tags);
        Some(Self { columns, tags: tags.into_iter().map(str::to_owned).collect() })
    }

    /// The row of an observation, with a cell per column.
    pub(crate) fn row<'a>(&self, at: Timestamp, observation: &Observation) -> Row<'a> {
        let mut row = vec![time(at), observation.value.into(), observation.uncertainty.into()];
        row.extend(self.tags.iter().map(|tag| Cell::maybe(observation.tags.get(tag).copied())));
        row
    }
}

/// `fixed` columns, followed by one per signal of the message.
pub(crate) fn with_signals(fixed: &[Column], form: &MessageForm) -> Vec<Column> {
    let mut columns = fixed.to_vec();
    let mut names = Names::default();
    for column in &columns {
        names.field(&column.name);
    }
    columns.extend(form.signals.iter().map(|signal| Column {
        name: names.field(&signal.name).into(),
        kind: Kind::Float,
        unit: signal.unit.clone().into(),
        doc: if signal.doc.is_empty() { &signal.name } else { &signal.doc }.clone().into(),
    }));
    columns
}
