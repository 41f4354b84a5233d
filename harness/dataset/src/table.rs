//! Reads a table, from CSV, compressed or not, into columns.

use super::dialect;
use super::error::{DatasetError, Defect, Row};
use super::gzip::unpacked;
use super::package::{Field, Table};
use csv::{ErrorKind, ReaderBuilder, StringRecord};
use identification::dataset::Role;
use record::figures;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::rc::Rc;

/// The most rows of all tables: a week at 100 Hz.
pub(super) const ROWS_MAX: usize = 60_480_000;

/// The most bytes of a table, decompressed: a limit on decompression bombs.
const BYTES_MAX: u64 = 8 * 1024 * 1024 * 1024;

/// The most bytes of a row: an endless row would exhaust the memory.
const ROW_BYTES_MAX: u64 = 1024 * 1024;

/// The first bytes of gzip files (RFC 1952, section 2.3.1).
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

const BUFFER_BYTES: usize = 256 * 1024;

/// Numbers for words, in order of appearance.
#[derive(Debug, Default)]
pub(super) struct Labels {
    pub known: Vec<String>,
    index: BTreeMap<String, usize>,
}

impl Labels {
    fn index_of(&mut self, word: &str) -> usize {
        if let Some(index) = self.index.get(word) {
            return *index;
        }
        let index = self.known.len();
        self.known.push(word.to_owned());
        self.index.insert(word.to_owned(), index);
        index
    }
}

/// A cell in a file.
#[derive(Debug, Clone, Copy)]
pub(super) enum Given<'a> {
    Missing,
    /// From a text file.
    Word(&'a str),
    /// From a numeric file, or a number with a decimal comma.
    Number(f64),
}

/// Place of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Origin {
    pub table: usize,
    pub row: Row,
}

/// The content of the tables, one column per field, with no row dropped or moved yet.
#[derive(Debug)]
pub(super) struct Rows {
    /// Numbers, or codes of words; NaN where a cell is missing. Empty for `run` and `ignore`.
    pub columns: Vec<Vec<f64>>,
    /// The words that the codes of each text field stand for.
    pub words: Vec<Labels>,
    /// Run of each row; `None` if the cell is missing.
    pub runs: Vec<Option<usize>>,
    pub run_labels: Labels,
    pub origins: Vec<Origin>,
    /// Indices of the tables whose last line has no line break.
    pub unended: Vec<usize>,
}

impl Rows {
    pub(super) fn new(fields: &[Field]) -> Self {
        Self {
            columns: vec![Vec::new(); fields.len()],
            words: fields.iter().map(|_| Labels::default()).collect(),
            runs: Vec::new(),
            run_labels: Labels::default(),
            origins: Vec::new(),
            unended: Vec::new(),
        }
    }

    /// Appends the content of `table`, which has this `index`.
    pub(super) fn read(
        &mut self,
        fields: &[Field],
        table: &Table,
        index: usize,
    ) -> Result<(), DatasetError> {
        self.read_rows(fields, table, index).map_err(|error| match damage(table) {
            // A mistake in a row may be caused by a damaged file.
            Some(defect @ Defect::Damaged(_)) => DatasetError::new(&table.path, defect),
            _ => error,
        })
    }

    fn read_rows(
        &mut self,
        fields: &[Field],
        table: &Table,
        index: usize,
    ) -> Result<(), DatasetError> {
        let fail = |defect| DatasetError::new(&table.path, defect);
        let in_row = Rc::new(Cell::new(0));
        let last = Rc::new(Cell::new(0));
        let input = open(table).map_err(|error| fail(of_io(error)))?;
        let input = Rowwise { input, in_row: Rc::clone(&in_row), last: Rc::clone(&last) };
        // Ragged rows are detected here, where the error can be worded better.
        let mut reader = ReaderBuilder::new()
            .delimiter(table.delimiter)
            .flexible(true)
            .has_headers(false)
            .buffer_capacity(BUFFER_BYTES)
            .from_reader(input);
        let mut record = StringRecord::new();
        // For the reader a row ends at its carriage return, and the line feed after it belongs to the next one.
        let mut own_feeds = 1;
        // The line on which the row begins, or `None` at the end.
        let mut next = |record: &mut StringRecord, number: u64| -> Result<_, DatasetError> {
            let before = reader.position().line();
            in_row.set(0);
            let is_row = reader.read_record(record).map_err(|error| {
                let line = error.position().map_or(before, csv::Position::line) + 1 - own_feeds;
                let error = fail(of_csv(error));
                match (number, error.defect()) {
                    // A compressed file that is damaged has no lines yet.
                    (0, Defect::NotText) | (1.., _) => error.at_row(Row { number, line }),
                    _ => error,
                }
            })?;
            let after = reader.position().line();
            // Rows of several lines and blank lines are rare.
            let inside = if after - before > 1 { feeds(record) } else { 0 };
            if number == 0 {
                own_feeds = after.saturating_sub(before + inside).min(1);
            }
            Ok(is_row.then(|| before.max(after.saturating_sub(inside + own_feeds))))
        };
        if next(&mut record, 0)?.is_none() {
            return Err(fail(Defect::Empty));
        }
        let places = places(fields, &record, table)?;
        let has_comma = |field: &Field| !field.text && table.commas.contains(&field.name);
        let has_comma: Vec<bool> = fields.iter().map(has_comma).collect();
        let width = record.len();
        let run_of_table = self.run_of(fields, table);
        for number in 1.. {
            let Some(line) = next(&mut record, number)? else { break };
            let row = Row { number, line };
            if record.len() != width {
                let defect = Defect::Ragged { found: record.len(), expected: width };
                return Err(fail(defect).at_row(row));
            }
            self.begin_row(Origin { table: index, row }, run_of_table).map_err(fail)?;
            for (at, field) in fields.iter().enumerate() {
                let cell = places.get(at).and_then(|place| record.get(*place)).unwrap_or("").trim();
                let cell = Some(cell).filter(|cell| !table.missing.contains(*cell));
                let cell = match cell {
                    None => Ok(Given::Missing),
                    Some(cell) if has_comma[at] => with_comma(cell).map(Given::Number),
                    Some(cell) => Ok(Given::Word(cell)),
                };
                cell.and_then(|cell| self.take(at, field, cell))
                    .map_err(|defect| fail(defect).at_row(row).in_field(&field.name))?;
            }
        }
        if !matches!(last.get(), b'\n' | b'\r') {
            self.unended.push(index);
        }
        Ok(())
    }

    /// Adds one row for each of these run labels.
    pub(super) fn number(&mut self, labels: &[String]) {
        for (label, number) in labels.iter().zip(1..) {
            let run = self.run_labels.index_of(label);
            self.runs.push(Some(run));
            self.origins.push(Origin { table: 0, row: Row { number, line: number } });
        }
    }

    /// The common run of all rows of a table, if no field gives the run.
    pub(super) fn run_of(&mut self, fields: &[Field], table: &Table) -> Option<usize> {
        let has_runs = fields.iter().any(|field| field.role == Role::Run);
        if has_runs { None } else { Some(self.run_labels.index_of(&table.name)) }
    }

    /// Begins a row; [`Self::take`] then takes one cell per field.
    pub(super) fn begin_row(&mut self, origin: Origin, run: Option<usize>) -> Result<(), Defect> {
        if self.origins.len() == ROWS_MAX {
            return Err(Defect::TooLong { max: ROWS_MAX as u64, what: "rows" });
        }
        self.runs.push(run);
        self.origins.push(origin);
        Ok(())
    }

    /// Takes the cell of the field at this index, in the current row.
    pub(super) fn take(&mut self, at: usize, field: &Field, cell: Given<'_>) -> Result<(), Defect> {
        match field.role {
            Role::Ignore => return Ok(()),
            Role::Run => {
                let run = match cell {
                    Given::Missing => None,
                    Given::Word(label) => Some(self.run_labels.index_of(label)),
                    Given::Number(number) => Some(self.run_labels.index_of(&number.to_string())),
                };
                if let (Some(of_row), Some(run)) = (self.runs.last_mut(), run) {
                    *of_row = Some(run);
                }
                return Ok(());
            }
            _ => {}
        }
        let value = match cell {
            Given::Missing => f64::NAN,
            Given::Word(word) if field.text => self.words[at].index_of(word) as f64,
            Given::Number(number) if field.text => {
                self.words[at].index_of(&number.to_string()) as f64
            }
            Given::Word(word) => number(word)?,
            Given::Number(number) => number,
        };
        if field.role == Role::Direction && !value.is_nan() && value.abs() != 1.0 {
            return Err(Defect::Direction(value));
        }
        self.columns[at].push(value);
        Ok(())
    }
}

/// The line feeds in the cells of a row.
fn feeds(record: &StringRecord) -> u64 {
    record.iter().map(|cell| cell.matches('\n').count() as u64).sum()
}

fn number(cell: &str) -> Result<f64, Defect> {
    finite(cell, cell.parse().ok())
}

/// A number whose decimal sign is a comma. A point in it may be one of thousands: it is refused.
fn with_comma(cell: &str) -> Result<f64, Defect> {
    let value = (!cell.contains('.')).then(|| cell.replacen(',', ".", 1).parse().ok());
    finite(cell, value.flatten())
}

fn finite(cell: &str, value: Option<f64>) -> Result<f64, Defect> {
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(Defect::NotFinite(cell.to_owned())),
        None => Err(Defect::NotANumber(cell.to_owned())),
    }
}

/// Index of each field in a row.
fn places(
    fields: &[Field],
    header: &StringRecord,
    table: &Table,
) -> Result<Vec<usize>, DatasetError> {
    let fail = |defect, field: &str| Err(DatasetError::new(&table.path, defect).in_field(field));
    let names: Vec<&str> = header.iter().map(str::trim).collect();
    let known = |name: &str| fields.iter().any(|field| field.name.trim() == name);
    for (at, name) in names.iter().enumerate() {
        if names[..at].contains(name) {
            return fail(Defect::NameTwice, name);
        }
        if !known(name) {
            return match dialect::other(&names, known, table.delimiter) {
                Some(seen) => {
                    let defect = Defect::Delimiter { used: char::from(table.delimiter), seen };
                    Err(DatasetError::new(&table.path, defect))
                }
                None => fail(Defect::NotInSchema, name),
            };
        }
    }
    let mut places = Vec::with_capacity(fields.len());
    for field in fields {
        match names.iter().position(|name| *name == field.name.trim()) {
            Some(place) => places.push(place),
            None => return fail(Defect::NotInHeader, &field.name),
        }
    }
    Ok(places)
}

/// The text of the table, decompressed. The first bytes show whether it is compressed.
fn open(table: &Table) -> io::Result<Box<dyn Read>> {
    let mut file = BufReader::with_capacity(BUFFER_BYTES, File::open(&table.path)?);
    let packed = file.fill_buf()?.starts_with(&GZIP_MAGIC);
    let named_so = table.path.extension().is_some_and(|extension| extension == "gz");
    Ok(if packed || named_so {
        Box::new(Limited { input: unpacked(file)?, left: BYTES_MAX })
    } else {
        Box::new(Limited { input: file, left: BYTES_MAX })
    })
}

/// The defect that prevents reading the file to its end.
fn damage(table: &Table) -> Option<Defect> {
    let read = open(table).and_then(|mut input| io::copy(&mut input, &mut io::sink()));
    read.err().map(of_io)
}

/// An input that fails after too many bytes.
struct Limited<R> {
    input: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        let left = self.left.checked_sub(read as u64);
        self.left = left.ok_or_else(|| io::Error::from(io::ErrorKind::FileTooLarge))?;
        Ok(read)
    }
}

/// An input that fails when a row has too many bytes.
struct Rowwise<R> {
    input: R,
    /// Bytes read since the row began; the reader of rows resets it.
    in_row: Rc<Cell<u64>>,
    /// The last byte so far.
    last: Rc<Cell<u8>>,
}

impl<R: Read> Read for Rowwise<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.in_row.get() > ROW_BYTES_MAX {
            return Err(io::ErrorKind::QuotaExceeded.into());
        }
        let read = self.input.read(buffer)?;
        self.in_row.set(self.in_row.get() + read as u64);
        if let Some(last) = buffer.get(..read).and_then(<[u8]>::last) {
            self.last.set(*last);
        }
        Ok(read)
    }
}

fn of_csv(error: csv::Error) -> Defect {
    match error.into_kind() {
        ErrorKind::Io(error) => of_io(error),
        ErrorKind::Utf8 { .. } => Defect::NotText,
        other => Defect::Unreadable(io::Error::other(format!("{other:?}"))),
    }
}

fn of_io(error: io::Error) -> Defect {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => Defect::CutShort,
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => Defect::Damaged(error),
        io::ErrorKind::FileTooLarge => Defect::TooLong { max: BYTES_MAX, what: "bytes" },
        io::ErrorKind::QuotaExceeded => {
            Defect::TooLong { max: ROW_BYTES_MAX, what: "bytes in a row" }
        }
        _ => Defect::Unreadable(error),
    }
}

/// The beginning of a notice about rows that are not used.
pub(crate) fn left_out(count: usize) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("{} {verb} left out", figures::counted(count as u64, "row", "rows"))
}
