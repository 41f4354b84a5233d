//! Orthonormal columns.

use super::sums::{ROWS, dot, subtract};

/// Orthonormal columns that span what a model can explain.
#[derive(Debug, Clone, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

/// A column with less than this share of its length outside the basis counts as inside.
pub(super) const INDEPENDENT: f64 = 1e-6;

/// Removes the components along orthonormal `directions` from `columns`.
fn take_out(directions: &[Vec<f64>], columns: &mut [Vec<f64>]) {
    let rows = columns.first().map_or(0, Vec::len);
    let chunks = || (0..rows).step_by(ROWS).map(|from| from..(from + ROWS).min(rows));
    let mut shares = vec![0.0; directions.len() * columns.len()];
    for chunk in chunks() {
        let mut share = shares.iter_mut();
        for column in &*columns {
            for (q, share) in directions.iter().zip(&mut share) {
                *share += dot(&q[chunk.clone()], &column[chunk.clone()]);
            }
        }
    }
    for chunk in chunks() {
        let mut share = shares.iter();
        for column in &mut *columns {
            for (q, share) in directions.iter().zip(&mut share) {
                subtract(&mut column[chunk.clone()], *share, &q[chunk.clone()]);
            }
        }
    }
}

/// The same to the last digit, for columns of these lengths. Two passes suffice (Giraud, Langou and Rozloznik 2005), and one
/// where at least half of the length is left (Daniel, Gragg, Kaufman and Stewart 1976).
fn take_out_all(directions: &[Vec<f64>], columns: &mut [Vec<f64>], lengths: &[f64]) {
    if directions.is_empty() {
        return;
    }
    take_out(directions, columns);
    for (column, length) in columns.iter_mut().zip(lengths) {
        if !(2.0 * dot(column, column).sqrt() > *length) {
            take_out(directions, std::slice::from_mut(column));
        }
    }
}

impl Basis {
    /// Number of directions.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Its directions.
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Returns its directions.
    pub fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }

    /// Removes from `column` what the basis explains.
    pub fn project(&self, column: &mut Vec<f64>) {
        take_out(&self.columns, std::slice::from_mut(column));
    }

    /// Adds the new part of `column`; returns false if `column` has no new part.
    pub fn push(&mut self, column: Vec<f64>) -> bool {
        let before = self.len();
        self.extend(vec![column]);
        self.len() > before
    }

    /// Adds the new parts of `columns`.
    pub fn extend(&mut self, columns: Vec<Vec<f64>>) {
        let new = self.beyond(columns);
        self.columns.extend(new.columns);
    }

    /// The new parts of `columns`, orthonormal.
    pub fn beyond(&self, mut columns: Vec<Vec<f64>>) -> Self {
        let length = |column: &[f64]| dot(column, column).sqrt();
        let mut before = Vec::with_capacity(columns.len());
        columns.retain(|column| {
            let length = length(column);
            let counts = length > 0.0 && length.is_finite();
            counts.then(|| before.push(length));
            counts
        });
        take_out_all(&self.columns, &mut columns, &before);
        let mut new = Self::default();
        for (mut column, before) in columns.into_iter().zip(before) {
            let now = [length(&column)];
            take_out_all(&new.columns, std::slice::from_mut(&mut column), &now);
            let after = length(&column);
            if after > INDEPENDENT * before {
                column.iter_mut().for_each(|value| *value /= after);
                new.columns.push(column);
            }
        }
        new
    }

    /// How much of `column` the basis explains: the sum of squares of its parts along it.
    pub fn explained(&self, column: &[f64]) -> f64 {
        self.columns.iter().map(|q| dot(q, column).powi(2)).sum()
    }
}
