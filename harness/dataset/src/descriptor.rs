//! The literal content of `datapackage.json`: a Frictionless Data Package with `unit`, `role`, `axis` and `hil`.

use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// The package. Properties of the standard that do not describe the data are ignored.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Descriptor {
    pub name: Option<String>,
    pub hil: Option<Hil>,
    #[serde(default)]
    pub resources: Vec<Resource>,
}

/// Properties that the contract adds to a package.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Hil {
    pub kind: Option<String>,
    pub drive: Option<String>,
    #[serde(default)]
    pub constants: BTreeMap<String, Quantity>,
    /// For a reader of the descriptor.
    #[serde(rename = "notes")]
    pub _notes: Option<Value>,
    #[serde(flatten)]
    pub others: BTreeMap<String, Value>,
}

/// A number with its unit.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Quantity {
    pub value: f64,
    pub unit: String,
}

/// A file of the package.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Resource {
    pub name: Option<String>,
    pub path: Option<Value>,
    pub format: Option<String>,
    pub encoding: Option<String>,
    pub dialect: Option<Dialect>,
    pub schema: Option<Schema>,
}

/// The dialect of the table.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Dialect {
    pub delimiter: Option<String>,
    /// The decimal sign of numbers: `.` or `,`.
    #[serde(rename = "decimalChar")]
    pub decimal: Option<String>,
    pub header: Option<bool>,
    /// Name of the group with the rows, in an MDF file, or of the topic, in a ROS bag.
    pub group: Option<String>,
}

/// The fields of a table.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Schema {
    #[serde(default)]
    pub fields: Vec<Field>,
    /// Cells that mean a missing value.
    #[serde(rename = "missingValues")]
    pub missing_values: Option<Vec<String>>,
}

/// A field of a table.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Field {
    pub name: String,
    #[serde(rename = "type")]
    pub kind: Option<String>,
    pub unit: Option<String>,
    pub role: Option<String>,
    pub axis: Option<String>,
    /// Its own decimal sign.
    #[serde(rename = "decimalChar")]
    pub decimal: Option<String>,
}

/// Finds `words` as JSON strings one after the other and returns the byte range of the last.
pub(super) fn place(text: &str, words: &[&str]) -> Option<std::ops::Range<usize>> {
    let mut found = 0..0;
    for word in words {
        let quoted = serde_json::to_string(word).ok()?;
        let at = found.end + text.get(found.end..)?.find(&quoted)?;
        found = at..at + quoted.len();
    }
    Some(found)
}
