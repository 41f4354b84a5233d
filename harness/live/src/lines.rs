//! Where the lines of a running rig are, for programs that are not told by their arguments.
//!
//! A program under test finds them in the variable [`VARIABLE`]; anybody else on this machine in a file that the running
//! command keeps, and holds a lock on for as long as it runs: what is not locked was left behind, and says nothing.
//! Both hold the same document: `{"can0": {"port": "slcan:/dev/pts/4", "bit_rate": 500000}}`.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, DirBuilder, File};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use wire::can::BitRates;
use wire::serial::SerialSettings;

/// How many files this process has kept.
static KEPT: AtomicU32 = AtomicU32::new(0);

/// The variable of the environment.
pub const VARIABLE: &str = "HIL_LINES";

/// Where a line is, and how fast it is. Rates are in bits per second, as far as they are known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Place {
    /// What a program opens: `can:can0`, `slcan:/dev/pts/4`, `serial:/dev/pts/4`.
    port: String,
    /// Of a CAN bus.
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_rate: Option<u32>,
    /// Of the data of CAN FD frames, where the bus has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    data_bit_rate: Option<u32>,
    /// Of a serial line.
    #[serde(skip_serializing_if = "Option::is_none")]
    baud: Option<u32>,
}

impl Place {
    /// A port of which nothing else is known.
    pub(crate) fn of_port(port: impl ToString) -> Self {
        Self { port: port.to_string(), bit_rate: None, data_bit_rate: None, baud: None }
    }

    /// At these rates.
    pub(crate) fn with_rates(self, rates: BitRates) -> Self {
        Self { bit_rate: Some(rates.nominal), data_bit_rate: rates.data, ..self }
    }

    /// With these settings of a serial line.
    pub fn with_settings(self, settings: SerialSettings) -> Self {
        Self { baud: Some(settings.baud), ..self }
    }
}

/// Lines by name.
pub type Places = BTreeMap<String, Place>;

/// The document of these lines.
pub fn document(places: &Places) -> String {
    // Text and numbers by text always become JSON.
    serde_json::to_string(places).unwrap_or_default()
}

/// The file that says where the lines are, for as long as this exists.
#[derive(Debug)]
pub struct Kept {
    path: PathBuf,
    /// Locked.
    _file: File,
}

impl Kept {
    /// Keeps a file `PID-N.json` in the folder `hil` below `XDG_RUNTIME_DIR`, else in `hil-UID` below that for temporary
    /// files. N tells rigs of one process apart.
    fn new(places: &Places) -> io::Result<Self> {
        let folder = match std::env::var_os("XDG_RUNTIME_DIR").filter(|folder| !folder.is_empty()) {
            Some(folder) => Path::new(&folder).join("hil"),
            None => {
                let user = rustix::process::getuid().as_raw();
                std::env::temp_dir().join(format!("hil-{user}"))
            }
        };
        Self::below(&folder, places)
    }

    fn below(folder: &Path, places: &Places) -> io::Result<Self> {
        match DirBuilder::new().mode(0o700).create(folder) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            other => other?,
        }
        let found = fs::symlink_metadata(folder)?;
        // In a folder for everybody's temporary files somebody else may have been first.
        if !found.is_dir() || found.uid() != rustix::process::getuid().as_raw() {
            return Err(io::Error::other(format!("{} is not ours", folder.display())));
        }
        let number = KEPT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{}-{number}.json", std::process::id()));
        let mut file = File::create(&path)?;
        file.lock()?;
        file.write_all(document(places).as_bytes())?;
        Ok(Self { path, _file: file })
    }

    /// As [`Self::new`], where there are lines. Where it cannot be kept, programs beside this one do not find them, and nothing
    /// else is amiss.
    pub(crate) fn or_warn(places: &Places) -> Option<Self> {
        if places.is_empty() {
            return None;
        }
        let kept = Self::new(places);
        kept.inspect_err(|error| {
            tracing::warn!("other programs do not find the lines by name: {error}");
        })
        .ok()
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        // Without a lock it says nothing, should it stay.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::{BitRates, File, Kept, Place, Places, document, fs};

    fn places() -> Places {
        let bus = Place::of_port("slcan:/dev/pts/4")
            .with_rates(BitRates { nominal: 250_000, data: None });
        [("can0".to_owned(), bus)].into()
    }

    #[test]
    fn lines_are_told_by_name() {
        let told = r#"{"can0":{"port":"slcan:/dev/pts/4","bit_rate":250000}}"#;
        assert_eq!(document(&places()), told);
    }

    #[test]
    fn the_file_is_locked_while_it_is_kept_and_goes_then() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("hil");
        let kept = Kept::below(&folder, &places()).unwrap();
        let path = kept.path.clone();
        assert_eq!(fs::read_to_string(&path).unwrap(), document(&places()));
        let other = File::open(&path).unwrap();
        assert!(other.try_lock_shared().is_err(), "nobody sees that it is kept");
        drop(kept);
        assert!(other.try_lock_shared().is_ok() && !path.exists());
    }
}
