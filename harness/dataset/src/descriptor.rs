//! The literal content of `datapackage.json`: a Frictionless Data Package with `unit`, `role`, `axis` and `hil`.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

/// The package. Properties of the standard that do not describe the data are ignored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Descriptor {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hil: Option<Hil>,
    #[serde(default)]
    pub resources: Vec<Resource>,
}

/// Properties that the contract adds to a package.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Hil {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<String>,
    #[serde(default)]
    pub constants: BTreeMap<String, Quantity>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notes: Option<Value>,
    #[serde(flatten)]
    pub others: BTreeMap<String, Value>,
}

/// A number with its unit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Quantity {
    pub value: f64,
    pub unit: String,
}

/// A file of the package.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Resource {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<Value>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mediatype: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoding: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dialect: Option<Dialect>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schema: Option<Schema>,
}

/// The dialect of the table.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Dialect {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<String>,
    /// The decimal sign of numbers: `.` or `,`.
    #[serde(default, rename = "decimalChar", skip_serializing_if = "Option::is_none")]
    pub decimal: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header: Option<bool>,
    /// Name of the group with the rows, in an MDF file, or of the topic, in a ROS bag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
}

/// The fields of a table.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Schema {
    #[serde(default)]
    pub fields: Vec<Field>,
    /// Cells that mean a missing value.
    #[serde(default, rename = "missingValues", skip_serializing_if = "Option::is_none")]
    pub missing_values: Option<Vec<String>>,
}

/// A field of a table.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Field {
    pub name: String,
    #[serde(default, rename = "type", skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<String>,
    /// Its own decimal sign.
    #[serde(default, rename = "decimalChar", skip_serializing_if = "Option::is_none")]
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
