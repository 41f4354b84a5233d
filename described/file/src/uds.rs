//! Diagnostics (UDS) in a description.

use super::{FieldType, Formula};
use crate::isotp::IsoTpTable;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A UDS server (ISO 14229-1) beside the ordinary messages.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UdsTable {
    /// Identifiers and parameters of its ISO-TP channel.
    pub isotp: IsoTpTable,
    /// Limit of a response (P2), s. Default: 0.05.
    pub p2_s: Option<f64>,
    /// Limit of a response after a response pending (P2*), s. Default: 5.
    pub p2_star_s: Option<f64>,
    /// Time without a request after which a session ends (S3), s. Default: 5.
    pub s3_s: Option<f64>,
    /// Sessions besides `default`, each with its number. Default: `programming = 2` and `extended = 3`.
    pub sessions: Option<BTreeMap<String, u8>>,
    /// Says that a response is pending when a service takes longer than P2. Default: true.
    pub response_pending: Option<bool>,
    /// Time that it takes to restart after an ECU reset, s. Default: 0.
    pub reset_s: Option<f64>,
    /// Time before each of its flow controls, s. Default: 0.
    pub flow_control_delay_s: Option<Formula>,
    /// Time between its consecutive frames, s, whatever the tester asks for. Default: 0, as the tester asks.
    pub separation_s: Option<Formula>,
    /// Restrictions and durations of services.
    #[serde(default)]
    pub service: BTreeMap<String, ServiceTable>,
    /// Data identifiers.
    #[serde(default)]
    pub did: BTreeMap<String, DidTable>,
    /// Security levels, each by the number of its request for a seed: 1, 3, 5 and so on.
    #[serde(default)]
    pub security: BTreeMap<String, SecurityTable>,
    /// Diagnostic trouble codes: `P0A0F`, `P0A0F-16` or a number of 24 bits.
    #[serde(default)]
    pub dtc: BTreeMap<String, DtcTable>,
    /// Routines by their identifiers.
    #[serde(default)]
    pub routine: BTreeMap<String, RoutineTable>,
}

/// What a request needs.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AccessTable {
    /// Sessions. Default: all.
    pub sessions: Option<Vec<String>>,
    /// Unlocked security level.
    pub security: Option<u8>,
    /// Condition; otherwise the response is `conditionsNotCorrect`.
    pub when: Option<Formula>,
}

#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ServiceTable {
    /// False: the server does not have the service.
    pub supported: Option<bool>,
    /// What a request needs.
    #[serde(default)]
    pub access: AccessTable,
    /// Time that it takes, s.
    pub delay_s: Option<Formula>,
}

/// A data identifier: `text`, `bytes`, one number (`type`, `value`), or several as `fields`.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DidTable {
    /// Text. A write replaces it by another of the same length.
    pub text: Option<String>,
    /// Bytes. A write replaces them by as many others.
    pub bytes: Option<Vec<u8>>,
    /// Type of a number, most significant byte first.
    #[serde(rename = "type")]
    pub kind: Option<FieldType>,
    /// The number's value: an expression.
    pub value: Option<Formula>,
    /// Value per count. Default: 1.
    pub scale: Option<f64>,
    /// Value at count 0. Default: 0.
    pub offset: Option<f64>,
    /// Unit.
    #[serde(default)]
    pub unit: String,
    /// Parameter that a write sets.
    pub set: Option<String>,
    /// Several numbers, one after another.
    pub fields: Option<Vec<NumberTable>>,
    /// What reading needs.
    #[serde(default)]
    pub read: AccessTable,
    /// What writing needs.
    pub write: Option<AccessTable>,
    /// Time that it takes, s.
    pub delay_s: Option<Formula>,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

/// A number in a data identifier or in the results of a routine.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NumberTable {
    /// Type, most significant byte first.
    #[serde(rename = "type")]
    pub kind: FieldType,
    /// Value: an expression.
    pub value: Formula,
    /// Value per count. Default: 1.
    pub scale: Option<f64>,
    /// Value at count 0. Default: 0.
    pub offset: Option<f64>,
    /// Unit.
    #[serde(default)]
    pub unit: String,
    /// Parameter that a write sets.
    pub set: Option<String>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SecurityTable {
    /// The key: an expression of `seed`, a whole number.
    pub key: Option<String>,
    /// Length of the seed, 1 to 6 bytes. Default: 4.
    pub seed_bytes: Option<usize>,
    /// Length of the key, 1 to 6 bytes. Default: that of the seed.
    pub key_bytes: Option<usize>,
    /// Wrong keys before the delay. Default: 3.
    pub attempts: Option<u32>,
    /// Time after these during which no seed is given, s. Default: 10.
    pub delay_s: Option<f64>,
    /// What a request needs.
    #[serde(default)]
    pub access: AccessTable,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DtcTable {
    /// Condition under which its test fails.
    pub failed: Formula,
    /// The condition has to hold for this time, s. Default: 0.
    pub debounce_s: Option<f64>,
    /// Requests the warning indicator while it is confirmed.
    #[serde(default)]
    pub warning: bool,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoutineTable {
    /// `parameter = value`: parameters that its start sets.
    #[serde(default)]
    pub start: BTreeMap<String, Formula>,
    /// `parameter = value`: parameters that its stop sets. Without it the routine cannot be stopped.
    pub stop: Option<BTreeMap<String, Formula>>,
    /// Its results.
    pub results: Option<Vec<NumberTable>>,
    /// What a request needs.
    #[serde(default)]
    pub access: AccessTable,
    /// Time that its start takes, s.
    pub delay_s: Option<Formula>,
    /// What it is.
    #[serde(default)]
    pub doc: String,
}
