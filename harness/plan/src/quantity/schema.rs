//! Quantities and filters as JSON Schemas, for editors: from the tables of quantities and tags.

use super::{Filter, QuantityName, TagMatch};
use crate::band::Band;
use crate::name::Name;
use crate::quantities::{CHOSEN, PERIOD, QUANTITIES, SIGNAL, TAGS, families};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

/// The syntax of message and signal names in DBCs.
const IDENTIFIER: &str = "[A-Za-z0-9_]+";

/// The syntax of node names in a rig.
const NODE: &str = "[a-z][a-z0-9_-]{0,63}";

impl JsonSchema for QuantityName {
    fn schema_name() -> Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let known = QUANTITIES.iter().map(|quantity| {
            let doc =
                format!("{} In {}; from `{}`.", quantity.doc, quantity.unit, quantity.made_by);
            json_schema!({ "const": quantity.name, "description": doc })
        });
        let chosen = CHOSEN.iter().map(|(prefix, doc)| {
            (format!("^{}{}$", prefix.replace('.', r"\."), Name::pattern()), *doc)
        });
        let families: Vec<&str> = families().into_iter().collect();
        let of_messages = [
            (
                format!(r"^{SIGNAL}\.{IDENTIFIER}(\.{IDENTIFIER})*$"),
                "Each value that is received of this signal of the device, in its unit.",
            ),
            (
                format!(r"^{PERIOD}\.({NODE}\.)?{IDENTIFIER}$"),
                "The time between two of this message, s; of a rig by node and message.",
            ),
            (
                format!(r"^(?!({})\.){NODE}(\.{IDENTIFIER}){{1,2}}$", families.join("|")),
                "Each value of this signal that this node of the rig sends, in its unit.",
            ),
        ];
        let patterns = chosen
            .chain(of_messages)
            .map(|(pattern, doc)| json_schema!({ "pattern": pattern, "description": doc }));
        let all: Vec<Schema> = known.chain(patterns).collect();
        json_schema!({
            "description": "What is observed: see `hil list quantities`.",
            "type": "string",
            "anyOf": all
        })
    }
}

impl JsonSchema for TagMatch {
    fn schema_name() -> Cow<'static, str> {
        "TagMatch".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let band = generator.subschema_for::<Band>();
        json_schema!({ "anyOf": [{ "type": "number" }, band] })
    }
}

impl JsonSchema for Filter {
    fn schema_name() -> Cow<'static, str> {
        "Filter".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let wanted = generator.subschema_for::<TagMatch>();
        let mut schema = json_schema!({
            "description": "Which observations are meant: a number or a band for each tag.",
            "type": "object",
            "properties": {},
            "additionalProperties": wanted
        });
        if let Some(known) = schema.get_mut("properties").and_then(|it| it.as_object_mut()) {
            for tag in TAGS {
                let doc = format!("{}, in {}", tag.doc, tag.unit);
                let of_tag = json_schema!({ "description": doc, "anyOf": [wanted] });
                known.insert(tag.name.to_owned(), of_tag.into());
            }
        }
        schema
    }
}
