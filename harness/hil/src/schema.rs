//! JSON Schemas (draft 2020-12) of the files that people write, for editors: which keys may appear where, their bounds
//! and their meaning. They are generated from the types that read the files, and from the tables of steps, quantities
//! and faults.
//!
//! A TOML file names its schema in its first line, `#:schema schemas/plan.schema.json`, which taplo and Even Better TOML
//! read.

#[cfg(test)]
mod tests;

use crate::choices::word;
use clap::ValueEnum;
use emulators::device_file::{BaseModel, DeviceFile, GyroModel, TableModel};
use identification::model::Model;
use plan::Plan;
use plan::bench_file::BenchFile;
use plan::rig::RigFile;
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{Schema, SchemaGenerator};
use serde_json::Value;

/// A kind of file that people write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FileKind {
    /// A plan.
    Plan,
    /// A bench file: which port plays which role.
    Bench,
    /// A rig: nodes on lines.
    Rig,
    /// A device file: the emulated gyro, base and table.
    Devices,
    /// The description of a device of your own.
    Device,
    /// A model that was identified.
    Model,
    /// A kind of gyro that device files name.
    GyroModel,
    /// A kind of base that device files name.
    BaseModel,
    /// A kind of table that device files name.
    TableModel,
}

impl FileKind {
    /// The file of its schema.
    pub fn schema_file(self) -> String {
        format!("{}.schema.json", word(&self))
    }

    pub fn schema(self) -> Schema {
        let settings =
            SchemaSettings::draft2020_12().with_transform(NoNull).with_transform(PlainWords);
        let generator = SchemaGenerator::new(settings);
        match self {
            Self::Plan => generator.into_root_schema_for::<Plan>(),
            Self::Bench => generator.into_root_schema_for::<BenchFile>(),
            Self::Rig => generator.into_root_schema_for::<RigFile>(),
            Self::Devices => generator.into_root_schema_for::<DeviceFile>(),
            Self::Device => described::schema(generator),
            Self::Model => generator.into_root_schema_for::<Model>(),
            Self::GyroModel => generator.into_root_schema_for::<GyroModel>(),
            Self::BaseModel => generator.into_root_schema_for::<BaseModel>(),
            Self::TableModel => generator.into_root_schema_for::<TableModel>(),
        }
    }

    pub fn text(self) -> String {
        format!("{:#}\n", self.schema().as_value())
    }
}

/// TOML has no null: an optional value does not have the type null, and has no null default.
#[derive(Debug, Clone)]
struct NoNull;

impl Transform for NoNull {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        let Some(object) = schema.as_object_mut() else { return };
        if object.get("default").is_some_and(says_nothing) {
            object.remove("default");
        }
        if let Some(Value::Array(types)) = object.get_mut("type") {
            types.retain(|one| one != "null");
            if let [one] = &types[..] {
                let one = one.clone();
                object.insert("type".to_owned(), one);
            }
        }
        if let Some(Value::Array(any)) = object.get_mut("anyOf") {
            any.retain(|one| one.get("type").is_none_or(|kind| kind != "null"));
        }
    }
}

/// An editor cannot follow links between Rust types: keeps only their text.
#[derive(Debug, Clone)]
struct PlainWords;

impl Transform for PlainWords {
    fn transform(&mut self, schema: &mut Schema) {
        transform_subschemas(self, schema);
        if let Some(Value::String(doc)) = schema.get_mut("description") {
            *doc = doc.replace("[`", "`").replace("`]", "`");
        }
    }
}

fn says_nothing(default: &Value) -> bool {
    match default {
        Value::Null => true,
        Value::String(text) => text.is_empty(),
        Value::Array(items) => items.is_empty(),
        Value::Object(fields) => fields.is_empty(),
        _ => false,
    }
}
