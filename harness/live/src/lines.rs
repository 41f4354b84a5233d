//! The ports of a running rig's lines, for programs that do not get them as arguments.
//!
//! A program under test finds them in the variable [`VARIABLE`]; another program on this machine finds them in a file
//! that the running command keeps locked: a file without a lock is a leftover and means nothing. Both hold the same
//! document: `{"can0": {"port": "slcan:/dev/pts/4", "bit_rate": 500000}}`.

use record::locked::Locked;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, DirBuilder, File};
use std::io::{self, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use wire::can::BitRates;
use wire::serial::SerialSettings;

/// Number of files kept by this process.
static KEPT: AtomicU32 = AtomicU32::new(0);

pub const VARIABLE: &str = "HIL_LINES";

/// Port and speed of a line. Rates are in bits per second, if known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Port to open: `can:can0`, `slcan:/dev/pts/4`, `serial:/dev/pts/4`.
    port: String,
    /// Rate of a CAN bus.
    #[serde(skip_serializing_if = "Option::is_none")]
    bit_rate: Option<u32>,
    /// Data rate of CAN FD frames, if the bus has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    data_bit_rate: Option<u32>,
    /// Rate of a serial line.
    #[serde(skip_serializing_if = "Option::is_none")]
    baud: Option<u32>,
}

impl Place {
    /// A port of unknown speed. A path that begins at the folder of this process is made absolute: others are elsewhere.
    pub(crate) fn of_port(port: impl ToString) -> Self {
        let port = port.to_string();
        let absolute = port.split_once(':').and_then(|(kind, path)| {
            let path = std::path::absolute(path).ok().filter(|_| path.contains('/'))?;
            Some(format!("{kind}:{}", path.display()))
        });
        let port = absolute.unwrap_or(port);
        Self { port, bit_rate: None, data_bit_rate: None, baud: None }
    }

    pub(crate) fn with_rates(self, rates: BitRates) -> Self {
        Self { bit_rate: Some(rates.nominal), data_bit_rate: rates.data, ..self }
    }

    /// Adds the settings of a serial line.
    pub fn with_settings(self, settings: SerialSettings) -> Self {
        Self { baud: Some(settings.baud), ..self }
    }
}

pub type Places = BTreeMap<String, Place>;

pub fn document(places: &Places) -> String {
    // A map of text and numbers always serializes.
    serde_json::to_string(places).unwrap_or_default()
}

/// The file with the ports of the lines, kept for the lifetime of this value.
#[derive(Debug)]
pub struct Kept {
    path: PathBuf,
    _file: Locked,
}

impl Kept {
    /// Creates and locks the file `PID-N.json` in the folder `hil` in `XDG_RUNTIME_DIR`, else in `hil-UID` in the
    /// folder for temporary files. N distinguishes the rigs of one process.
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
        // In a shared folder for temporary files another user may have created it first.
        if !found.is_dir() || found.uid() != rustix::process::getuid().as_raw() {
            return Err(io::Error::other(format!("{} is not ours", folder.display())));
        }
        let number = KEPT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{}-{number}.json", std::process::id()));
        let mut file = File::create(&path)?;
        file.lock()?;
        file.write_all(document(places).as_bytes())?;
        Ok(Self { path, _file: Locked(file) })
    }

    /// Like [`Self::new`] if there are lines. Without the file, programs beside this one do not find the lines; nothing
    /// else fails.
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
        // If the file stays, it means nothing without its lock.
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
    fn a_path_is_told_as_from_anywhere() {
        let here = std::env::current_dir().unwrap();
        let port = |said: &str| Place::of_port(said).port;
        assert_eq!(port("slcan:./can.pty"), format!("slcan:{}", here.join("can.pty").display()));
        assert_eq!(port("can:can0"), "can:can0");
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
        // What a child process has until it runs its program.
        let _inherited = kept._file.0.try_clone().unwrap();
        drop(kept);
        assert!(other.try_lock_shared().is_ok() && !path.exists());
    }
}
