//! The format of a bus log: as it is said, or by the name of its file.

use super::failure::Failure;
use bus_log::Format;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::path::Path;

/// A format by its name.
pub(super) fn format_parser() -> impl TypedValueParser<Value = Format> {
    PossibleValuesParser::new(Format::ALL.map(Format::name)).try_map(|name| {
        Format::ALL.into_iter().find(|format| format.name() == name).ok_or("no such format")
    })
}

/// The format that was said, or that of the file's name. `argument` says what to change.
pub(super) fn format_of(
    path: &Path,
    said: Option<Format>,
    argument: &str,
) -> Result<Format, Failure> {
    said.or_else(|| Format::of_path(path)).ok_or_else(|| {
        let message = format!("the name {} ends as no bus log does", path.display());
        let help = match argument {
            "--from" | "--to" => format!("say what it is: {argument} {}", Format::any_name()),
            _ => format!("give {argument} a name that ends in {}", Format::any_end()),
        };
        Failure::arguments(message, help)
    })
}
