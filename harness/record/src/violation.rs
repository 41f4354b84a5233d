//! Where a property did not hold.

use serde::Serialize;
use wire::time::Timestamp;

/// Where a property was first violated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// When, in bench time.
    pub at: Timestamp,
    /// What was seen, and what was expected.
    pub what: String,
}
