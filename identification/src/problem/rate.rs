//! Rates of gyros at every row.

use super::channels::Channels;
use crate::dataset::{Column, Dataset, Role};
use crate::robust::Moments;

/// Rate of a gyro at every row, in rad/s or counts, with missing values.
pub(super) struct Rate<'a> {
    pub(super) column: &'a Column,
    pub(super) values: Vec<f64>,
    /// Whether a value is the mean since the previous row.
    pub(super) is_mean: bool,
}

pub(super) fn rates<'a>(dataset: &'a Dataset, channels: &Channels) -> Vec<Rate<'a>> {
    let steps = steps(channels);
    let mut found = Vec::new();
    for column in &dataset.columns {
        match column.role {
            Role::GyroRate | Role::GyroCounts => {
                found.push(Rate { column, values: column.si().collect(), is_mean: false });
            }
            Role::GyroAngleIncrement => {
                let values = column.si().zip(&steps).map(|(angle, dt)| angle / dt).collect();
                found.push(Rate { column, values, is_mean: true });
            }
            _ => {}
        }
    }
    found
}

/// Time since the previous row; the typical one at the start of a stretch.
pub(super) fn steps(channels: &Channels) -> Vec<f64> {
    let typical = channels.interval();
    let mut found = vec![typical; channels.time.len()];
    for range in &channels.segments {
        for row in range.start + 1..range.end {
            found[row] = channels.time[row] - channels.time[row - 1];
        }
    }
    found
}

/// How much readings rise for one of their reference, by least squares; 1 if they show no slope. Of counts, those per unit of
/// rotation.
pub(super) fn slope(readings: &[f64], reference: &[f64]) -> f64 {
    let both = reference.iter().copied().zip(readings.iter().copied());
    let Moments { xx, xy, .. } = Moments::of(both.filter(|(r, c)| r.is_finite() && c.is_finite()));
    if xx > 0.0 && xy != 0.0 { xy / xx } else { 1.0 }
}
