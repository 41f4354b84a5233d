//! Bench files: the ports of the roles, and the program under test.
//!
//! ```toml
//! title = "The bench by the window"
//!
//! [gyro]
//! port = "/dev/ttyUSB0"       # a real gyro
//!
//! [base]
//! port = "can:vcan0"          # an emulated base, on a bus of this machine
//! emulated = true
//!
//! [controller]
//! command = ["./my-controller", "--gyro", "{gyro}", "--base", "can:{base}"]
//!
//! [command.flash]             # what a step `do = "flash"` runs
//! run = ["openocd", "-f", "board.cfg", "-c", "program firmware.elf verify reset exit"]
//! time_limit_s = 60
//!
//! [timing]
//! late_ms_max = 20
//!
//! [answers]
//! file = "answers.toml"
//!
//! [about]                     # what summary, report and JUnit say of the bench
//! "serial number" = "SN 1234"
//! ```
//!
//! A node of a rig is what the rig file says, or real: `[node.cells] real = true`.
//!
//! A role without a table is emulated, at the place that the world chooses. Invalid values are rejected during parsing,
//! so that the message points at its place.

mod attach;
mod command;
mod controller;
mod fit;
mod port_text;
mod role;
mod timing;

pub use crate::number::COMMAND_S_MAX;
pub use attach::AttachPlace;
pub use command::CommandSection;
pub use controller::ControllerSection;
pub use fit::Foreign;
pub use port_text::{Medium, PortText, PortTextError};
pub use role::Role;
use role::Yes;
pub use timing::Timing;

use crate::library::{Kind, Library, LibraryError};
use crate::name::Name;
use crate::speakers::DEVICE;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Names of the roles of a robot or a table that a bench assigns to ports. The role of a custom device is `device`.
pub const ROLES: [&str; 3] = ["gyro", "base", "table"];

/// A bench.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BenchFile {
    /// What it is, in a line.
    #[serde(default)]
    pub title: String,
    /// The gyro: a serial line.
    #[serde(default, deserialize_with = "role::on_a_serial_line")]
    #[schemars(schema_with = "role::schema")]
    pub gyro: Option<Role>,
    /// The mobile base: a serial line or a CAN bus.
    #[serde(default, deserialize_with = "role::anywhere")]
    #[schemars(schema_with = "role::schema")]
    pub base: Option<Role>,
    /// The rotary table: a serial line.
    #[serde(default, deserialize_with = "role::on_a_serial_line")]
    #[schemars(schema_with = "role::schema")]
    pub table: Option<Role>,
    /// A device of the user's own, of plans that name one: a serial line or a CAN bus.
    #[serde(default, deserialize_with = "role::anywhere")]
    #[schemars(schema_with = "role::schema")]
    pub device: Option<Role>,
    /// Ports of a rig's lines, by their names.
    #[serde(rename = "line", default)]
    pub lines: BTreeMap<String, LineSection>,
    /// Nodes of a rig that are real on this bench, by their names.
    #[serde(rename = "node", default)]
    pub nodes: BTreeMap<String, NodeSection>,
    /// What the step `do` runs, by name: power, relays, flashing.
    #[serde(rename = "command", default)]
    pub commands: BTreeMap<Name, CommandSection>,
    /// Commands that are run before each run, in this order, before a port is opened.
    #[serde(default)]
    pub setup: Vec<Name>,
    /// Commands that are run after each run, in this order, however it ended.
    #[serde(default)]
    pub teardown: Vec<Name>,
    /// The device under test; what the command line says where it is absent.
    #[schemars(with = "Option<controller::Controller>")]
    pub controller: Option<ControllerSection>,
    /// What real time may do.
    #[serde(default)]
    pub timing: Timing,
    /// What a person would be asked for.
    pub answers: Option<AnswersSection>,
    /// What the results of a run say of the bench: serial numbers, revisions, people.
    #[serde(default)]
    pub about: BTreeMap<String, String>,
    /// Path of the file, or its name in the library; [`BenchFile::load`] sets it.
    #[serde(skip)]
    pub origin: Option<String>,
}

/// Where a line of a rig is: `[line.can0] port = "can:can0"`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineSection {
    /// The port at which the nodes are that this process emulates.
    #[schemars(with = "String")]
    pub port: PortText,
}

/// A node of a rig: `[node.cells] real = true`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeSection {
    /// It is there, at the port of its line: nothing emulates it, and no program is started in its place.
    #[schemars(extend("const" = true), with = "bool")]
    real: Yes,
}

/// Where the answers of a person are written down.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnswersSection {
    /// The file; in the bench file relative to its folder, after [`BenchFile::load`] to the working
    /// directory. See `crate::operator::AnswerFile` for what it holds.
    pub file: PathBuf,
}

impl BenchFile {
    /// Reads the bench with this name or path.
    ///
    /// # Errors
    /// When it is missing or invalid.
    pub fn load(name: &str) -> Result<Self, LibraryError> {
        let (origin, mut bench): (String, Self) = Library::shipped().read(Kind::Bench, name)?;
        if let Some(answers) = &mut bench.answers
            && let Some(folder) = Path::new(&origin).parent()
        {
            answers.file = folder.join(&answers.file);
        }
        bench.origin = Some(origin);
        Ok(bench)
    }

    /// The text of the bench file with this name or path.
    ///
    /// # Errors
    /// When it is missing.
    pub fn text(name: &str) -> Result<String, LibraryError> {
        Ok(Library::shipped().open(Kind::Bench, name)?.text)
    }

    /// The device in the role with this name, one of [`ROLES`] or `device`; emulated if the file has no such role.
    pub fn role(&self, name: &str) -> Role {
        self.section(name).cloned().unwrap_or_default()
    }

    /// The table of the role with this name, if the file has it.
    fn section(&self, name: &str) -> Option<&Role> {
        match name {
            "gyro" => self.gyro.as_ref(),
            "base" => self.base.as_ref(),
            "table" => self.table.as_ref(),
            DEVICE => self.device.as_ref(),
            _ => None,
        }
    }

    /// The nodes that are real.
    pub fn real_nodes(&self) -> Vec<String> {
        self.nodes.keys().cloned().collect()
    }

    /// Each role and its device, in the order of [`ROLES`].
    pub fn roles(&self) -> impl Iterator<Item = (&'static str, Role)> + '_ {
        ROLES.iter().map(|name| (*name, self.role(name)))
    }
}

#[cfg(test)]
mod tests;
