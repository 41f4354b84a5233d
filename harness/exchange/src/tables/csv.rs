//! A table as CSV (RFC 4180): UTF-8, a header row, line feeds.

use super::cell::{Cell, Column, Row};
use std::io::Write;

#[derive(Debug)]
pub struct CsvTable<W: Write> {
    writer: csv::Writer<W>,
    line: csv::StringRecord,
}

impl<W: Write> CsvTable<W> {
    /// Writes the names of the columns.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn new(out: W, columns: &[Column]) -> csv::Result<Self> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(columns.iter().map(|column| column.name.as_bytes()))?;
        Ok(Self { writer, line: csv::StringRecord::new() })
    }

    /// Writes a row. A number is the shortest text that parses to the same number; a real number has a point or an
    /// exponent, so that readers can infer the type.
    ///
    /// # Errors
    /// When the row cannot be written.
    pub fn row(&mut self, row: &Row<'_>) -> csv::Result<()> {
        self.line.clear();
        for cell in row {
            match cell {
                Cell::Missing => self.line.push_field(""),
                Cell::Float(number) => self.line.push_field(&format!("{number:?}")),
                Cell::Integer(number) => self.line.push_field(&number.to_string()),
                Cell::Bool(yes) => self.line.push_field(if *yes { "true" } else { "false" }),
                Cell::Text(text) => self.line.push_field(text),
            }
        }
        self.writer.write_record(&self.line)
    }

    /// Flushes the file.
    ///
    /// # Errors
    /// When the rest cannot be written.
    pub fn finish(mut self) -> csv::Result<()> {
        Ok(self.writer.flush()?)
    }
}
