//! The vocabulary as a JSON Schema, for editors: from [`FaultKind::all`].

use super::{FaultKind, KindInfo};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Map, Value};
use std::borrow::Cow;

impl JsonSchema for FaultKind {
    fn schema_name() -> Cow<'static, str> {
        "FaultKind".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let kinds: Map<String, Value> = Self::all()
            .iter()
            .map(|info| (info.name.to_owned(), parameters(info).into()))
            .collect();
        json_schema!({
            "description": "What goes wrong: one kind with its parameters (`hil list faults`).",
            "type": "object",
            "properties": kinds,
            "additionalProperties": false,
            "minProperties": 1,
            "maxProperties": 1
        })
    }
}

fn parameters(info: &KindInfo) -> Schema {
    let with_typical = info.parameters.iter().zip(info.typical.values());
    let numbers: Map<String, Value> = with_typical
        .map(|(parameter, typical)| {
            let (least, greatest) = parameter.range;
            let doc = format!("{} Typical: {typical} {}.", parameter.doc.trim(), parameter.unit);
            let number = json_schema!({
                "description": doc, "type": "number", "minimum": least, "maximum": greatest
            });
            (parameter.name.to_owned(), number.into())
        })
        .collect();
    let required: Vec<&str> = info.parameters.iter().map(|parameter| parameter.name).collect();
    json_schema!({
        "description": info.doc.trim(),
        "type": "object",
        "properties": numbers,
        "required": required,
        "additionalProperties": false
    })
}

pub(crate) fn name(_: &mut SchemaGenerator) -> Schema {
    let names = FaultKind::all()
        .iter()
        .map(|info| json_schema!({ "const": info.name, "description": info.doc.trim() }));
    json_schema!({ "type": "string", "oneOf": names.collect::<Vec<_>>() })
}
