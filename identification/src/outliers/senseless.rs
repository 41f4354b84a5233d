//! Cells that no instrument reads: their squares would drown every fit that is to tell them from the rest.

use super::{MOTION, TOLD, Wild};
use crate::dataset::{Column, Dataset, Role};
use crate::finding::SetAside;
use crate::robust;

/// What no field of the contract reaches in its unit, and how many times all others but a twentieth it must be.
const BEYOND: f64 = 1e15;
const TIMES: f64 = 1e6;
const TYPICAL: f64 = 0.95;

/// Those cells of every field but the time.
pub(crate) fn senseless(dataset: &Dataset) -> Vec<Wild> {
    let time = dataset.column(Role::Time);
    let fields = dataset.columns.iter().filter(|column| column.role != Role::Time);
    fields.filter_map(|column| of_column(column, time)).collect()
}

/// What loggers and sensors write where they have no value, if it is this many spans from all else, in at most one row of
/// this many.
const CODES: [f64; 14] = [
    -9999.9,
    -9999.0,
    -999.0,
    -127.0,
    999.0,
    9999.0,
    9999.9,
    99_999.0,
    -99_999.0,
    32_767.0,
    -32_768.0,
    65_535.0,
    2_147_483_647.0,
    -2_147_483_648.0,
];
const SPANS: f64 = 10.0;
const SELDOM: usize = 20;

/// Rows of a cause in which a code for no value stands.
fn codes(column: &Column) -> Vec<usize> {
    if !matches!(column.role, Role::Temperature | Role::Auxiliary) {
        return Vec::new();
    }
    let is_code = |value: f64| CODES.contains(&value);
    let is_other = |value: &f64| value.is_finite() && !is_code(*value);
    let (low, high) = robust::ends(column.values.iter().copied().filter(is_other));
    let is_far = |value: f64| high > low && (value - high).max(low - value) > SPANS * (high - low);
    let rows = (0..column.values.len())
        .filter(|&row| is_code(column.values[row]) && is_far(column.values[row]));
    let rows: Vec<usize> = rows.collect();
    if rows.len() * SELDOM > column.values.len() { Vec::new() } else { rows }
}

fn of_column(column: &Column, time: Option<&Column>) -> Option<Wild> {
    let mut sizes: Vec<f64> = column.values.iter().map(|value| value.abs()).collect();
    sizes.retain(|size| size.is_finite());
    sizes.sort_by(f64::total_cmp);
    let largest = *sizes.last()?;
    let limit = (TIMES * sizes[((sizes.len() - 1) as f64 * TYPICAL) as usize]).max(BEYOND);
    let rows = (0..column.values.len()).filter(|&row| column.values[row].abs() > limit);
    let mut rows: Vec<usize> = rows.collect();
    let mut limit = limit;
    if rows.is_empty() {
        rows = codes(column);
        limit = rows.iter().map(|&row| column.values[row].abs()).fold(limit, f64::min);
    }
    let at = |row: &usize| time.map_or(*row as f64, |time| time.values[*row]);
    (!rows.is_empty()).then(|| Wild {
        columns: vec![column.name.clone()],
        told: SetAside {
            quantity: column.name.clone(),
            rows: rows.len(),
            of: sizes.len(),
            limit,
            largest,
            unit: column.unit.text().to_owned(),
            times: rows.iter().take(TOLD).map(at).collect(),
        },
        rows,
        bridged: MOTION.contains(&column.role) || column.role == Role::GyroAngleIncrement,
    })
}
