//! The date, for records and leases; no decision depends on it.

use std::time::SystemTime;

/// Seconds since 1970-01-01 00:00 UTC.
#[expect(clippy::disallowed_methods, reason = "dates that people are told, nothing else")]
pub fn unix_s() -> Option<i64> {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok()?;
    i64::try_from(since.as_secs()).ok()
}
