//! Cells that no instrument reads: their squares would drown every fit that is to tell them from the rest.

use super::{MOTION, TOLD, Wild};
use crate::dataset::{Column, Dataset, Role};
use crate::finding::SetAside;

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

fn of_column(column: &Column, time: Option<&Column>) -> Option<Wild> {
    let mut sizes: Vec<f64> = column.values.iter().map(|value| value.abs()).collect();
    sizes.retain(|size| size.is_finite());
    sizes.sort_by(f64::total_cmp);
    let largest = *sizes.last()?;
    let limit = (TIMES * sizes[((sizes.len() - 1) as f64 * TYPICAL) as usize]).max(BEYOND);
    let rows = (0..column.values.len()).filter(|&row| column.values[row].abs() > limit);
    let rows: Vec<usize> = rows.collect();
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
