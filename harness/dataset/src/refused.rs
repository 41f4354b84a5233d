//! Rejects tables in files that only other builds read.

use super::error::{DatasetError, Defect};
use super::package::{Field, Table};
use super::table::Rows;

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
