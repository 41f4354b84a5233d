//! `hil new`: creates a project for the user's own device.

use super::failure::Failure;
use super::progress::Screen;
use super::say;
use crate::project::{self, FromDbcError, ProjectFile, Template};
use clap::Args;
use described::{DbcNode, Note};
use harness::run::{PrepareError, RigError};
use plan::Name;
use plan::library::{self, LibraryError};
use record::outcome::Outcome;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  hil new oven                                 a temperature controller on CAN, to start from
  hil new oven --serial                        the same on a serial line
  hil new motor --dbc motor.dbc --node Motor   for a node of your own DBC
  hil new drive --eds drive.eds                for a CANopen device with this EDS or DCF
  hil new rest --dbc car.dbc --except Motor    all other nodes of the DBC, for a real motor

The folder has a README that walks through it: test it, break it, make it yours, run it on the real device.";

/// Creates a project for your own device: an emulator described in a file, plans, and a bench file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct NewArguments {
    /// Folder to create; the device gets its name.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// A device on a serial line instead of CAN.
    #[arg(long, conflicts_with = "dbc")]
    serial: bool,
    /// Your own DBC, with the device as a node.
    #[arg(long, value_name = "FILE")]
    dbc: Option<PathBuf>,
    /// The EDS or DCF of your own CANopen device.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dbc", "serial"])]
    eds: Option<PathBuf>,
    /// The node identifier of the CANopen device. [default: that of the DCF, or 1].
    #[arg(long, value_name = "ID", requires = "eds", value_parser = clap::value_parser!(u8).range(1..=127))]
    node_id: Option<u8>,
    /// The device's name in the DBC. [default: the only node that sends messages].
    #[arg(long, value_name = "NODE", requires = "dbc")]
    node: Option<String>,
    /// The rest of the bus: emulates all nodes of the DBC but this one, which is yours. May be given several times.
    #[arg(long, value_name = "NODE", requires = "dbc", conflicts_with = "node")]
    except: Vec<String>,
}

impl NewArguments {
    pub(super) fn execute(&self, screen: &Screen) -> Result<Outcome, Failure> {
        let name = self.name()?;
        let (files, notes) = self.files(&name)?;
        project::write(&self.folder, &files).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => Failure::arguments(
                format!("{} already exists and is not empty", self.folder.display()),
                "`hil new` overwrites nothing: name another folder",
            ),
            _ => Failure::file(&self.folder, source),
        })?;
        let mut plans = files.iter().filter(|file| is_plan(&file.path));
        let plan = if self.except.is_empty() { plans.next_back() } else { plans.next() };
        let plan = plan.map_or_else(String::new, |file| file.path.display().to_string());
        let folder = self.folder.display();
        let mut told: String = notes.iter().map(|note| format!("{note}\n")).collect();
        if !told.is_empty() {
            told += "\n";
        }
        if screen.is_quiet() {
            say(&told)?;
            return Ok(Outcome::Passed);
        }
        told += &format!("{folder}: {} files\n", files.len());
        for file in &files {
            told += &format!("  {}\n", file.path.display());
        }
        told += &format!("\nNext:\n  cd {folder}\n  hil run {plan}\n");
        say(&told)?;
        Ok(Outcome::Passed)
    }

    fn name(&self) -> Result<Name, Failure> {
        // The working directory has a name, too.
        let folder = std::path::absolute(&self.folder).unwrap_or_else(|_| self.folder.clone());
        let last = folder.file_name().unwrap_or(self.folder.as_os_str()).to_string_lossy();
        Name::new(&last).ok_or_else(|| {
            Failure::arguments(
                format!("\"{}\" cannot be the name of a device", last.escape_debug()),
                "the folder gives the device its name: begin with a lower-case letter; then a-z, 0-9, - and _",
            )
        })
    }

    /// Returns the files, and notes on those parts of a DBC or an EDS that are changed.
    fn files(&self, name: &Name) -> Result<(Vec<ProjectFile>, Vec<Note>), Failure> {
        if let Some(eds) = &self.eds {
            let bytes = read(eds)?;
            let made = project::from_eds(name, &eds.display().to_string(), &bytes, self.node_id);
            let made = made.map_err(|error| PrepareError::from(RigError::from(error)))?;
            return Ok((made.files, made.notes));
        }
        let Some(dbc) = &self.dbc else {
            let template = if self.serial { Template::Serial } else { Template::Can };
            return Ok((template.files(name), Vec::new()));
        };
        let bytes = read(dbc)?;
        let file = dbc.display().to_string();
        let made = match self.except.as_slice() {
            [] => project::from_dbc(name, &file, &bytes, self.node.as_deref()),
            except => project::restbus(name, &file, &bytes, except),
        };
        match made {
            Ok(made) => Ok((made.files, made.notes)),
            Err(FromDbcError::Description(error)) => {
                Err(PrepareError::from(RigError::from(error)).into())
            }
            Err(error @ FromDbcError::Empty(_)) => Err(Failure::arguments(
                error.to_string(),
                "a message is a line `BO_ 100 Name: 8 Node`, with its signals below",
            )),
            Err(error @ FromDbcError::Alone(_)) => Err(Failure::arguments(
                error.to_string(),
                "without `--except` the project is one of the node itself",
            )),
            Err(
                ref error @ (FromDbcError::Several { ref nodes, .. }
                | FromDbcError::Silent { ref nodes, .. }),
            ) => Err(Failure::arguments(error.to_string(), senders(nodes))),
        }
    }
}

fn read(file: &Path) -> Result<Vec<u8>, Failure> {
    let unreadable = |cause| LibraryError::unreadable(file, cause);
    Ok(library::bytes(file).map_err(unreadable).map_err(PrepareError::from)?)
}

/// Lists the nodes that `--node` may name.
fn senders(nodes: &[DbcNode]) -> String {
    let named = |node: &DbcNode| format!("{} ({})", node.name, node.messages);
    let nodes: Vec<String> = nodes.iter().map(named).collect();
    format!("name the device with `--node NAME`; nodes and their messages: {}", nodes.join(", "))
}

/// Whether the file is a plan: a TOML file beside the README.
fn is_plan(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
        && path.parent().is_none_or(|folder| folder.as_os_str().is_empty())
}
