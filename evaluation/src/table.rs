//! Columns of a data set, rounded as an instrument writes them.

use identification::dataset::{Axis, Column, Role, Unit};

/// A column whose values are multiples of `step`; 0 leaves them as they are.
pub fn column(name: &str, role: Role, unit: Unit, values: Vec<f64>, step: f64) -> Column {
    let values = if step > 0.0 {
        values.into_iter().map(|x| (x / step).round() * step).collect()
    } else {
        values
    };
    Column::new(name, role, unit, values)
}

/// The same column, with an axis.
pub fn of_axis(mut column: Column, axis: Axis) -> Column {
    column.axis = Some(axis);
    column
}

/// Labels of `n` runs.
pub fn run_labels(n: usize) -> Vec<String> {
    (1..=n).map(|run| format!("run-{run:03}")).collect()
}

/// Angles wrapped into `[0, 360)` degrees.
pub fn wrapped(degrees: impl Iterator<Item = f64>) -> Vec<f64> {
    // The remainder of a tiny negative angle rounds up to the full turn itself.
    degrees.map(|x| x.rem_euclid(360.0)).map(|x| if x >= 360.0 { 0.0 } else { x }).collect()
}

/// `values` in the rows whose index within the run is a multiple of `every`, missing elsewhere.
pub fn sparse(values: Vec<f64>, row_in_run: impl Fn(usize) -> usize, every: usize) -> Vec<f64> {
    let keep = |k: usize| row_in_run(k).is_multiple_of(every);
    values.into_iter().enumerate().map(|(k, x)| if keep(k) { x } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_wrap_into_one_turn() {
        let wrapped = wrapped([-1e-18, -1.0, 360.0, 725.0].into_iter());
        assert_eq!(wrapped, [0.0, 359.0, 0.0, 5.0]);
    }

    #[test]
    fn sparse_cells_are_missing() {
        let cells = sparse(vec![1.0; 6], |k| k % 3, 2);
        let present: Vec<bool> = cells.iter().map(|x| !x.is_nan()).collect();
        assert_eq!(present, [true, false, true, true, false, true]);
    }
}
