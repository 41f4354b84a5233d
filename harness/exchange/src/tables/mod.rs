//! A run as tidy tables, for notebooks: `hil export RUN --tables DIR`.
//!
//! One file a table, Parquet or CSV with the same names, kinds and values; `datapackage.json` beside them says what each column
//! is. Time is that of the bench since the run began. Names end in units.
//!
//! * [`Table`]: which tables there are. [`Rows`]: records as their rows. [`cell`]: what these are made of.
//! * [`mod@survey`]: a first pass over the record, for the columns that depend on it.
//! * [`Ears`]: messages and signals of what crossed the lines.
//! * [`csv`], [`parquet`]: the files. A record is read twice and never held: memory does not grow with the run.

mod base;
pub mod cell;
mod columns;
pub mod csv;
mod error;
pub(crate) mod events;
mod folder;
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
pub use heard::{Ears, Heard, MessageForm, SignalForm};
pub use package::{PACKAGE, PROFILE};
pub use row::Row;
pub use rows::{RowSink, Rows};

use folder::Folder;
use record::Record;
use record::run_folder::{RECORD, RunFolder, RunFolderError};
use std::path::Path;
use survey::Survey;

/// The files that tables are written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Apache Parquet, zstd-compressed.
    Parquet,
    /// CSV (RFC 4180).
    Csv,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Parquet, Self::Csv];

    /// Its name, and the end of its files' names.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }
}

/// What was written.
#[derive(Debug)]
pub struct Exported {
    /// The tables and how many rows each has; one without rows has no file.
    pub tables: Vec<(Table, u64)>,
    /// What the record holds, and whether it could be read to its end.
    pub survey: Survey,
}

/// Reads a record once, to see what is in it.
///
/// # Errors
/// When it cannot be opened.
pub fn survey(folder: &RunFolder) -> Result<Survey, RunFolderError> {
    let records = folder.records()?;
    let header = records.header().clone();
    Ok(Survey::of(&header, records))
}

/// Hands over the records again that a survey saw, in their order; `is_cut` where it could not read them to their end.
pub(crate) fn each_record<E: From<RunFolderError>>(
    folder: &RunFolder,
    is_cut: bool,
    take: &mut dyn FnMut(&Record) -> Result<(), E>,
) -> Result<(), E> {
    for record in folder.records()? {
        match record {
            Ok(record) => take(&record)?,
            Err(_) if is_cut => break,
            // Where the survey saw no damage there is one now: the file changed in between.
            Err(source) => {
                return Err(RunFolderError::Record { path: folder.file(RECORD), source }.into());
            }
        }
    }
    Ok(())
}

/// Writes the tables of a run, of which there is a survey, into a folder. A record that is cut short gives the rows before
/// the cut; the survey says so.
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
