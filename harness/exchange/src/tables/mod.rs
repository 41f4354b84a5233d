//! A run as tidy tables, for notebooks: `hil export RUN --tables DIR`.
//!
//! One file per table, Parquet or CSV with the same names, types and values; `datapackage.json` beside them describes
//! the columns. Time is bench time since the start of the run. Names end in units.
//!
//! * [`Table`]: the tables. [`Rows`]: records as their rows. [`cell`]: cells and columns.
//! * [`mod@survey`]: a first pass over the record, for the columns that depend on it.
//! * [`Ears`]: messages and signals of the lines' traffic.
//! * [`csv`], [`parquet`]: the files. A record is read twice and never held: memory does not grow with the run.

mod base;
pub mod cell;
mod columns;
pub mod csv;
mod error;
pub(crate) mod events;
mod folder;
mod forms;
mod heard;
mod package;
pub mod parquet;
pub(crate) mod row;
pub(crate) mod rows;
pub mod survey;
#[cfg(test)]
mod tests;

pub use columns::{Table, tagged};
pub use error::TablesError;
pub use forms::{MessageForm, SignalForm};
pub use heard::{Ears, Heard};
pub use package::{PACKAGE, PROFILE};
pub use row::Row;
pub use rows::{RowSink, Rows};

use folder::Folder;
use record::Record;
use record::run_folder::{RECORD, RunFolder, RunFolderError};
use std::path::Path;
use survey::Survey;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Apache Parquet, zstd-compressed.
    Parquet,
    /// CSV (RFC 4180).
    Csv,
}

impl Format {
    pub const ALL: [Self; 2] = [Self::Parquet, Self::Csv];

    /// Its name, which is also the extension of its files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }
}

#[derive(Debug)]
pub struct Exported {
    /// The tables with their numbers of rows; one without rows has no file.
    pub tables: Vec<(Table, u64)>,
    /// Contents of the record, and whether it could be read to its end.
    pub survey: Survey,
}

/// Reads a record once to survey its contents.
///
/// # Errors
/// When the record cannot be opened.
pub fn survey(folder: &RunFolder) -> Result<Survey, RunFolderError> {
    let records = folder.records()?;
    let header = records.header().clone();
    Ok(Survey::of(&header, records))
}

/// Reads the surveyed records again, in order; `is_cut` if the survey could not read them to their end.
pub(crate) fn each_record<E: From<RunFolderError>>(
    folder: &RunFolder,
    is_cut: bool,
    take: &mut dyn FnMut(&Record) -> Result<(), E>,
) -> Result<(), E> {
    for record in folder.records()? {
        match record {
            Ok(record) => take(&record)?,
            Err(_) if is_cut => break,
            // The survey saw no damage here: the file has changed since.
            Err(source) => {
                return Err(RunFolderError::Record { path: folder.file(RECORD), source }.into());
            }
        }
    }
    Ok(())
}

/// Writes the tables of a surveyed run into a folder. A truncated record gives the rows before the cut; the survey
/// reports the cut.
///
/// # Errors
/// When the run cannot be opened, or a table cannot be written.
pub fn export(
    folder: &RunFolder,
    survey: Survey,
    out: &Path,
    format: Format,
    ears: Ears,
) -> Result<Exported, TablesError> {
    let summary = folder.summary_if_any()?;
    let mut sink = Folder::create(out, format, &survey)?;
    let is_cut = survey.cut.is_some();
    let mut rows = Rows::new(survey, ears);
    each_record(folder, is_cut, &mut |record| rows.take(record, &mut sink))?;
    if let Some(summary) = &summary {
        rows.finish(summary, &mut sink)?;
    }
    let survey = rows.into_survey();
    let tables = sink.finish(&survey)?;
    Ok(Exported { tables, survey })
}
