//! The plans, device files, calibrations and other files that ship with the harness, and those on disk.
//!
//! A name refers to a shipped file, a path to a file on disk; a text that ends in `.toml` or contains a separator is a
//! path. Files next to a plan on disk have priority, then those in the working directory, then the shipped ones, so
//! that a copy of `test-plans` can be changed as a whole.

mod pack;
mod reading;
mod unreadable;

pub use pack::{PLAN, Pack, PackedFile};
pub use reading::bytes;

use described::FileError;
use described::hint::nearest;
use include_dir::{Dir, include_dir};
use miette::Diagnostic as _;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

static SHIPPED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../test-plans");

/// The procedures of the paper, in an order in which each has the results it needs.
pub const PAPER_PLANS: [&str; 10] = [
    "warm-up",
    "static-bias",
    "temperature-calibration",
    "verification",
    "laps-observed",
    "straight-accuracy",
    "turn-accuracy",
    "laps-corrected",
    "laps-uncorrected",
    "umbmark",
];

/// The text of a file and its origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// Its name in messages: a path, or `test-plans/...` for a shipped file.
    pub origin: String,
    /// Its text.
    pub text: String,
}

/// Why a file cannot be loaded.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LibraryError {
    /// No shipped file has this name.
    #[error("no {kind} is called \"{name}\"")]
    #[diagnostic(help("{known}\na path ends in .toml or contains a /"))]
    UnknownName {
        /// `plan`, `device file`, ...
        kind: Kind,
        /// The requested name.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The file cannot be read.
    #[error("failed to read {}: {cause}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
        /// A file of nearly this name.
        #[help]
        help: Option<String>,
    },
    /// The file is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mistake(#[from] FileError),
}

wire::words! {
    /// Kinds of files in the library.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Kind {
        /// A plan.
        Plan = "plan",
        /// A device file: properties of the emulated devices.
        Devices = "device file",
        /// A gyro model for device files.
        GyroModel = "gyro model",
        /// A base model for device files.
        BaseModel = "base model",
        /// A table model for device files.
        TableModel = "table model",
        /// A calibration of a gyro.
        Calibration = "calibration",
        /// An identified model.
        Model = "identified model",
        /// A bench file: the ports of the roles.
        Bench = "bench",
        /// A rig: nodes on lines.
        Rig = "rig",
        /// The description of a custom device.
        Description = "description of a device",
        /// A file that such a description names.
        DeviceData = "file of a device",
    }
}

impl Kind {
    /// Folder below `test-plans`.
    const fn folder(self) -> &'static str {
        match self {
            Self::Plan => "",
            Self::Devices | Self::Description | Self::DeviceData => "devices",
            Self::GyroModel => "devices/gyros",
            Self::BaseModel => "devices/bases",
            Self::TableModel => "devices/tables",
            Self::Calibration => "calibrations",
            Self::Model => "models",
            Self::Bench => "benches",
            Self::Rig => "rigs",
        }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Where to search, in addition to the shipped files.
#[derive(Debug, Clone, Default)]
pub struct Library {
    folder: Option<PathBuf>,
    packed: Option<Arc<Pack>>,
    opened: Option<Arc<Mutex<Pack>>>,
}

impl Library {
    /// Only the shipped files.
    pub const fn shipped() -> Self {
        Self { folder: None, packed: None, opened: None }
    }

    /// Only the files of a pack.
    pub const fn packed(pack: Arc<Pack>) -> Self {
        Self { folder: None, packed: Some(pack), opened: None }
    }

    /// The same files, and a pack to which each opened file is added.
    pub fn packing(self) -> (Self, Arc<Mutex<Pack>>) {
        let opened = Arc::new(Mutex::new(Pack::default()));
        (Self { opened: Some(Arc::clone(&opened)), ..self }, opened)
    }

    /// The shipped files, after those in the folder of `plan` if it is a path.
    pub fn beside(plan: &str) -> Self {
        let folder = is_path(plan).then(|| Path::new(plan).parent().map(Path::to_owned)).flatten();
        Self { folder, ..Self::default() }
    }

    /// The same, for a plan in that folder that names a `project` in place of it.
    pub fn of(&self, project: Option<&str>) -> Self {
        let mut library = self.clone();
        if let (Some(folder), Some(project)) = (&mut library.folder, project) {
            folder.push(project);
        }
        library
    }

    /// The folder of the project, if files of one are searched.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// Like [`Self::beside`], for a rig: files that its nodes name are found as from a plan of its project. A name is that of a
    /// rig of the project one stands in.
    pub fn beside_rig(rig: &str) -> Self {
        let folder = Self::beside(rig).folder.unwrap_or_default();
        Self::of_project(match folder.parent() {
            Some(project) if folder.ends_with(Kind::Rig.folder()) => project,
            _ => &folder,
        })
    }

    /// The shipped files, after those of the project in this folder.
    pub fn of_project(folder: &Path) -> Self {
        Self { folder: Some(folder.to_owned()), ..Self::default() }
    }

    /// The file that `name` refers to.
    ///
    /// # Errors
    /// When no shipped file has this name, or the path cannot be read.
    pub fn open(&self, kind: Kind, name: &str) -> Result<Source, LibraryError> {
        let source = match &self.packed {
            Some(pack) => pack.open(kind, name)?,
            None => self.find(kind, name)?,
        };
        if let Some(opened) = &self.opened {
            let mut opened = opened.lock().unwrap_or_else(PoisonError::into_inner);
            opened.add(kind, name, &source);
        }
        Ok(source)
    }

    /// The file `name` in the folder of `source`, the description of a device.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open_beside(&self, source: &Source, name: &str) -> Result<Source, LibraryError> {
        self.open_beside_by(source, name, read)
    }

    /// Like [`Self::open_beside`], for a file that is no text: `read` makes the text that a pack keeps of it, and is not
    /// called for a file in a pack.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open_beside_by(
        &self,
        source: &Source,
        name: &str,
        read: impl FnOnce(&Path) -> Result<Source, LibraryError>,
    ) -> Result<Source, LibraryError> {
        let kind = Kind::DeviceData;
        // Two descriptions in different folders may each have a file with this name.
        let beside = Path::new(&source.origin).file_name().unwrap_or_default().to_string_lossy();
        let key = format!("{beside}/{name}");
        if let Some(pack) = &self.packed {
            return pack.open(kind, &key);
        }
        let folder = Path::new(&source.origin).parent().unwrap_or(Path::new(""));
        let found = read(&folder.join(name))?;
        if let Some(opened) = &self.opened {
            opened.lock().unwrap_or_else(PoisonError::into_inner).add(kind, &key, &found);
        }
        Ok(found)
    }

    fn find(&self, kind: Kind, name: &str) -> Result<Source, LibraryError> {
        if is_path(name) {
            return read(Path::new(name));
        }
        let file = Path::new(kind.folder()).join(format!("{name}.toml"));
        // A plan saved by a campaign lies in a subfolder of its project.
        let folders = self.folder.iter().flat_map(|folder| [folder.as_path(), Path::new("")]);
        let mut paths = folders.map(|folder| folder.join(&file));
        if let Some(path) = paths.find(|path| path.is_file()) {
            return read(&path);
        }
        let shipped = SHIPPED.get_file(&file).and_then(include_dir::File::contents_utf8);
        match shipped {
            Some(text) => Ok(Source {
                origin: format!("test-plans/{}", file.display()),
                text: text.to_owned(),
            }),
            None => Err(LibraryError::UnknownName {
                kind,
                name: name.to_owned(),
                known: self.known(kind, name),
            }),
        }
    }
}

impl Library {
    /// The most similar name; without one, those of the project and those that ship.
    fn known(&self, kind: Kind, name: &str) -> String {
        let folder = self.folder.as_deref().filter(|folder| !folder.as_os_str().is_empty());
        let own = names_in(folder.unwrap_or(Path::new(".")), kind);
        // No description of a device ships; device files are in the same folder.
        let shipped = if kind == Kind::Description { Vec::new() } else { names(kind) };
        // A plan of a project is named by its file.
        // Where a file of that name is not found by it, it is named by its path.
        let is_file = |found: &str| {
            (kind == Kind::Plan || found == name) && own.iter().any(|own| own == found)
        };
        let whole = |found: &str| match is_file(found) {
            true => Path::new(kind.folder()).join(format!("{found}.toml")).display().to_string(),
            false => found.to_owned(),
        };
        if let Some(nearest) = nearest(name, &[own.as_slice(), &shipped].concat()) {
            return format!("did you mean `{}`?", whole(nearest));
        }
        let listed = |whose: &str, names: &[String]| {
            let names: Vec<String> = names.iter().map(|name| whole(name)).collect();
            (!names.is_empty()).then(|| format!("{whose}: {}", names.join(", ")))
        };
        let both = [listed("in this project", &own), listed("shipped", &shipped)];
        let known: Vec<String> = both.into_iter().flatten().collect();
        if known.is_empty() { "there is none".to_owned() } else { known.join("; ") }
    }

    /// The content of the file that `name` refers to, and its origin.
    ///
    /// # Errors
    /// When it is missing or invalid.
    pub fn read<T: DeserializeOwned>(
        &self,
        kind: Kind,
        name: &str,
    ) -> Result<(String, T), LibraryError> {
        let source = self.open(kind, name)?;
        let value = source.parse()?;
        Ok((source.origin, value))
    }
}

/// The content of the TOML file at `path`.
///
/// # Errors
/// When it cannot be read or is invalid.
pub fn read_file<T: DeserializeOwned>(path: &Path) -> Result<T, LibraryError> {
    read(path)?.parse()
}

impl Source {
    /// The file at `path`.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn of_file(path: &Path) -> Result<Self, LibraryError> {
        read(path)
    }

    /// The parsed TOML content.
    ///
    /// # Errors
    /// When it is invalid.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, LibraryError> {
        let read = toml::from_str(&self.text);
        Ok(read.map_err(|error| FileError::from_toml(&self.origin, &self.text, &error))?)
    }

    /// A mistake at the bytes `at`.
    pub fn mistake(&self, at: Range<usize>, message: String, help: Option<String>) -> LibraryError {
        FileError::new(&self.origin, &self.text, at, message).with_help(help).into()
    }

    /// An unknown name, with its place in this file; `None` for other errors, and for a name that is not in this file.
    pub fn placed(&self, error: &LibraryError) -> Option<LibraryError> {
        let LibraryError::UnknownName { name, .. } = error else { return None };
        let said = format!("\"{name}\"");
        let names_it = |begin: &usize| {
            let line = self.text[..*begin].rsplit('\n').next().unwrap_or_default();
            let key = line.trim_end_matches([' ', '=']).rsplit([' ', '{', ',']).next();
            !line.contains('#') && !OWN_NAMES.contains(&key.unwrap_or_default())
        };
        let begin = self.text.match_indices(&said).map(|(begin, _)| begin).find(names_it)?;
        let help = error.help().map(|help| help.to_string());
        Some(self.mistake(begin..begin + said.len(), error.to_string(), help))
    }
}

/// Keys whose strings name no file, nor does a comment.
const OWN_NAMES: [&str; 5] = ["name", "title", "doc", "paper", "random_numbers_of"];

/// Names of the shipped files of a kind, sorted.
pub fn names(kind: Kind) -> Vec<String> {
    let folder = match kind.folder() {
        "" => Some(&SHIPPED),
        folder => SHIPPED.get_dir(folder),
    };
    let mut names: Vec<String> = folder
        .into_iter()
        .flat_map(Dir::files)
        .filter_map(|file| file.path().file_name()?.to_str()?.strip_suffix(".toml"))
        .map(str::to_owned)
        .collect();
    names.sort();
    names
}

/// Names of the files of a kind in the folder of a project, sorted.
pub fn names_in(project: &Path, kind: Kind) -> Vec<String> {
    let files = project.join(kind.folder()).read_dir().into_iter().flatten();
    let paths = files.filter_map(|file| Some(file.ok()?.path()));
    let named = paths.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    let mut names: Vec<String> =
        named.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

fn is_path(name: &str) -> bool {
    name.contains('/') || Path::new(name).extension().is_some_and(|end| end == "toml")
}

fn read(path: &Path) -> Result<Source, LibraryError> {
    match reading::text(path) {
        Ok(text) => Ok(Source { origin: path.display().to_string(), text }),
        Err(cause) => Err(LibraryError::unreadable(path, cause)),
    }
}

#[cfg(test)]
mod tests;
