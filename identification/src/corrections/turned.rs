//! How far a gyro turns between headings, and how far they turn: what tells its sign and its unit, where one reading beside one
//! heading tells nothing.

use crate::dataset::{Axis, Column, Dataset, Dimension, Kind, Role};
use crate::problem::{runs, wrap};
use crate::robust::squared_correlation;

/// Headings from one of a pair to the other: the noise of a dense heading is more than it turns from row to row.
const STRIDES: [usize; 5] = [1, 3, 10, 30, 100];
/// Minimum number of pairs.
const PAIRS_MIN: usize = 10;

/// The heading that the readings of the gyro `column` are compared with, if there is no rate.
pub(crate) fn heading_of<'a>(dataset: &'a Dataset, column: &Column) -> Option<&'a Column> {
    let find = |role| dataset.columns_of(role).find(|one| Axis::agree(one.axis, column.axis));
    let is_series = dataset.kind == Kind::Series && column.role.is_gyro();
    if !is_series || find(Role::ReferenceRate).is_some() {
        return None;
    }
    find(Role::ReferenceHeading)
}

/// What is true and what the gyro `column` says of the mean rate between headings, SI, over as many of them as it follows best.
pub(crate) fn turned(dataset: &Dataset, column: &Column, heading: &Column) -> [Vec<f64>; 2] {
    let times: Vec<f64> = match dataset.column(Role::Time) {
        Some(time) => time.si().collect(),
        None => (0..dataset.rows()).map(|row| row as f64).collect(),
    };
    let is_increment = column.unit.dimension() == Dimension::Angle;
    let readings: Vec<f64> = column.si().collect();
    let headings: Vec<f64> = heading.si().collect();
    // Time, heading without its jumps, and angle that the gyro says, where there is a heading.
    let mut marks: Vec<Vec<[f64; 3]>> = Vec::new();
    for run in runs(&dataset.run_of_row) {
        let mut found: Vec<[f64; 3]> = Vec::new();
        let (mut angle, mut last) = (0.0, None::<usize>);
        for row in run {
            if readings[row].is_finite() {
                angle += match last {
                    _ if is_increment => readings[row],
                    Some(last) => {
                        0.5 * (readings[row] + readings[last]) * (times[row] - times[last])
                    }
                    None => 0.0,
                };
                last = Some(row);
            }
            if headings[row].is_finite() {
                let before = found.last().map_or(headings[row], |mark| mark[1]);
                found.push([times[row], before + wrap(headings[row] - before), angle]);
            }
        }
        marks.push(found);
    }
    let over = |stride: usize| -> [Vec<f64>; 2] {
        let pairs = marks.iter().flat_map(|run| {
            let ends = run.iter().step_by(stride).zip(run.iter().skip(stride).step_by(stride));
            ends.map(|(from, to)| [0, 1, 2].map(|of| to[of] - from[of]))
        });
        pairs
            .filter(|[time, ..]| *time > 0.0)
            .map(|[time, a, b]| (a / time, b / time))
            .unzip()
            .into()
    };
    let follows = |pair: &[Vec<f64>; 2]| squared_correlation(&pair[0], &pair[1]);
    STRIDES
        .map(over)
        .into_iter()
        .filter(|pair| pair[0].len() >= PAIRS_MIN)
        .max_by(|a, b| follows(a).total_cmp(&follows(b)))
        .unwrap_or_default()
}
