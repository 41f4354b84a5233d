//! Writes a data set as a package that [`super::read`] reads back.

use super::DESCRIPTOR;
use super::gzip::packed;
use super::publish::publish;
use identification::dataset::{Axis, Dataset, Drive, Role};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::{fs, io};

/// Name of the run field, unless another field has it.
const RUN_FIELD: &str = "run";

/// Name of the single table, without extension.
const TABLE: &str = "data";

/// Options for writing a package.
#[derive(Debug, Clone, Default)]
pub struct WriteOptions {
    /// Whether to compress the table.
    pub compressed: bool,
    /// Title for readers.
    pub title: Option<String>,
    /// Further notes for readers, under `hil.notes`.
    pub notes: Option<String>,
}

/// Writes `dataset` as a package into `folder`, which is created if needed. Writes everything or nothing. Words that
/// were numbered stay numbers; notices are not stored.
///
/// # Errors
/// When a file cannot be written.
pub fn write(dataset: &Dataset, folder: &Path, options: &WriteOptions) -> io::Result<()> {
    let (mut name, mut other) = (format!("{TABLE}.csv"), format!("{TABLE}.csv.gz"));
    if options.compressed {
        std::mem::swap(&mut name, &mut other);
    }
    let run_field = run_field(dataset);
    let table = table(dataset, &run_field)?;
    let table = if options.compressed { packed(&table)? } else { table };
    let mut text = serde_json::to_string_pretty(&descriptor(dataset, &run_field, &name, options))?;
    text.push('\n');
    publish(folder, &[(name, table), (DESCRIPTOR.to_owned(), text.into_bytes())])?;
    // The table of a package that was written before, which no descriptor names any more.
    match fs::remove_file(folder.join(other)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn run_field(dataset: &Dataset) -> String {
    let mut name = RUN_FIELD.to_owned();
    while dataset.named(&name).is_some() {
        name.push('_');
    }
    name
}

fn table(dataset: &Dataset, run_field: &str) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = dataset.columns.iter().map(|column| column.name.as_str());
    writer.write_record(std::iter::once(run_field).chain(names))?;
    let mut cells: Vec<String> = vec![String::new(); dataset.columns.len() + 1];
    for (row, run) in dataset.run_of_row.iter().enumerate() {
        cells[0].clone_from(&dataset.run_labels[*run]);
        for (cell, column) in cells[1..].iter_mut().zip(&dataset.columns) {
            let value = column.values[row];
            // The shortest text that parses to the same number.
            *cell = if value.is_nan() { String::new() } else { format!("{value}") };
        }
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(csv::IntoInnerError::into_error)
}

fn descriptor(dataset: &Dataset, run_field: &str, path: &str, options: &WriteOptions) -> Value {
    let mut fields =
        vec![json!({ "name": run_field, "type": "string", "unit": "1", "role": Role::Run.name() })];
    fields.extend(dataset.columns.iter().map(|column| {
        let mut field = Map::new();
        field.insert("name".to_owned(), json!(column.name));
        field.insert("type".to_owned(), json!("number"));
        field.insert("unit".to_owned(), json!(column.unit.text()));
        field.insert("role".to_owned(), json!(column.role.name()));
        let axis = column.axis.map(|axis| match axis {
            Axis::X => "x",
            Axis::Y => "y",
            Axis::Z => "z",
        });
        field.extend(axis.map(|axis| ("axis".to_owned(), json!(axis))));
        Value::Object(field)
    }));
    let mut hil = Map::new();
    hil.insert("kind".to_owned(), json!(dataset.kind.name()));
    let drive = dataset.drive.map(Drive::name);
    hil.extend(drive.map(|drive| ("drive".to_owned(), json!(drive))));
    let constants: Map<String, Value> = dataset
        .constants
        .iter()
        .map(|(name, constant)| {
            (name.clone(), json!({ "value": constant.value, "unit": constant.unit.text() }))
        })
        .collect();
    hil.insert("constants".to_owned(), Value::Object(constants));
    hil.extend(options.notes.as_ref().map(|notes| ("notes".to_owned(), json!(notes))));
    let mut package = Map::new();
    package.insert("name".to_owned(), json!(dataset.name));
    package.extend(options.title.as_ref().map(|title| ("title".to_owned(), json!(title))));
    package.insert("hil".to_owned(), Value::Object(hil));
    let resource = json!({
        "name": TABLE, "path": path, "format": "csv", "mediatype": "text/csv", "encoding": "utf-8",
        "schema": { "fields": fields },
    });
    package.insert("resources".to_owned(), json!([resource]));
    Value::Object(package)
}
