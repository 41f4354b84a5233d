//! Reads and checks the rig that a plan names.

use crate::library::{Kind, Library, LibraryError, Source};
use crate::models;
use crate::plan::rig_build::{self, LogRead, Parts};
use crate::plan::{Plan, Rig};
use described::{Dbc, Dbcs, Description, FileError, Files, Steps};
use identification::finding::SCHEMA;
use identification::model::Model;
use plan::device_files::{DevicesError, load_devices};
use std::sync::Arc;

/// Why a rig cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RigError {
    /// The device file is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Devices(#[from] DevicesError),
    /// The rig file or a description is missing or invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Library(#[from] LibraryError),
    /// The description is invalid.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Description(#[from] Box<FileError>),
    /// A bus log that plays a node is invalid.
    #[cfg(feature = "logs")]
    #[error("{0}")]
    #[diagnostic(help(
        "the end of the name says what a log that plays a node is: .log (candump), .asc (Vector) or .trc (PEAK)"
    ))]
    Log(#[from] bus_log::LogError),
    /// A bus log in a format that a rig does not accept.
    #[error("{origin} is no candump log (.log), no Vector ASC (.asc) and no PEAK TRC (.trc)")]
    #[diagnostic(help("hil log convert {origin} drive.log"))]
    LogFormat {
        /// The file.
        origin: String,
    },
}

impl RigError {
    /// Adds the place in the file that names the missing one.
    pub(super) fn placed(self, file: &Source) -> Self {
        let missing = match &self {
            Self::Library(error) | Self::Devices(DevicesError::Library(error)) => {
                file.placed(error)
            }
            _ => None,
        };
        missing.map_or(self, Self::Library)
    }
}

/// Loads the rig that `plan` names.
///
/// # Errors
///
/// When it is missing or invalid.
pub fn load_rig(library: &Library, plan: &Plan) -> Result<Rig, RigError> {
    if let Some(name) = &plan.rig {
        return load_rig_named(library, name.as_str());
    }
    if let Some(name) = &plan.device {
        return Ok(Rig::of_device(Arc::new(load_description(library, name.as_str())?)));
    }
    let name = plan.devices.as_ref().map_or("", |name| name.as_str());
    Ok(Rig::of_robot(load_devices(library, name)?))
}

/// Loads the rig of that name or path.
///
/// # Errors
///
/// When it is missing or invalid.
pub fn load_rig_named(library: &Library, name: &str) -> Result<Rig, RigError> {
    let parts = Parts { description: load_description_with, log };
    rig_build::load(library, name, &parts).map_err(|error: RigError| {
        match library.open(Kind::Rig, name) {
            Ok(rig) => error.placed(&rig),
            // The missing file is the rig's own.
            Err(_) => error,
        }
    })
}

/// Reads a bus log.
#[cfg(feature = "logs")]
fn log(file: &Source) -> Result<LogRead, RigError> {
    use bus_log::{Format, LogReader};
    let path = std::path::Path::new(&file.origin);
    match Format::of_path(path) {
        // A rig accepts only text formats.
        Some(format @ (Format::Candump | Format::Asc | Format::Trc)) => {
            let text = std::io::Cursor::new(file.text.as_bytes());
            let mut reader = LogReader::new(path, text, format)?;
            let (entries, moved) = super::logged::logged(&mut reader, |earliest| earliest)?;
            Ok((entries, reader.notes().into_iter().chain(moved).collect()))
        }
        _ => Err(RigError::LogFormat { origin: file.origin.clone() }),
    }
}

/// A build without the feature `logs` reads no logs.
#[cfg(not(feature = "logs"))]
fn log(file: &Source) -> Result<LogRead, RigError> {
    Err(RigError::LogFormat { origin: file.origin.clone() })
}

/// Loads the description of that name or path, with the files beside it that it names.
///
/// # Errors
///
/// When one of them is missing or invalid.
pub fn load_description(library: &Library, name: &str) -> Result<Description, RigError> {
    load_description_with(library, name, &mut Dbcs::default())
}

fn load_description_with(
    library: &Library,
    name: &str,
    dbcs: &mut Dbcs,
) -> Result<Description, RigError> {
    let source = library.open(Kind::Description, name)?;
    let Source { origin, text } = &source;
    let mut files = Beside { library, source: &source, dbcs };
    Ok(Description::parse_with(origin, text, &mut files).map_err(Box::new)?)
}

/// The files beside a description.
struct Beside<'a> {
    library: &'a Library,
    source: &'a Source,
    dbcs: &'a mut Dbcs,
}

impl Files for Beside<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        let opened = self.library.open_beside(self.source, name);
        opened.map(|opened| opened.text).map_err(|error| error.to_string())
    }

    fn dbc(&mut self, name: &str, text: &str) -> Result<Arc<Dbc>, FileError> {
        self.dbcs.get(name, text)
    }

    fn errors(&mut self, name: &str, unit: &str) -> Result<Steps, String> {
        let text = self.text(name)?;
        let model = Model::from_toml(&text).map_err(|error| error.message().to_owned())?;
        if model.schema != SCHEMA {
            return Err(format!("schema {}, expected {SCHEMA}", model.schema));
        }
        models::reading(&model, unit)
    }

    #[cfg(feature = "fmu")]
    fn fmu(&mut self, name: &str) -> Result<Arc<dyn described::Fmu>, String> {
        let mut opened = None;
        let description = self.library.open_beside_by(self.source, name, |path| {
            let unreadable =
                |why: String| LibraryError::unreadable(path, std::io::Error::other(why));
            let (unit, text) = fmu::Unit::open(path).map_err(unreadable)?;
            opened = Some(unit);
            Ok(Source { origin: path.display().to_string(), text })
        });
        let description = description.map_err(|error| error.to_string())?;
        Ok(Arc::new(match opened {
            Some(unit) => unit,
            // A record or another machine has the description, and not the file.
            None => fmu::Unit::described(&description.text)?,
        }))
    }

    fn differ(&mut self, one: &str, other: &str) -> bool {
        temporal::units_differ(one, other)
    }
}
