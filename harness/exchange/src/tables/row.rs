//! A row of a table.

use super::cell::Cell;
use wire::time::Timestamp;

pub type Row<'a> = Vec<Cell<'a>>;

pub(crate) fn time<'a>(at: Timestamp) -> Cell<'a> {
    at.as_secs_f64().into()
}
