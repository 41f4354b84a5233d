//! `hil schema`: schemas by which editors check and complete plans, bench files and descriptions.

use super::failure::Failure;
use super::say;
use crate::schema::FileKind;
use clap::{Args, ValueEnum as _};
use record::outcome::Outcome;
use std::fs;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  hil schema plan                 on the standard output
  hil schema --out schemas        all of them, as schemas/plan.schema.json and so on

A TOML file names its schema in its first line, and taplo or Even Better TOML (VS Code) completes and checks by it:
  #:schema schemas/plan.schema.json";

/// Prints the JSON Schema of a kind of file, so that editors complete and check it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct SchemaArguments {
    /// Which kind of file.
    #[arg(value_enum, value_name = "KIND", required_unless_present = "out")]
    kind: Option<FileKind>,
    /// Write it to this folder instead, as KIND.schema.json; all kinds if none is named.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl SchemaArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        match (&self.out, self.kind) {
            (Some(folder), Some(kind)) => write(folder, &[kind])?,
            (Some(folder), None) => write(folder, FileKind::value_variants())?,
            (None, kind) => {
                say(&kind.map(FileKind::text).unwrap_or_default())?;
            }
        }
        Ok(Outcome::Passed)
    }
}

fn write(folder: &Path, kinds: &[FileKind]) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|source| Failure::file(folder, source))?;
    for kind in kinds {
        let path = folder.join(kind.schema_file());
        fs::write(&path, kind.text()).map_err(|source| Failure::file(&path, source))?;
    }
    Ok(())
}
