//! The file of a record.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The file of a record. Its errors contain the path, since they surface far from here, in the reason of a run.
#[derive(Debug)]
pub struct RecordFile {
    file: File,
    path: PathBuf,
}

impl RecordFile {
    /// Creates an empty file.
    ///
    /// # Errors
    /// When it cannot be created.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { file: File::create(path)?, path: path.to_owned() })
    }

    fn named(&self, error: io::Error) -> io::Error {
        io::Error::new(error.kind(), format!("{}: {error}", self.path.display()))
    }
}

impl Write for RecordFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|error| self.named(error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(|error| self.named(error))
    }
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::{RecordFile, Write};
    use std::path::Path;

    #[test]
    fn a_full_disk_is_named() {
        let mut file = RecordFile::create(Path::new("/dev/full")).unwrap();
        let error = file.write(b"record").unwrap_err();
        assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
        assert!(error.to_string().starts_with("/dev/full: "), "{error}");
    }
}
