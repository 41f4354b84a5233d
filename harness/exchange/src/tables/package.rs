//! `datapackage.json`: the tables and the meaning of their columns. A Frictionless Data Package like that of data sets,
//! with `profile` = [`PROFILE`].

use super::Format;
use super::cell::Column;
use super::columns::Table;
use super::survey::Survey;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

pub const PACKAGE: &str = "datapackage.json";

/// Distinguishes a package of tables from a data set.
pub const PROFILE: &str = "hil-tables";

pub(super) fn package(survey: &Survey, format: Format, tables: &[(Table, u64)]) -> Value {
    let resource = |(table, rows): &(Table, u64)| {
        let columns = table.columns(survey);
        json!({
            "name": table.name(),
            "path": file_name(*table, format),
            "format": format.name(),
            "description": table.doc(),
            "rows": rows,
            "schema": { "fields": columns.iter().map(field).collect::<Vec<_>>(), "missingValues": [""] },
        })
    };
    json!({
        "profile": PROFILE,
        "name": format!("{}-seed{}", survey.header.plan, survey.header.seed),
        "hil": {
            "version": survey.header.harness,
            "plan": survey.header.plan,
            "seed": survey.header.seed,
            "record": survey.wholeness(),
        },
        "resources": tables.iter().map(resource).collect::<Vec<_>>(),
    })
}

pub(super) fn file_name(table: Table, format: Format) -> String {
    format!("{}.{}", table.name(), format.name())
}

/// Whether the file is a package that was written here, and not a foreign file.
pub(super) fn is_ours(path: &Path) -> bool {
    let read = fs::read(path).ok().and_then(|json| serde_json::from_slice::<Value>(&json).ok());
    read.is_some_and(|package| package["profile"] == PROFILE)
}

fn field(column: &Column) -> Value {
    json!({ "name": column.name, "type": column.kind.json_type(), "unit": column.unit, "description": column.doc })
}
