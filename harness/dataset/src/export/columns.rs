//! Rows on their way into a data set.

use crate::{DatasetError, assembled};
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use std::path::Path;

/// A field: name, role and unit.
pub type Field = (&'static str, Role, Unit);

/// The middle of what was observed at its end: what a row says is of the time between.
pub fn middle(tag: impl Fn(&str) -> Option<f64>) -> Option<f64> {
    Some(tag("time")? - tag("duration").unwrap_or(0.0) / 2.0)
}

/// Rows, each with the label of its run.
#[derive(Debug)]
pub struct Columns {
    columns: Vec<Column>,
    runs: Vec<String>,
}

impl Columns {
    /// Empty ones of these fields.
    pub fn new(fields: &[Field]) -> Self {
        let column = |&(name, role, unit): &Field| Column::new(name, role, unit, Vec::new());
        Self { columns: fields.iter().map(column).collect(), runs: Vec::new() }
    }

    /// No row is in them.
    pub const fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Appends a row, a number a field; what is not known is none.
    pub fn push(&mut self, run: String, row: &[Option<f64>]) {
        self.runs.push(run);
        for (column, cell) in self.columns.iter_mut().zip(row) {
            column.values.push(cell.filter(|value| value.is_finite()).unwrap_or(f64::NAN));
        }
    }

    /// Another field, with a value a row.
    pub fn add(&mut self, name: &str, role: Role, unit: Unit, values: Vec<f64>) {
        self.columns.push(Column::new(name, role, unit, values));
    }

    /// A data set, made by the rules for those that are read. Fields of which nothing is known are left out.
    pub fn dataset(mut self, kind: Kind, name: &str, file: &Path) -> Result<Dataset, DatasetError> {
        let needed = |role: Role| {
            kind.required().iter().any(|any| any.iter().any(|all| all.contains(&role)))
        };
        self.columns.retain(|column| {
            needed(column.role) || column.values.iter().any(|value| !value.is_nan())
        });
        assembled(kind, name, file, self.columns, &self.runs)
    }
}
