//! Steps as a JSON Schema, for editors: one table with every key, of which exactly one names the action.

use super::{Action, LABEL, Step, TIME_LIMIT};
use crate::name::Name;
use crate::number;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use std::borrow::Cow;

/// The type whose schema is that of an action's data: itself, or what stands for a type of the controller, which knows of
/// no schemas.
macro_rules! written {
    (HeadingSource) => {
        crate::step::schema::HeadingSourceWord
    };
    (BiasMethod) => {
        crate::step::schema::BiasMethodWord
    };
    (Estimator) => {
        crate::step::schema::EstimatorWord
    };
    ($data:ident) => {
        $data
    };
}
pub(super) use written;

/// [`controller::mission::HeadingSource`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "HeadingSource", rename_all = "snake_case")]
#[schemars(description = "Which heading closes the loops.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum HeadingSourceWord {
    /// The gyro's.
    Gyro,
    /// The base's own odometry.
    Odometry,
}

/// [`controller::mission::BiasMethod`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "BiasMethod", rename_all = "snake_case")]
#[schemars(description = "Where the bias that is subtracted comes from.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum BiasMethodWord {
    /// The last static bias test.
    StaticTest,
    /// The calibration's table of bias against temperature, for comparison.
    TemperatureTable,
    /// None is subtracted, for comparison.
    None,
}

/// [`controller::mission::Estimator`], as it is written.
#[derive(JsonSchema)]
#[schemars(rename = "Estimator", rename_all = "snake_case")]
#[schemars(description = "What estimates heading, position and bias.")]
#[expect(dead_code, reason = "it is only described")]
pub(super) enum EstimatorWord {
    /// As in the paper: samples less the bias of the last test, summed.
    Paper,
    /// A Kalman filter, which learns at every standstill.
    Kalman,
}

impl JsonSchema for Step {
    fn schema_name() -> Cow<'static, str> {
        "Step".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let label = generator.subschema_for::<Name>();
        let label_doc = "Names what is observed during it: the tag `during.<label>`.";
        let mut limit = number::schema::duration(generator);
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
            for ((name, doc), data) in Action::DOCS.iter().zip(data) {
                let action = json_schema!({ "description": doc.trim(), "anyOf": [data] });
                known.insert((*name).to_owned(), action.into());
            }
        }
        schema
    }
}
