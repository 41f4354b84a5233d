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
    let run = json!({ "name": run_field, "type": "string", "unit": "1", "role": Role::Run.name() });
    let columns = dataset.columns.iter().map(|column| {
        let (unit, role) = (column.unit.text(), column.role.name());
        let axis = column.axis.map(Axis::name);
        given(json!({
            "name": column.name, "type": "number", "unit": unit, "role": role, "axis": axis,
        }))
    });
    let fields: Vec<Value> = std::iter::once(run).chain(columns).collect();
    let constants = dataset.constants.iter().map(|(name, constant)| {
        (name.clone(), json!({ "value": constant.value, "unit": constant.unit.text() }))
    });
    let constants: Map<String, Value> = constants.collect();
    let hil = given(json!({
        "kind": dataset.kind.name(),
        "drive": dataset.drive.map(Drive::name),
        "constants": constants,
        "notes": options.notes,
    }));
    let resource = json!({
        "name": TABLE, "path": path, "format": "csv", "mediatype": "text/csv", "encoding": "utf-8",
        "schema": { "fields": fields },
    });
    given(json!({
        "name": dataset.name, "title": options.title, "hil": hil, "resources": [resource],
    }))
}

/// An object without the keys that have no value.
fn given(mut object: Value) -> Value {
    if let Value::Object(object) = &mut object {
        object.retain(|_, value| !value.is_null());
    }
    object
}
