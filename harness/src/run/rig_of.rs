//! Reads and checks the rig that a plan names.

use crate::library::{Kind, Library, LibraryError, Source};
use crate::models;
use crate::plan::replayed::Logged;
use crate::plan::rig_build::{self, LogRead, Parts};
use crate::plan::{Plan, Rig};
use described::{Dbc, Dbcs, Description, FileError, Files, Steps};
use identification::finding::SCHEMA;
use identification::model::Model;
use plan::device_files::{DevicesError, load_devices};
#[cfg(feature = "logs")]
use record::figures;
#[cfg(feature = "logs")]
use std::collections::BTreeMap;
use std::sync::Arc;
#[cfg(feature = "logs")]
use wire::device::Transmit;
#[cfg(feature = "logs")]
use wire::time::Span;

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
            let (entries, moved) = logged(&mut reader)?;
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

/// Converts a log, from its first entry on, without error frames. An entry that is earlier than the one before it counts
/// as of that time; the note says how many there are.
///
/// # Errors
///
/// When it cannot be read to its end.
#[cfg(feature = "logs")]
pub fn logged(
    entries: impl IntoIterator<Item = Result<bus_log::Entry, bus_log::LogError>>,
) -> Result<(Vec<Logged>, Option<String>), bus_log::LogError> {
    let mut log = Vec::new();
    let (mut origin, mut latest, mut last) = (None, Span::ZERO, Span::ZERO);
    let (mut earlier, mut by) = (0_u64, Span::ZERO);
    let mut channels: BTreeMap<bus_log::Channel, Arc<str>> = BTreeMap::new();
    for entry in entries {
        let entry = entry?;
        let what = match entry.payload {
            bus_log::Payload::Frame(frame) => Transmit::Frame(frame),
            bus_log::Payload::Serial(packet) => Transmit::Bytes(packet),
            bus_log::Payload::Error(_) => continue,
        };
        let at = entry.at.since(*origin.get_or_insert(entry.at));
        if at < latest {
            earlier += 1;
            by = by.max(latest - at);
        }
        latest = latest.max(at);
        // The order of the log is kept: of several at one time each is a nanosecond later than the one before.
        last = if log.is_empty() { at } else { at.max(last + Span::from_nanos(1)) };
        let channel =
            channels.entry(entry.channel).or_insert_with(|| entry.channel.as_str().into());
        let sent = entry.direction.map(|direction| direction == bus_log::Direction::Tx);
        log.push(Logged { at: last, channel: Arc::clone(channel), what, sent });
    }
    let note = (earlier > 0).then(|| {
        let (entries, by) = (figures::counted(earlier, "entry", "entries"), by.as_secs_f64());
        let verb = if earlier == 1 { "is" } else { "are" };
        format!(
            "{entries} {verb} earlier than one before, by up to {by} s: they count as of its time"
        )
    });
    Ok((log, note))
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
