//! Measured data of the four kinds of the contract. The caller reads the files.

mod role;
mod unit;

use crate::error::IdentifyError;
pub use role::{Alternatives, Axis, Drive, Kind, Role};
use std::collections::BTreeMap;
pub use unit::{Dimension, Unit};

/// A number with its unit, as a package declares it (`wheelbase`, say).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// In `unit`.
    pub value: f64,
    /// Its unit.
    pub unit: Unit,
}

impl Constant {
    /// Of a package: how much later than the wheels the reference comes.
    pub(crate) const REFERENCE_DELAY: &str = "reference_delay";
    /// Of a package: how far to the left of the middle of the axle the reference sits.
    pub(crate) const REFERENCE_LEFT: &str = "reference_left_of_axle";
    /// Of a package: that speeds of wheels are means since the row before.
    pub(crate) const MEAN_SPEED: &str = "mean_speed";

    /// In SI units.
    pub(crate) fn si(&self) -> f64 {
        self.value * self.unit.si()
    }

    /// Of a data set that was set right: the noise of a reference before it was evened out. Some of it stays, and no longer
    /// looks like noise.
    pub(crate) fn noise_of(reference: &str) -> String {
        format!("noise of {reference}")
    }

    /// Of a data set that was set right: the time over which a reference was evened out both ways.
    pub(crate) fn evened(reference: &str) -> String {
        format!("width of {reference}")
    }
}

/// A numeric field. A missing cell is NaN; no other value is non-finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the field in the file.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Its axis, if there are several.
    pub axis: Option<Axis>,
    /// Unit of `values`, as in the file.
    pub unit: Unit,
    /// One per row, in `unit`.
    pub values: Vec<f64>,
}

/// A data set: columns of equal length, rows grouped into runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Dataset {
    /// Name of the package.
    pub name: String,
    /// What one row is.
    pub kind: Kind,
    /// How the robot is driven, for `odometry`.
    pub drive: Option<Drive>,
    /// Constants that the package declares.
    pub constants: BTreeMap<String, Constant>,
    /// Numeric fields, without the run.
    pub columns: Vec<Column>,
    /// Run of each row, as an index into `run_labels`. Rows of one run are contiguous. Data without runs are one run.
    pub run_of_row: Vec<usize>,
    /// Labels of the runs, in order of appearance.
    pub run_labels: Vec<String>,
    /// What was left out or repaired while reading, one sentence each.
    pub notices: Vec<String>,
}

impl Dataset {
    /// A data set of these columns with the run of each row, counted from 0; the run numbers serve as labels.
    pub fn new(name: &str, kind: Kind, columns: Vec<Column>, run_of_row: Vec<usize>) -> Self {
        let runs = run_of_row.iter().max().map_or(0, |last| last + 1);
        Self {
            name: name.to_owned(),
            kind,
            drive: None,
            constants: BTreeMap::new(),
            columns,
            run_of_row,
            run_labels: (0..runs).map(|run| run.to_string()).collect(),
            notices: Vec::new(),
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.run_of_row.len()
    }

    /// The first column with that role, whatever its axis.
    pub fn column(&self, role: Role) -> Option<&Column> {
        self.columns.iter().find(|column| column.role == role)
    }

    /// The first column with that role, without which nothing can be identified.
    pub(crate) fn required(&self, role: Role, what: &str) -> Result<&Column, IdentifyError> {
        self.column(role).ok_or_else(|| IdentifyError::missing(what))
    }

    /// All columns with that role.
    pub fn columns_of(&self, role: Role) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(move |column| column.role == role)
    }

    /// The column with that name.
    pub fn named(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }
}

impl Column {
    /// A column without an axis.
    pub fn new(name: &str, role: Role, unit: Unit, values: Vec<f64>) -> Self {
        Self { name: name.to_owned(), role, axis: None, unit, values }
    }

    /// Values in SI (radians, seconds, metres); temperatures in degrees Celsius.
    pub fn si(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        let factor = self.unit.si();
        self.values.iter().map(move |value| value * factor)
    }
}
