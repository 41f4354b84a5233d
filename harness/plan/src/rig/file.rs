//! The literal content of a rig file.

use super::{UnderTest, VirtualTime};
use crate::name::Name;
use described::{IsoTpTable, OneOrSeveral, ProtectionTable};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A rig file, as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("anyOf" = [{ "required": ["devices"] }, { "required": ["node"] }]))]
pub struct RigFile {
    /// What it is, in a line.
    #[serde(default)]
    pub title: String,
    /// Name of a device file: the paper's robot or table.
    #[serde(default)]
    pub devices: Option<Name>,
    /// Its lines.
    #[serde(rename = "line", default)]
    pub lines: Vec<LineTable>,
    /// Its nodes.
    #[serde(rename = "node", default)]
    pub nodes: Vec<NodeTable>,
}

/// A line, as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["can"] }, { "required": ["serial"] }]))]
pub struct LineTable {
    /// Its name.
    pub name: Name,
    /// A CAN bus.
    #[serde(default)]
    pub can: Option<CanTable>,
    /// A serial line.
    #[serde(default)]
    pub serial: Option<SerialTable>,
    /// Counters and checksums in messages of its DBC.
    #[serde(rename = "message", default)]
    pub messages: BTreeMap<String, ProtectionTable>,
}

/// A CAN bus, as it is written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CanTable {
    /// Bits per second; 500,000 where it says nothing.
    #[serde(default)]
    #[schemars(range(min = 10_000, max = 1_000_000))]
    pub bit_rate: Option<u32>,
    /// Bits per second of the data of CAN FD frames that switch; the bus is a classic one where it says nothing.
    #[serde(default)]
    #[schemars(range(min = 10_000, max = 8_000_000))]
    pub data_bit_rate: Option<u32>,
    /// The DBC file with its messages, beside the rig file, or several.
    #[serde(default)]
    pub dbc: Option<OneOrSeveral<String>>,
}

/// A serial line, as it is written: the device on it says how it is set.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SerialTable {}

/// A node, as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["emulate"] }, { "required": ["under_test"] }, { "required": ["tester"] }, { "required": ["replay"] }]))]
pub struct NodeTable {
    /// Its name.
    pub name: Name,
    /// The line that it is on, or several, in the order of its ports.
    pub at: OneOrSeveral<Name>,
    /// The description of the device that is emulated.
    #[serde(default)]
    pub emulate: Option<String>,
    /// Parameters that it has other values of than its description says: by their names.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// It is the device under test.
    #[serde(default)]
    pub under_test: Option<UnderTest>,
    /// The description of the device that is under test: its messages.
    #[serde(default)]
    pub described_by: Option<String>,
    /// Limits of its program in virtual time.
    #[serde(default)]
    pub virtual_time: Option<VirtualTime>,
    /// The plan itself speaks here.
    #[serde(default)]
    pub tester: Option<bool>,
    /// The channel for diagnostic requests to a node under test.
    #[serde(default)]
    pub isotp: Option<IsoTpTable>,
    /// A log of its bus plays its part.
    #[serde(default)]
    pub replay: Option<ReplayTable>,
    /// Its name in the DBC of its line; its own, whatever the case of its letters, where this is absent.
    #[serde(default)]
    pub dbc_node: Option<String>,
}

impl NodeTable {
    /// The description of its messages, and the key that names it.
    pub fn description(&self) -> Option<(&'static str, &str)> {
        let emulated = self.emulate.as_deref().map(|name| ("emulate", name));
        emulated.or_else(|| Some(("described_by", self.described_by.as_deref()?)))
    }
}

/// The log that plays a node's part, as it is written.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplayTable {
    /// The log, beside the rig file: candump (`.log`), Vector ASC (`.asc`) or PEAK TRC (`.trc`).
    pub log: String,
    /// Its channel in the log; the one of the line's name, or the only one, where it says nothing.
    #[serde(default)]
    pub channel: Option<String>,
}
