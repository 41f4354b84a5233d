//! The zip file of an FMU.

use crate::model::{Model, Version};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use zip::ZipArchive;

/// Most bytes of an unpacked FMU. Assumption: models with tables and meshes have less.
const BYTES_MAX: u64 = 2 << 30;
/// Most bytes of a description. Assumption: 100,000 variables of 300 bytes each.
const DESCRIPTION_BYTES_MAX: u64 = 32 << 20;

const DESCRIPTION: &str = "modelDescription.xml";
const RESOURCES: &str = "resources";

/// An open file.
pub struct Archive(ZipArchive<File>);

/// The library and the resources of an FMU in a folder, which goes with this.
#[derive(Debug)]
pub struct Unpacked {
    _folder: TempDir,
    pub library: PathBuf,
    pub resources: PathBuf,
}

/// A copy of a library.
#[derive(Debug)]
pub struct Copied {
    _folder: TempDir,
    pub path: PathBuf,
}

pub fn open(path: &Path) -> Result<Archive, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    ZipArchive::new(file).map(Archive).map_err(|error| format!("it is no FMU: {error}"))
}

/// The path of a library for this platform in an FMU.
pub fn library_path(is_three: bool, identifier: &str) -> String {
    let version = if is_three { Version::Three } else { Version::Two };
    format!("binaries/{}/{identifier}.so", platform(version))
}

/// The folder of libraries for this platform.
fn platform(version: Version) -> String {
    let processor = std::env::consts::ARCH;
    match (version, processor) {
        (Version::Two, "x86_64") => "linux64".to_owned(),
        (Version::Two, "x86") => "linux32".to_owned(),
        // FMI 2.0 names no others; tools use the names of 3.0.
        _ => format!("{processor}-linux"),
    }
}

impl Archive {
    pub fn description(&mut self) -> Result<String, String> {
        let entry = self.0.by_name(DESCRIPTION);
        let entry = entry.map_err(|error| format!("it has no {DESCRIPTION}: {error}"))?;
        let mut text = String::new();
        let read = entry.take(DESCRIPTION_BYTES_MAX + 1).read_to_string(&mut text);
        read.map_err(|error| format!("failed to read its {DESCRIPTION}: {error}"))?;
        if text.len() as u64 > DESCRIPTION_BYTES_MAX {
            return Err(format!("its {DESCRIPTION} is longer than 32 MiB"));
        }
        Ok(text)
    }

    /// Unpacks what this platform needs.
    pub fn unpack(&mut self, model: &Model) -> Result<Unpacked, String> {
        let platform = platform(model.version);
        let library = format!("binaries/{platform}/{}.so", model.identifier);
        if self.0.index_for_name(&library).is_none() {
            return Err(self.elsewhere(&library));
        }
        let folder = TempDir::with_prefix("hil-fmu-");
        let folder = folder.map_err(|error| format!("failed to unpack it: {error}"))?;
        let wanted = [format!("binaries/{platform}/"), format!("{RESOURCES}/")];
        let mut room = BYTES_MAX;
        for place in 0..self.0.len() {
            let mut entry = self.0.by_index(place).map_err(|error| error.to_string())?;
            let name = entry.name().map_err(|error| error.to_string())?.into_owned();
            if !wanted.iter().any(|folder| name.starts_with(folder)) || entry.is_dir() {
                continue;
            }
            let to = entry.enclosed_name().ok_or_else(|| format!("`{name}` leads out of it"))?;
            let to = folder.path().join(to);
            let copied = written(&mut entry, &to, room);
            room -= copied.map_err(|error| format!("failed to unpack `{name}`: {error}"))?;
        }
        let resources = folder.path().join(RESOURCES);
        std::fs::create_dir_all(&resources).map_err(|error| error.to_string())?;
        let library = folder.path().join(library);
        Ok(Unpacked { library, resources, _folder: folder })
    }

    /// Why there is no such library.
    fn elsewhere(&self, library: &str) -> String {
        let platforms = self.0.file_names().filter_map(|name| {
            let name = name.ok()?;
            let (platform, file) = name.strip_prefix("binaries/")?.split_once('/')?;
            (!file.is_empty()).then(|| platform.to_owned())
        });
        let mut platforms: Vec<_> = platforms.collect();
        platforms.sort_unstable();
        platforms.dedup();
        match platforms.is_empty() {
            true => format!("it has no library, expected {library}"),
            false => {
                format!("it has libraries for {}, expected {library}", platforms.join(", "))
            }
        }
    }
}

fn written(entry: &mut impl Read, to: &Path, room: u64) -> io::Result<u64> {
    if let Some(folder) = to.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let copied = io::copy(&mut entry.take(room + 1), &mut File::create(to)?)?;
    match copied <= room {
        true => Ok(copied),
        false => Err(io::Error::other("the FMU has more than 2 GiB")),
    }
}

impl Unpacked {
    /// A copy of the library in a folder of its own.
    pub fn copy(&self) -> Result<Copied, String> {
        let failed = |error: io::Error| format!("failed to copy its library: {error}");
        let folder = TempDir::with_prefix("hil-fmu-").map_err(failed)?;
        let path = folder.path().join(self.library.file_name().unwrap_or_default());
        std::fs::copy(&self.library, &path).map_err(failed)?;
        Ok(Copied { path, _folder: folder })
    }
}
