//! A low-pass of what is measured at first sight, whatever its state was when each stretch of time began.

use super::rests;
use crate::fit::Data;
use crate::linear::{Normal, dot};
use crate::model::{Acts, Driver, Form, Shape, Wrap};

/// Factor between time constants that are tried, from a part of a sample up to a share of the longest stretch.
const FACTOR: f64 = 1.5;
const SHORTEST: f64 = 0.5;
const LONGEST: f64 = 0.1;
/// Maximum number of stretches: of more, each begins with a small part of the record.
const STRETCHES_MAX: usize = 30;
/// Rows that take part.
const ROWS: usize = 3000;
/// Share of the squares that must be left at most.
const LEFT_MAX: f64 = 0.5;

/// The low-pass that leaves least of the readings beside a bias, a scale and what its state at each beginning leaves.
pub(super) fn lag(data: Data<'_>) -> Option<Shape> {
    let scale = data.block.exposure(Acts::Scale)?;
    if !data.channels.sampled || data.channels.segments.len() > STRETCHES_MAX {
        return None;
    }
    let stride = data.block.rows.len().div_ceil(ROWS).max(1);
    let thinned = |column: &[f64]| column.iter().step_by(stride).copied().collect::<Vec<f64>>();
    let target = thinned(&data.block.residual);
    let of_rows: Vec<f64> = data.block.rows.iter().map(|&row| scale.per_row[row]).collect();
    let plain = vec![vec![1.0; target.len()], thinned(&of_rows)];
    let left = |columns: &[Vec<f64>]| Normal::of(columns, &target).left(dot(&target, &target));
    let (interval, span) = (data.channels.interval(), data.channels.span());
    let mut best: Option<(f64, Shape)> = None;
    let mut constant = SHORTEST * interval;
    while constant < LONGEST * span {
        let driver = Driver::new(Wrap::LagOf, &data.channels.rotation_name);
        let shape = Shape::new("bandwidth", Acts::Delay, driver, Form::Delay)
            .with("time_constant", constant);
        let rests = rests(data, &shape)?;
        let beside: Vec<Vec<f64>> =
            rests.iter().map(|(_, rest)| thinned(rest)).chain(plain.clone()).collect();
        let mut columns = beside.clone();
        columns.extend(data.columns(&shape).iter().map(|column| thinned(column)));
        if let Some((with, without)) = left(&columns).zip(left(&beside)) {
            let share = with / without;
            if share < best.as_ref().map_or(LEFT_MAX, |best| best.0) {
                best = Some((share, shape));
            }
        }
        constant *= FACTOR;
    }
    Some(best?.1)
}
