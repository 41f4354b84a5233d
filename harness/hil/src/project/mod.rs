//! A project for the user's own device: files that run as they are, and are meant to be changed.
//!
//! * [`Template`]: a fictitious temperature controller, on CAN or on a serial line.
//! * [`from_dbc()`]: a project for one node of a DBC, with an emulator that sends its messages and a plan that receives
//!   them.
//! * [`from_eds()`]: a project for a CANopen device.
//! * [`restbus()`]: a project for all nodes of a DBC except the real ones.

mod from_dbc;
mod from_eds;
mod restbus;
#[cfg(test)]
mod tests;
mod traffic;
mod written;

pub use from_dbc::{FromDbc, FromDbcError, from_dbc};
pub use from_eds::from_eds;
pub use restbus::restbus;

use crate::schema::FileKind;
use include_dir::{Dir, DirEntry, include_dir};
use plan::Name;
use std::io;
use std::path::{Path, PathBuf};

static CAN: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/templates/can");
static SERIAL: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/templates/serial");

const DEVICE: &str = "mydevice";
const NODE: &str = "MyDevice";

/// The other node of their DBC, whose name no device can have.
const OTHER_NODE: &str = "Host";

/// Folder of the schemas that editors check files against.
const SCHEMAS: &str = "schemas";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Template {
    /// A device on CAN, its messages in a DBC.
    Can,
    /// A device on a serial line, its messages described byte by byte.
    Serial,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProjectFile {
    pub path: PathBuf,
    /// Content: text, or a DBC in any encoding.
    pub bytes: Vec<u8>,
}

impl ProjectFile {
    fn of_text(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), bytes: text.into().into_bytes() }
    }

    /// Returns its text; empty if it is not UTF-8.
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.bytes).unwrap_or_default()
    }
}

impl Template {
    pub fn files(self, name: &Name) -> Vec<ProjectFile> {
        with_schemas(self.named(name))
    }

    fn named(self, name: &Name) -> Vec<ProjectFile> {
        let mut files = Vec::new();
        collect(if self == Self::Can { &CAN } else { &SERIAL }, &mut files);
        for file in &mut files {
            let node = node_name(name);
            let named = |text: &str| text.replace(DEVICE, name.as_str()).replace(NODE, &node);
            file.path = named(&file.path.to_string_lossy()).into();
            file.bytes = named(file.text()).into_bytes();
        }
        files
    }
}

/// Returns the kind of a project file; `None` if it is not TOML.
fn kind(path: &Path) -> Option<FileKind> {
    path.extension().filter(|extension| *extension == "toml")?;
    match path.parent().and_then(Path::to_str) {
        Some("benches") => Some(FileKind::Bench),
        Some("devices") => Some(FileKind::Device),
        Some("rigs") => Some(FileKind::Rig),
        _ => Some(FileKind::Plan),
    }
}

/// Adds to each file the line that names its schema, and appends the schemas.
fn with_schemas(mut files: Vec<ProjectFile>) -> Vec<ProjectFile> {
    for file in &mut files {
        let Some(kind) = kind(&file.path) else { continue };
        let up = "../".repeat(file.path.components().count() - 1);
        let text = format!("#:schema {up}{SCHEMAS}/{}\n{}", kind.schema_file(), file.text());
        file.bytes = text.into_bytes();
    }
    let mut schemas: Vec<FileKind> = files.iter().filter_map(|file| kind(&file.path)).collect();
    schemas.sort_by_key(|kind| kind.schema_file());
    schemas.dedup();
    let path = |kind: FileKind| Path::new(SCHEMAS).join(kind.schema_file());
    files.extend(schemas.into_iter().map(|kind| ProjectFile::of_text(path(kind), kind.text())));
    files
}

fn collect(folder: &Dir<'_>, files: &mut Vec<ProjectFile>) {
    for entry in folder.entries() {
        match entry {
            DirEntry::Dir(folder) => collect(folder, files),
            DirEntry::File(file) => {
                let bytes = file.contents().to_owned();
                files.push(ProjectFile { path: file.path().to_owned(), bytes });
            }
        }
    }
}

/// Converts `oven-2` to a DBC node name: `Oven2`.
fn node_name(name: &Name) -> String {
    let words = name.as_str().split(['-', '_']).filter(|word| !word.is_empty());
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    let node: String = words.map(capital).collect();
    if node == OTHER_NODE { format!("{node}Device") } else { node }
}

/// Writes the files below `folder`, which must be new or empty.
///
/// # Errors
///
/// When the folder is not empty, or a file cannot be written.
pub fn write(folder: &Path, files: &[ProjectFile]) -> io::Result<()> {
    if folder.exists() && folder.read_dir()?.next().is_some() {
        return Err(io::Error::new(io::ErrorKind::AlreadyExists, "the folder is not empty"));
    }
    for file in files {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&path, &file.bytes)?;
    }
    Ok(())
}
