//! Where and when a run in real time took place.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The bench of a run in real time.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Bench {
    /// Start of the run by the clock of the machine, UTC: `2026-12-01T09:30:00Z` (RFC 3339).
    pub started: String,
    /// Name of the machine; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub host: String,
    /// The bench file; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Its title; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// Nodes of the rig that were real, though its file has them emulated or started.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub real: Vec<String>,
    /// Its number among the runs of `hil run --repeat`, from 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repetition: Option<u32>,
    /// What the bench file says about itself: serial numbers, revisions, people.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub about: BTreeMap<String, String>,
}
