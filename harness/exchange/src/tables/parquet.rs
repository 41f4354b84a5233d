//! A table as Apache Parquet, zstd-compressed.
//!
//! Every column is optional. Units and meanings of the columns are in the file's metadata under the key `hil.columns`,
//! as JSON: `{"x_m": {"unit": "m", "description": "..."}}`.

use super::cell::{Cell, Column, Kind, Row};
use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::{Value, json};
use std::io::Write;
use std::sync::Arc;

/// Rows buffered for one row group. For states this takes about 10 MB of memory, and readers that skip groups have
/// something to skip.
const GROUP_ROWS_MAX: usize = 65_536;

/// Bytes of text buffered for one row group, whatever the number of rows.
const GROUP_TEXT_BYTES_MAX: usize = 16 * 1024 * 1024;

pub const COLUMNS_KEY: &str = "hil.columns";

pub struct ParquetTable<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: Vec<Kept>,
    rows: usize,
    text_bytes: usize,
}

/// Buffered values of a column, and which rows have one.
#[derive(Debug)]
struct Kept {
    kind: Kind,
    present: Vec<i16>,
    values: Values,
}

#[derive(Debug)]
enum Values {
    Float(Vec<f64>),
    Integer(Vec<i64>),
    Bool(Vec<bool>),
    Text(Vec<ByteArray>),
}

impl<W: Write + Send> std::fmt::Debug for ParquetTable<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ParquetTable").field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl<W: Write + Send> ParquetTable<W> {
    /// Writes the start of the file. `facts` go into its metadata.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(out: W, columns: &[Column], facts: &[(&str, String)]) -> Result<Self> {
        let fields = columns.iter().map(field).collect::<Result<Vec<_>>>()?;
        let schema = Type::group_type_builder("hil").with_fields(fields).build()?;
        let meaning = (COLUMNS_KEY, meaning_of(columns).to_string());
        let facts = facts.iter().map(|(key, value)| (*key, value.clone())).chain([meaning]);
        let facts = facts.map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_key_value_metadata(Some(facts))
            .build();
        Ok(Self {
            writer: SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?,
            columns: columns.iter().map(|column| Kept::of(column.kind)).collect(),
            rows: 0,
            text_bytes: 0,
        })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// When a row group cannot be written, or when a cell is not of its column's type.
    pub fn row(&mut self, row: &Row<'_>) -> Result<()> {
        if row.len() != self.columns.len() {
            return Err(ParquetError::General(format!(
                "a row of {} cells for {} columns",
                row.len(),
                self.columns.len()
            )));
        }
        for (kept, cell) in self.columns.iter_mut().zip(row) {
            self.text_bytes += kept.push(cell)?;
        }
        self.rows += 1;
        if self.rows >= GROUP_ROWS_MAX || self.text_bytes >= GROUP_TEXT_BYTES_MAX {
            self.write_group()?;
        }
        Ok(())
    }

    /// Writes the end of the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<()> {
        if self.rows > 0 {
            self.write_group()?;
        }
        self.writer.close().map(|_| ())
    }

    fn write_group(&mut self) -> Result<()> {
        let mut group = self.writer.next_row_group()?;
        for kept in &mut self.columns {
            let Some(mut column) = group.next_column()? else { break };
            kept.write(column.untyped())?;
            column.close()?;
            *kept = Kept::of(kept.kind);
        }
        group.close()?;
        (self.rows, self.text_bytes) = (0, 0);
        Ok(())
    }
}

impl Kept {
    const fn of(kind: Kind) -> Self {
        let values = match kind {
            Kind::Float => Values::Float(Vec::new()),
            Kind::Integer => Values::Integer(Vec::new()),
            Kind::Bool => Values::Bool(Vec::new()),
            Kind::Text => Values::Text(Vec::new()),
        };
        Self { kind, present: Vec::new(), values }
    }

    /// Adds a cell; returns its bytes of text.
    fn push(&mut self, cell: &Cell<'_>) -> Result<usize> {
        let mut text_bytes = 0;
        match (&mut self.values, cell) {
            (_, Cell::Missing) => {}
            (Values::Float(values), Cell::Float(value)) => values.push(*value),
            (Values::Integer(values), Cell::Integer(value)) => values.push(*value),
            (Values::Bool(values), Cell::Bool(value)) => values.push(*value),
            (Values::Text(values), Cell::Text(value)) => {
                text_bytes = value.len();
                values.push(ByteArray::from(value.as_bytes().to_vec()));
            }
            (_, cell) => return Err(ParquetError::General(format!("{cell:?} in another column"))),
        }
        self.present.push(i16::from(*cell != Cell::Missing));
        Ok(text_bytes)
    }

    fn write(&self, column: &mut ColumnWriter<'_>) -> Result<()> {
        let present = Some(self.present.as_slice());
        match (&self.values, column) {
            (Values::Float(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
            }
            (Values::Integer(values), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
            }
            (Values::Bool(values), ColumnWriter::BoolColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
            }
            (Values::Text(values), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                writer.write_batch(values, present, None)?;
            }
            _ => return Err(ParquetError::General("a column of another kind".to_owned())),
        }
        Ok(())
    }
}

fn field(column: &Column) -> Result<Arc<Type>> {
    let (physical, logical) = match column.kind {
        Kind::Float => (PhysicalType::DOUBLE, None),
        Kind::Integer => (PhysicalType::INT64, None),
        Kind::Bool => (PhysicalType::BOOLEAN, None),
        Kind::Text => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let field = Type::primitive_type_builder(&column.name, physical);
    let field = field.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
    Ok(Arc::new(field.build()?))
}

fn meaning_of(columns: &[Column]) -> Value {
    let meaning = |column: &Column| {
        (column.name.to_string(), json!({ "unit": column.unit, "description": column.doc }))
    };
    Value::Object(columns.iter().map(meaning).collect())
}
