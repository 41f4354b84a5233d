//! The user, for records and leases; no decision depends on the name.

/// The name of the user, as the login says it.
pub(crate) fn user() -> Option<String> {
    let said = ["USER", "LOGNAME"].iter().find_map(|name| std::env::var(name).ok());
    said.filter(|name| !name.trim().is_empty())
}
