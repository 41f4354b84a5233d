//! A data set as the text of a data package.

use identification::dataset::{Column, Dataset, Role};
use serde_json::{Value, json};
use std::fmt::Write;

/// Name of the table's file.
pub const CSV: &str = "data.csv";

/// The text of `datapackage.json`.
pub fn descriptor(dataset: &Dataset) -> Value {
    let field = |column: &Column| {
        let mut field = json!({
            "name": column.name, "type": "number", "unit": column.unit, "role": column.role,
        });
        if let Some(axis) = column.axis {
            field["axis"] = json!(axis);
        }
        field
    };
    let run = json!({ "name": "run", "type": "string", "unit": "1", "role": Role::Run });
    let fields: Vec<Value> =
        std::iter::once(run).chain(dataset.columns.iter().map(field)).collect();
    let constants: serde_json::Map<String, Value> = dataset
        .constants
        .iter()
        .map(|(name, c)| (name.clone(), json!({ "value": c.value, "unit": c.unit })))
        .collect();
    let mut hil = json!({ "kind": dataset.kind, "constants": constants });
    if let Some(drive) = dataset.drive {
        hil["drive"] = json!(drive);
    }
    json!({
        "name": dataset.name,
        "hil": hil,
        "resources": [{
            "name": "data", "path": CSV, "format": "csv", "mediatype": "text/csv", "encoding": "utf-8",
            "schema": { "fields": fields },
        }],
    })
}

/// The text of its table. A missing cell is empty.
pub fn csv(dataset: &Dataset) -> String {
    let mut text = String::from("run");
    for column in &dataset.columns {
        text.push(',');
        text.push_str(&column.name);
    }
    text.push('\n');
    for (row, &run) in dataset.run_of_row.iter().enumerate() {
        text.push_str(&dataset.run_labels[run]);
        for column in &dataset.columns {
            text.push(',');
            let value = column.values[row];
            if !value.is_nan() {
                let _ = write!(text, "{value}");
            }
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::cases;
    use crate::run::dataset;

    #[test]
    fn a_package_has_a_column_for_each_field_and_empty_cells_where_nothing_was_measured() {
        let headings =
            cases().into_iter().find(|case| case.group == "series-headings").expect("some");
        let dataset = dataset(&headings).expect("sized");
        let descriptor = descriptor(&dataset);
        let fields = descriptor["resources"][0]["schema"]["fields"].as_array().expect("a list");
        assert_eq!(fields[0]["role"], "run");
        let text = csv(&dataset);
        assert_eq!(text.lines().count(), dataset.rows() + 1);
        assert!(text.lines().all(|line| line.split(',').count() == fields.len()));
        assert!(text.contains(",,"), "sparse headings");
        assert!(!text.contains("NaN"));
    }
}
