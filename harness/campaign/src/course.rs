//! How a run without faults went by.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wire::time::Span;

/// How long a run without faults took, and each of its phases.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Course {
    /// The whole run.
    #[serde(rename = "lasted_ns")]
    pub lasted: Span,
    /// The occurrences of each phase, in their order, as far as they were looked at. Empty if they are not known.
    #[serde(default, rename = "phases_ns", skip_serializing_if = "BTreeMap::is_empty")]
    pub phases: BTreeMap<String, Vec<Span>>,
}

/// Nothing is known of its phases.
impl From<Span> for Course {
    fn from(lasted: Span) -> Self {
        Self { lasted, phases: BTreeMap::new() }
    }
}
