//! The JSON Schema of steps, for editors: one table with every key, exactly one of which names the action.

use super::{Action, LABEL, Step, TIME_LIMIT};
use crate::name::Name;
use crate::number;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

impl JsonSchema for Step {
    fn schema_name() -> Cow<'static, str> {
        "Step".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let label = generator.subschema_for::<Name>();
        let label_doc = "Names what is observed during it: the tag `during.<label>`.";
        let mut limit = number::Duration::json_schema(generator);
        let limit_doc = "It must not take longer, s.";
        limit.insert("description".to_owned(), limit_doc.into());
        let mut schema = json_schema!({
            "description": "A step: one action, and `label` or `time_limit_s` if need be.",
            "type": "object",
            "properties": {
                LABEL: { "description": label_doc, "anyOf": [label] },
                TIME_LIMIT: limit
            },
            "additionalProperties": false,
            "oneOf": Action::NAMES.iter().map(|name| json_schema!({ "required": [name] })).collect::<Vec<_>>()
        });
        let data = Action::schemas(generator);
        if let Some(known) = schema.get_mut("properties").and_then(|it| it.as_object_mut()) {
            for (word, data) in Action::words().iter().zip(data) {
                let action = json_schema!({ "description": word.doc.trim(), "anyOf": [data] });
                known.insert(word.name.to_owned(), action.into());
            }
        }
        schema
    }
}
