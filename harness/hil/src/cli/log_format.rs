//! The format of a bus log: as given, or from its file name.

use super::failure::Failure;
use crate::choices::one_of;
use bus_log::Format;
use clap::builder::TypedValueParser;
use std::path::Path;

pub(super) fn format_parser() -> impl TypedValueParser<Value = Format> {
    one_of(Format::ALL.map(|format| (format.name(), "", format)))
}

/// Returns the given format, or that of the file name. `argument` names the option to change in the error.
pub(super) fn format_of(
    path: &Path,
    said: Option<Format>,
    argument: &str,
) -> Result<Format, Failure> {
    said.or_else(|| Format::of_path(path)).ok_or_else(|| {
        let message = format!("{} has no extension of a bus log", path.display());
        let help = match argument {
            "--from" | "--to" => format!("name the format: {argument} {}", Format::any_name()),
            _ => format!("give {argument} a name that ends in {}", Format::any_end()),
        };
        Failure::arguments(message, help)
    })
}
