//! `hil export DEVICE --fmu`: a described device as a functional mock-up unit.

use super::failure::Failure;
use super::own::may_replace;
use super::say;
use clap::ValueEnum;
use described::{Description, Files, Fmu, Steps};
use fmu_device::{DEVICE, IDENTIFIER, LIBRARY, Version, model_description, packed};
use plan::library::{Kind, Library, LibraryError, Source};
use record::outcome::Outcome;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Versions of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum Fmi {
    /// FMI 2.0.
    #[value(name = "2")]
    Two,
    /// FMI 3.0.
    #[default]
    #[value(name = "3")]
    Three,
}

/// The files that a description names, as they are read.
struct Read<'a> {
    library: Library,
    source: &'a Source,
    files: BTreeMap<String, String>,
}

impl Files for Read<'_> {
    fn text(&mut self, name: &str) -> Result<String, String> {
        let opened = self.library.open_beside(self.source, name);
        let text = opened.map_err(|error| error.to_string())?.text;
        self.files.insert(packed(name), text.clone());
        Ok(text)
    }

    fn errors(&mut self, _: &str, _: &str) -> Result<Steps, String> {
        Err("an FMU of a device cannot have identified models".to_owned())
    }

    fn fmu(&mut self, _: &str) -> Result<Arc<dyn Fmu>, String> {
        Err("an FMU of a device cannot have an FMU of its own".to_owned())
    }
}

/// Writes the device in the file `device` as an FMU.
pub(super) fn fmu(
    device: &Path,
    out: &Path,
    version: Fmi,
    library: Option<&Path>,
) -> Result<Outcome, Failure> {
    may_replace(out, "fmu")?;
    let name = device.to_string_lossy();
    let library = match library {
        Some(library) => library.to_owned(),
        None => beside().ok_or_else(|| {
            Failure::arguments(
                format!("failed to find {LIBRARY}, the library in each FMU"),
                format!(
                    "`cargo build --release -p fmu-device` in a clone of hil makes it: name \
                     target/release/deps/{LIBRARY} by --library, or copy it to lib/hil beside the folder of hil"
                ),
            )
        })?,
    };
    let code = std::fs::read(&library).map_err(|error| {
        let message = format!("failed to read {}: {error}", library.display());
        Failure::arguments(message, format!("--library names {LIBRARY}, the library in each FMU"))
    })?;
    let function = match version {
        Fmi::Two => "fmi2Instantiate",
        Fmi::Three => "fmi3InstantiateCoSimulation",
    };
    if !code.starts_with(b"\x7fELF")
        || !code.windows(function.len()).any(|part| part == function.as_bytes())
    {
        return Err(Failure::arguments(
            format!("{} is no library with the function {function}", library.display()),
            format!("--library names {LIBRARY}, the library in each FMU"),
        ));
    }
    let known = Library::beside(&name);
    let source = known.open(Kind::Description, &name)?;
    let mut files = Read { library: known, source: &source, files: BTreeMap::new() };
    let described = Description::parse_with(&source.origin, &source.text, &mut files);
    let described = described.map_err(LibraryError::from)?;
    let version = match version {
        Fmi::Two => Version::Two,
        Fmi::Three => Version::Three,
    };
    let xml = model_description(&described, version, &identity(&source.text, &files.files));
    let code_name = fmu::library_path(version == Version::Three, IDENTIFIER);
    let device_name = format!("resources/{DEVICE}");
    let mut all = vec![
        ("modelDescription.xml", xml.as_bytes()),
        (code_name.as_str(), code.as_slice()),
        (device_name.as_str(), source.text.as_bytes()),
    ];
    let named = files.files.iter().map(|(name, text)| (format!("resources/{name}"), text));
    let named: Vec<_> = named.collect();
    all.extend(named.iter().map(|(name, text)| (name.as_str(), text.as_bytes())));
    fmu::write(out, all).map_err(|error| Failure::file(out, error))?;
    let variables = xml.matches(" causality=\"").count();
    say(&format!("{}: the device {} with {variables} variables\n", out.display(), described.name))?;
    Ok(Outcome::Passed)
}

/// Another device has another identity.
fn identity(text: &str, files: &BTreeMap<String, String>) -> String {
    let hash = |salt: u8| {
        let mut hasher = DefaultHasher::new();
        (salt, env!("CARGO_PKG_VERSION"), text, files).hash(&mut hasher);
        hasher.finish()
    };
    let hex = format!("{:016x}{:016x}", hash(0), hash(1));
    let parts = [&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]];
    format!("{{{}}}", parts.join("-"))
}

/// The build folders of the clone out of which this program was installed: `cargo install` leaves the library there.
const BUILT: [&str; 2] = [
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/release/deps"),
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/debug/deps"),
];

/// The library where packages and builds have it.
fn beside() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    let folders = [folder.to_owned(), folder.join("deps"), folder.join("../lib/hil")];
    let folders = folders.into_iter().chain(BUILT.map(PathBuf::from));
    folders.map(|folder| folder.join(LIBRARY)).find(|path| path.is_file())
}
