//! `hil new`: a project for somebody's own device.

use super::failure::Failure;
use super::say;
use crate::project::{self, ProjectFile, Template};
use clap::Args;
use harness::run::{PrepareError, RigError};
use plan::Name;
use plan::library::Source;
use record::outcome::Outcome;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  hil new oven                                 a temperature controller on CAN, to be changed
  hil new oven --serial                        the same on a serial line
  hil new motor --dbc motor.dbc --node Motor   for a node of your own DBC

The folder has a README that walks through it: test it, break it, make it yours, run it on the real device.";

/// Makes a project for a device of your own: an emulator described without Rust, plans, and a bench file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NewArguments {
    /// Folder to make; its name is the device's.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// A device on a serial line; without, on CAN.
    #[arg(long, conflicts_with = "dbc")]
    serial: bool,
    /// A DBC of your own, which has the device as a node.
    #[arg(long, value_name = "FILE", requires = "node")]
    dbc: Option<PathBuf>,
    /// The device's name in the DBC.
    #[arg(long, value_name = "NODE", requires = "dbc")]
    node: Option<String>,
}

impl NewArguments {
    pub(super) fn execute(&self) -> Result<Outcome, Failure> {
        let name = self.name()?;
        let files = self.files(&name)?;
        project::write(&self.folder, &files).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => Failure::arguments(
                format!("{} is there already, and not empty", self.folder.display()),
                "nothing is written over: name another folder",
            ),
            _ => Failure::file(&self.folder, source),
        })?;
        let plan = files.iter().rfind(|file| is_plan(&file.path));
        let plan = plan.map_or_else(String::new, |file| file.path.display().to_string());
        let folder = self.folder.display();
        let mut told = format!("{folder}: {} files\n", files.len());
        for file in &files {
            told += &format!("  {}\n", file.path.display());
        }
        told += &format!("\nNext:\n  cd {folder}\n  hil run {plan}\n");
        say(&told)?;
        Ok(Outcome::Passed)
    }

    fn name(&self) -> Result<Name, Failure> {
        let last = self.folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let last = last.unwrap_or_default();
        Name::new(&last).ok_or_else(|| {
            Failure::arguments(
                format!("\"{}\" is no name for a device", last.escape_debug()),
                "the folder's name is the device's: a letter, then a-z, 0-9, - and _",
            )
        })
    }

    fn files(&self, name: &Name) -> Result<Vec<ProjectFile>, Failure> {
        let (Some(dbc), Some(node)) = (&self.dbc, &self.node) else {
            let template = if self.serial { Template::Serial } else { Template::Can };
            return Ok(template.files(name));
        };
        let source = Source::of_file(dbc).map_err(PrepareError::from)?;
        let files = project::from_dbc(name, &source.origin, &source.text, node);
        files.map_err(|error| PrepareError::from(RigError::from(error)).into())
    }
}

/// A plan lies beside the README.
fn is_plan(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
        && path.parent().is_none_or(|folder| folder.as_os_str().is_empty())
}
