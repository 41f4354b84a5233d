//! Writes an FMU.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

/// Writes a zip file with these files, each under its path. The same files give the same bytes.
///
/// # Errors
/// When it cannot be written.
pub fn write<'a>(
    path: &Path,
    files: impl IntoIterator<Item = (&'a str, &'a [u8])>,
) -> io::Result<()> {
    let mut archive = ZipWriter::new(File::create(path)?);
    let options = SimpleFileOptions::default();
    let options = options.last_modified_time(DateTime::default()).unix_permissions(0o755);
    for (name, bytes) in files {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
    }
    archive.finish()?;
    Ok(())
}
