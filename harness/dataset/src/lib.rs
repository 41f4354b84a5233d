//! Measured data as data packages: a folder with `datapackage.json` and tables in CSV, optionally compressed, MDF or ROS bags.
//!
//! A package is a [Frictionless Data Package](https://specs.frictionlessdata.io/data-package/) whose fields have a
//! `unit`, a `role` and optionally an `axis`; `hil` defines what one row is. [`read`] returns the input of
//! [`identification`], or one error that names file, row and field; [`write()`] is the reverse.
//!
//! [`Dataset::notices`] lists what was corrected instead of rejected: missing cells, rows that lack required values,
//! runs of one sample, rows of a run that were not adjacent, repeated and late rows, constant channels, and text converted
//! to numbers.
//!
//! [`export`](mod@export) turns runs into such data.

#![allow(
    missing_docs,
    reason = "a crate of this workspace; what others use is documented where `harness` exports it"
)]

#[cfg(feature = "files")]
mod channels;
mod descriptor;
mod dialect;
mod error;
pub mod export;
#[cfg(feature = "files")]
mod gzip;
mod in_time;
#[cfg(feature = "files")]
mod mdf;
mod package;
mod publish;
#[cfg(not(feature = "files"))]
mod refused;
#[cfg(feature = "files")]
mod ros;
mod rows;
mod table;
#[cfg(test)]
mod tests;
mod thermometer;
mod write;

pub use error::{DatasetError, Defect, Row};
use identification::dataset::{Column, Dataset, Kind};
use package::Format;
pub use publish::{can_publish, publish};
#[cfg(not(feature = "files"))]
use refused::{self as gzip, self as mdf, self as ros};
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
pub use write::{WriteOptions, write};

/// Name of the file that marks a folder as a data package.
pub const DESCRIPTOR: &str = "datapackage.json";

/// The longest descriptor accepted.
const DESCRIPTOR_BYTES_MAX: u64 = 16 * 1024 * 1024;

/// Reads the package at `path`: a folder with a [`DESCRIPTOR`], or that file.
///
/// # Errors
/// The first mistake, with its place. Values stay in the units of the file.
pub fn read(path: &Path) -> Result<Dataset, DatasetError> {
    let file = descriptor_of(path);
    let text = read_text(&file).map_err(|defect| DatasetError::new(&file, defect))?;
    let mut package = package::understand(&file, &text)?;
    let mut rows = table::Rows::new(&package.fields);
    for (index, table) in package.tables.iter().enumerate() {
        let read = match table.format {
            Format::Csv => {
                rows.read(&package.fields, table, index)?;
                continue;
            }
            Format::Mdf => mdf::read,
            Format::RosBag => ros::read,
        };
        read(&mut rows, &package.fields, table, index, &mut package.notices)?;
    }
    rows::assemble(package, rows)
}

/// Whether `path` is a data package, valid or not.
pub fn is_package(path: &Path) -> bool {
    descriptor_of(path).is_file()
}

fn descriptor_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(DESCRIPTOR) } else { path.to_owned() }
}

fn read_text(file: &Path) -> Result<String, Defect> {
    let length = fs::metadata(file).map_err(Defect::Unreadable)?.len();
    if length > DESCRIPTOR_BYTES_MAX {
        return Err(Defect::TooLong { max: DESCRIPTOR_BYTES_MAX, what: "bytes" });
    }
    fs::read_to_string(file).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => Defect::NotText,
        _ => Defect::Unreadable(error),
    })
}

/// A data set from columns that were not read from a table, by the same rules. `labels` gives the run of each row;
/// errors name `file`.
///
/// # Errors
/// See [`read`].
pub(crate) fn assembled(
    kind: Kind,
    name: &str,
    file: &Path,
    columns: Vec<Column>,
    runs: &[String],
) -> Result<Dataset, DatasetError> {
    let (fields, columns): (Vec<_>, Vec<_>) = columns
        .into_iter()
        .map(|Column { name, role, axis, unit, values }| {
            let scale = thermometer::Scale::Celsius;
            (package::Field { name, role, axis, unit, scale, text: false }, values)
        })
        .unzip();
    let mut rows = table::Rows::new(&fields);
    rows.columns = columns;
    rows.number(runs);
    let package = package::Package {
        name: name.to_owned(),
        kind,
        drive: None,
        constants: BTreeMap::new(),
        fields,
        tables: vec![package::Table::of(file)],
        notices: Vec::new(),
    };
    rows::assemble(package, rows)
}
