//! Quantities and filters as JSON Schemas, for editors: from the tables of quantities and tags.

use super::{Filter, QuantityName, TagMatch};
use crate::band::Band;
use crate::name::Name;
use crate::quantities::{
    OPERATOR_PREFIX, PERIOD, QUANTITIES, SDO_PREFIX, SIGNAL, TAGS, UDS_PREFIX, UNEXPECTED_PREFIX,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

/// The syntax of message and signal names in DBCs.
const IDENTIFIER: &str = "[A-Za-z0-9_]+";

/// The syntax of node names in a rig.
const NODE: &str = "[a-z][a-z0-9_-]{0,63}";

/// The prefixes of the names in the table, which nodes cannot have as names.
fn families() -> Vec<&'static str> {
    let first = |name: &'static str| name.split('.').next().unwrap_or_default();
    let mut families: Vec<&str> = QUANTITIES.iter().map(|quantity| first(quantity.name)).collect();
    families.extend([SIGNAL, PERIOD, "operator", "sdo", "uds", "unexpected"]);
    families.sort_unstable();
    families.dedup();
    families
}

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
        let answer = format!("^{}{}$", OPERATOR_PREFIX.replace('.', r"\."), Name::pattern());
        let read = format!("^{}{}$", UDS_PREFIX.replace('.', r"\."), Name::pattern());
        let object = format!("^{}{}$", SDO_PREFIX.replace('.', r"\."), Name::pattern());
        let line = format!("^{}{}$", UNEXPECTED_PREFIX.replace('.', r"\."), Name::pattern());
        let patterns = [
            (
                line,
                "How much came on this line, in the whole run, that is not a valid message of its nodes.",
            ),
            (answer, "What an operator answers."),
            (read, "A number that a step `uds` reads."),
            (object, "What an `sdo` step reads, in the unit of the object."),
            (
                format!(r"^{SIGNAL}\.{IDENTIFIER}(\.{IDENTIFIER})*$"),
                "Each value that is received of this signal of the device, in its unit.",
            ),
            (
                format!(r"^{PERIOD}\.({NODE}\.)?{IDENTIFIER}$"),
                "The time between two of this message, s; of a rig by node and message.",
            ),
            (
                format!(r"^(?!({})\.){NODE}(\.{IDENTIFIER}){{1,2}}$", families().join("|")),
                "Each value of this signal that this node of the rig sends, in its unit.",
            ),
        ];
        let patterns =
            patterns.map(|(pattern, doc)| json_schema!({ "pattern": pattern, "description": doc }));
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
