//! Rejects tables in MDF files when the feature `mdf` is off.

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
    let defect = Defect::Unsupported("this build reads no MDF files".to_owned());
    Err(DatasetError::new(&table.path, defect))
}
