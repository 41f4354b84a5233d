//! Collects rows for a data set.

use crate::{DatasetError, assembled};
use identification::dataset::{Column, Dataset, Kind, Role, Unit};
use std::path::Path;

/// A field: name, role and unit.
pub type Field = (&'static str, Role, Unit);

/// The middle of the interval of an observation, whose time is that of its end.
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
    /// An empty table with these fields.
    pub fn new(fields: &[Field]) -> Self {
        let column = |&(name, role, unit): &Field| Column::new(name, role, unit, Vec::new());
        Self { columns: fields.iter().map(column).collect(), runs: Vec::new() }
    }

    /// Whether there are no rows.
    pub const fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Appends a row with one number per field; `None` if unknown.
    pub fn push(&mut self, run: String, row: &[Option<f64>]) {
        self.runs.push(run);
        for (column, cell) in self.columns.iter_mut().zip(row) {
            column.values.push(cell.filter(|value| value.is_finite()).unwrap_or(f64::NAN));
        }
    }

    /// Adds a field with one value per row.
    pub fn add(&mut self, name: &str, role: Role, unit: Unit, values: Vec<f64>) {
        self.columns.push(Column::new(name, role, unit, values));
    }

    /// Builds a data set by the same rules as for tables that are read. Fields without any value are left out.
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
