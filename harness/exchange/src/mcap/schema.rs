//! Messages from table rows: JSON Schemas and JSON.

use crate::tables::cell::{Cell, Column};
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::{Map, Value, json};

#[derive(Debug, Clone, PartialEq)]
pub struct Schema {
    /// Its name: `foxglove.Log`, `hil.State`.
    pub name: String,
    /// JSON Schema without references, which Foxglove does not follow.
    pub text: Value,
}

impl Schema {
    /// The schema of messages with these fields. Only the time is required: unknown values are left out.
    pub fn of_columns(name: impl Into<String>, doc: &str, columns: &[Column]) -> Self {
        let name = name.into();
        let field = |column: &Column| {
            let kind = column.kind.json_type();
            let schema = json!({ "type": kind, "description": column.described() });
            (column.name.to_string(), schema)
        };
        let properties: Map<String, Value> = columns.iter().map(field).collect();
        let text = json!({
            "title": name,
            "description": doc,
            "type": "object",
            "properties": properties,
            "required": ["time_s"],
            "additionalProperties": false,
        });
        Self { name, text }
    }
}

/// A row as a JSON object; missing cells are left out.
#[derive(Debug, Clone, Copy)]
pub struct Fields<'a>(pub &'a [Column], pub &'a [Cell<'a>]);

impl Serialize for Fields<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (column, cell) in self.0.iter().zip(self.1) {
            match cell {
                Cell::Missing => {}
                Cell::Float(number) => map.serialize_entry(&column.name, number)?,
                Cell::Integer(number) => map.serialize_entry(&column.name, number)?,
                Cell::Bool(yes) => map.serialize_entry(&column.name, yes)?,
                Cell::Text(text) => map.serialize_entry(&column.name, text)?,
            }
        }
        map.end()
    }
}
