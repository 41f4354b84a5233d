//! A row of a table.

use super::cell::Cell;
use wire::time::Timestamp;

/// One row, with a cell per column.
pub type Row<'a> = Vec<Cell<'a>>;

/// Time of a row.
pub(crate) fn time<'a>(at: Timestamp) -> Cell<'a> {
    at.as_secs_f64().into()
}
