//! The violation of a property.

use serde::Serialize;
use wire::time::Timestamp;

/// The first violation of a property.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// Bench time.
    pub at: Timestamp,
    /// The observed and the expected.
    pub what: String,
}
