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
pub(crate) mod events;
mod folder;
mod forms;
mod heard;
mod package;
pub mod parquet;
pub(crate) mod rows;
pub mod survey;
#[cfg(test)]
mod tests;

pub use cell::Row;
pub use columns::{Table, tagged};
pub use forms::{MessageForm, SignalForm};
pub use heard::{Ears, Heard};
pub use package::{PACKAGE, PROFILE};
pub use rows::{RowSink, Rows};

use crate::{ExportError, Exported};
use folder::Folder;
use record::outcome::Summary;
use record::run_folder::{RunFolder, RunFolderError};
use std::path::Path;
use survey::Survey;

wire::words! {
    /// Format of the files, by their extension.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Format {
        /// Apache Parquet, zstd-compressed.
        Parquet = "parquet",
        /// CSV (RFC 4180).
        Csv = "csv",
    }
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

/// Reads the surveyed records again, in order, and passes them and the results of the run on to `sink`; `failed` names
/// the file. Returns the survey.
pub(crate) fn pour<S: RowSink>(
    (folder, summary): (&RunFolder, Option<&Summary>),
    (survey, ears): (Survey, Ears),
    sink: &mut S,
    failed: impl Fn(S::Error) -> ExportError,
) -> Result<Survey, ExportError> {
    let mut rows = Rows::new(survey, ears);
    for record in folder.records()? {
        match record {
            Ok(record) => rows.take(&record, sink).map_err(&failed)?,
            Err(_) if rows.survey().cut.is_some() => break,
            // The survey saw no damage here: the file has changed since.
            Err(source) => return Err(folder.unreadable(source).into()),
        }
    }
    if let Some(summary) = summary {
        rows.finish(summary, sink).map_err(failed)?;
    }
    Ok(rows.into_survey())
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
) -> Result<Exported, ExportError> {
    let summary = folder.summary_if_any()?;
    let mut sink = Folder::create(out, format, &survey)?;
    let survey = pour((folder, summary.as_ref()), (survey, ears), &mut sink, |error| error)?;
    let written = sink.finish(&survey)?;
    let named = |(table, rows): (Table, u64)| (table.name().to_owned(), rows);
    Ok(Exported { written: written.into_iter().map(named).collect(), survey })
}
