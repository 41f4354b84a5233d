//! The user and the time of day, for records and leases; no decision depends on them.

use std::time::SystemTime;

/// The name of the user, as the login says it.
pub(crate) fn user() -> Option<String> {
    let said = ["USER", "LOGNAME"].iter().find_map(|name| std::env::var(name).ok());
    said.filter(|name| !name.trim().is_empty())
}

/// Seconds since 1970-01-01 00:00 UTC.
#[expect(clippy::disallowed_methods, reason = "dates that people are told, nothing else")]
pub(crate) fn unix_s() -> Option<i64> {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok()?;
    i64::try_from(since.as_secs()).ok()
}
