//! A project for somebody's own device: files that run as they are, and are meant to be changed.
//!
//! * [`Template`]: a temperature controller that nobody has built, on CAN or on a serial line.
//! * [`from_dbc()`]: a project for one node of a DBC, with an emulator that says something and a plan that hears it.
//! * [`restbus()`]: the same for all nodes of a DBC but those that are real.

mod from_dbc;
mod restbus;
#[cfg(test)]
mod tests;
mod written;

pub use from_dbc::{FromDbc, FromDbcError, from_dbc};
pub use restbus::restbus;

use crate::schema::FileKind;
use include_dir::{Dir, DirEntry, include_dir};
use plan::Name;
use std::io;
use std::path::{Path, PathBuf};

static CAN: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/templates/can");
static SERIAL: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/templates/serial");

/// What the device is called in the templates, and its node in the DBC.
const DEVICE: &str = "mydevice";
/// See [`DEVICE`].
const NODE: &str = "MyDevice";

/// Folder of the schemas that editors check the files by.
const SCHEMAS: &str = "schemas";

/// A project that ships.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Template {
    /// A device on CAN, its messages in a DBC.
    Can,
    /// A device on a serial line, its messages described byte by byte.
    Serial,
}

/// One file of a project: where, and what is in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProjectFile {
    /// Within the project's folder.
    pub path: PathBuf,
    /// What is in it: text, of a DBC in whatever encoding that is.
    pub bytes: Vec<u8>,
}

impl ProjectFile {
    fn of_text(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { path: path.into(), bytes: text.into().into_bytes() }
    }

    /// Its text; empty where it is not in UTF-8.
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.bytes).unwrap_or_default()
    }
}

impl Template {
    /// Its files for a device of this name, and the schemas that editors check them by.
    pub fn files(self, name: &Name) -> Vec<ProjectFile> {
        with_schemas(self.named(name))
    }

    /// The files of the template, named.
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

/// What kind of file of a project a path is; none where it is no TOML.
fn kind(path: &Path) -> Option<FileKind> {
    path.extension().filter(|extension| *extension == "toml")?;
    match path.parent().and_then(Path::to_str) {
        Some("benches") => Some(FileKind::Bench),
        Some("devices") => Some(FileKind::Device),
        Some("rigs") => Some(FileKind::Rig),
        _ => Some(FileKind::Plan),
    }
}

/// The files, each with the line that names its schema to an editor, and the schemas.
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

/// `oven-2` as a DBC can name a node: `Oven2`.
fn node_name(name: &Name) -> String {
    let words = name.as_str().split(['-', '_']).filter(|word| !word.is_empty());
    let capital = |word: &str| word[..1].to_uppercase() + &word[1..];
    words.map(capital).collect()
}

/// Writes the files below `folder`, which has to be new or empty.
///
/// # Errors
///
/// When something is there already, or a file cannot be written.
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
