//! The folder of a run's tables.

use super::Format;
use super::cell::{Column, Row};
use super::columns::Table;
use super::csv::CsvTable;
use super::package::{PACKAGE, file_name, is_ours, package};
use super::parquet::ParquetTable;
use super::rows::RowSink;
use super::survey::Survey;
use crate::exported::{Boxed, ExportError};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use wire::time::Timestamp;

/// Writes one file per table. A table without rows has no file.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    format: Format,
    columns: BTreeMap<Table, Vec<Column>>,
    facts: Vec<(&'static str, String)>,
    open: BTreeMap<Table, (OpenTable, u64)>,
}

#[derive(Debug)]
enum OpenTable {
    Csv(Box<CsvTable<BufWriter<File>>>),
    Parquet(Box<ParquetTable<BufWriter<File>>>),
}

impl Folder {
    /// Creates the folder, and removes the tables of an earlier export.
    pub(super) fn create(
        path: &Path,
        format: Format,
        survey: &Survey,
    ) -> Result<Self, ExportError> {
        let failed = |at: &Path, source: std::io::Error| ExportError::write(at, source);
        fs::create_dir_all(path).map_err(|source| failed(path, source))?;
        let index = path.join(PACKAGE);
        let tables = || {
            let each = |table| Format::ALL.map(|format| path.join(file_name(table, format)));
            Table::ALL.into_iter().flat_map(each)
        };
        let mut entries = fs::read_dir(path).map_err(|source| failed(path, source))?;
        if entries.next().is_some() {
            if !is_ours(&index) {
                return Err(ExportError::Foreign { path: path.to_owned() });
            }
            for file in tables().filter(|file| file.exists()) {
                fs::remove_file(&file).map_err(|source| failed(&file, source))?;
            }
        }
        // Written first, so that the rest of a killed export is recognized as ours.
        let begun = format!("{:#}\n", package(survey, format, &[]));
        fs::write(&index, begun).map_err(|source| failed(&index, source))?;
        let header = &survey.header;
        Ok(Self {
            path: path.to_owned(),
            format,
            columns: Table::ALL.map(|table| (table, table.columns(survey))).into(),
            facts: vec![
                ("hil.plan", header.plan.clone()),
                ("hil.seed", header.seed.to_string()),
                ("hil.version", header.harness.clone()),
            ],
            open: BTreeMap::new(),
        })
    }

    /// Ends all files, and writes the package beside them. Returns the number of rows of each table.
    pub(super) fn finish(self, survey: &Survey) -> Result<Vec<(Table, u64)>, ExportError> {
        let mut written = Vec::new();
        for (table, (open, rows)) in self.open {
            let done: Result<(), Boxed> = match open {
                OpenTable::Csv(open) => open.finish().map_err(Boxed::from),
                OpenTable::Parquet(open) => open.finish().map_err(Boxed::from),
            };
            let path = self.path.join(file_name(table, self.format));
            done.map_err(|source| ExportError::Write { path, source })?;
            written.push((table, rows));
        }
        let path = self.path.join(PACKAGE);
        let text = format!("{:#}\n", package(survey, self.format, &written));
        fs::write(&path, text).map_err(|source| ExportError::write(&path, source))?;
        Ok(written)
    }

    fn opened(&self, table: Table) -> Result<OpenTable, Boxed> {
        let columns = self.columns.get(&table).map_or(&[][..], Vec::as_slice);
        let file = BufWriter::new(File::create(self.path.join(file_name(table, self.format)))?);
        Ok(match self.format {
            Format::Csv => OpenTable::Csv(Box::new(CsvTable::new(file, columns)?)),
            Format::Parquet => {
                OpenTable::Parquet(Box::new(ParquetTable::new(file, columns, &self.facts)?))
            }
        })
    }

    fn write(&mut self, table: Table, row: &Row<'_>) -> Result<(), Boxed> {
        if !self.open.contains_key(&table) {
            let opened = self.opened(table)?;
            self.open.insert(table, (opened, 0));
        }
        let Some((open, rows)) = self.open.get_mut(&table) else { return Ok(()) };
        match open {
            OpenTable::Csv(open) => open.row(row)?,
            OpenTable::Parquet(open) => open.row(row)?,
        }
        *rows += 1;
        Ok(())
    }
}

impl RowSink for Folder {
    type Error = ExportError;

    fn row(&mut self, _: Timestamp, table: Table, row: &Row<'_>) -> Result<(), ExportError> {
        let written = self.write(table, row);
        let path = || self.path.join(file_name(table, self.format));
        written.map_err(|source| ExportError::write(&path(), source))
    }
}
