//! Rejects files that only builds with the feature `files` read and write.

use super::error::{DatasetError, Defect};
use super::package::{Field, Table};
use super::table::Rows;
use std::io;

pub(super) fn read(
    _: &mut Rows,
    _: &[Field],
    table: &Table,
    _: usize,
    _: &mut Vec<String>,
) -> Result<(), DatasetError> {
    let end = table.path.extension().unwrap_or_default().to_string_lossy();
    let defect = Defect::Unsupported(format!("this build reads no .{end} files"));
    Err(DatasetError::new(&table.path, defect))
}

pub(super) fn packed(_: &[u8]) -> io::Result<Vec<u8>> {
    Err(unsupported())
}

pub(super) fn unpacked<R: io::BufRead>(_: R) -> io::Result<Box<dyn io::Read>> {
    Err(unsupported())
}

fn unsupported() -> io::Error {
    io::Error::new(io::ErrorKind::Unsupported, "this build has no compressed tables")
}
