//! Samples of a gyro against a heading.

use super::channels::Channels;
use super::gyro::{GYRO_CONSTANTS, angle_unit, exposures, rate_unit};
use super::rate::{Rate, counts_per_unit, rates, steps};
use super::reference::is_dense;
use super::{Aggregate, Block, wrap};
use crate::dataset::{Column, Dataset, Dimension, Role, Unit};
use crate::signal::running_total;

pub(super) fn against_heading(
    rate: &Rate<'_>,
    reference: &Column,
    channels: &mut Channels,
    counts: &mut Option<f64>,
) -> Block {
    let headings: Vec<f64> = reference.si().collect();
    let steps = steps(channels);
    let is_counts = rate.column.unit.dimension() == Dimension::Count;
    let factor = if is_counts {
        *counts.get_or_insert_with(|| counts_from_heading(rate, &headings, &steps, channels))
    } else {
        1.0
    };
    let known = |row: usize| rate.values[row].is_finite();
    let mut nominal = vec![0.0; headings.len()];
    let mut time_step = vec![0.0; headings.len()];
    for range in channels.segments.clone() {
        for row in range.start + 1..range.end {
            let now = if known(row) { rate.values[row] } else { 0.0 };
            let before = if known(row - 1) { rate.values[row - 1] } else { now };
            let mean = if rate.is_mean { now } else { (now + before) / 2.0 };
            nominal[row] = mean / factor * steps[row];
            time_step[row] = steps[row];
        }
    }
    let mut measured = 0.0;
    let mut rows = Vec::new();
    let mut residual = Vec::new();
    let mut last: Option<f64> = None;
    for row in 0..headings.len() {
        if row > 0 && channels.run[row] != channels.run[row - 1] {
            measured = 0.0;
            last = None;
        }
        measured += nominal[row];
        if headings[row].is_finite() {
            let difference = measured - headings[row];
            let unwrapped =
                last.map_or_else(|| wrap(difference), |last| last + wrap(difference - last));
            last = Some(unwrapped);
            rows.push(row);
            residual.push(unwrapped);
        }
    }
    let mut turned = turned(channels, (&rows, &residual), &nominal, &time_step);
    // Where headings are dense the gyro's own rate is no truth: it is as late as the gyro and has its noise.
    let smooth = is_dense(&headings).then(|| channels.smooth(&running_total(&turned)));
    if let Some(smooth) = &smooth {
        // From row to row a heading turns by little more than its own noise.
        for range in &channels.segments {
            for row in range.start + 1..range.end {
                turned[row] = smooth.level[row] - smooth.level[row - 1];
            }
        }
    }
    if channels.rotation.is_empty() {
        let own = || rate.values.iter().map(|v| if v.is_finite() { v / factor } else { 0.0 });
        channels.rotation = smooth.map_or_else(|| own().collect(), |smooth| smooth.slope);
        channels.rotation_unit = if rate.column.unit.dimension() == Dimension::AngularRate {
            rate.column.unit
        } else {
            Unit::DegreePerSecond
        };
    }
    if channels.of(Role::Heading).is_none() {
        let dense = heading_between(channels, &headings, &nominal);
        channels.add(&reference.name, Role::Heading, reference.unit, dense);
    }
    let unit = if is_counts { rate_unit(reference.unit) } else { rate_unit(rate.column.unit) };
    // What stands shows no scale error.
    let at_rest = rows.windows(2).all(|two| headings[two[0]] == headings[two[1]]);
    Block {
        aggregate: Aggregate::Level,
        raw_si: rate.column.unit.si() / factor,
        residual,
        exposures: exposures((time_step.clone(), unit), (!at_rest).then_some(turned)),
        constants: GYRO_CONSTANTS[..if at_rest { 1 } else { 2 }].to_vec(),
        activity: Some(time_step),
        ..Block::of_readings(rate.column, rows, |_| 0.0, angle_unit(reference.unit))
    }
}

/// True turn in each row: what the gyro says of it, and the error since the reference before, spread evenly over the time in
/// between. A scale error is one of this, and not of what the gyro says, whose noise and delay are in the residual as well.
fn turned(
    channels: &Channels,
    (rows, residual): (&[usize], &[f64]),
    nominal: &[f64],
    time_step: &[f64],
) -> Vec<f64> {
    let mut turned = nominal.to_vec();
    let stretch = channels.segment_of_rows();
    for at in 1..rows.len() {
        let (before, now) = (rows[at - 1], rows[at]);
        if stretch[before] != stretch[now] {
            continue;
        }
        let between = before + 1..=now;
        let time: f64 = time_step[between.clone()].iter().sum();
        if time > 0.0 {
            let error = (residual[at] - residual[at - 1]) / time;
            for row in between {
                turned[row] -= error * time_step[row];
            }
        }
    }
    turned
}

/// Whether a run has two headings, so that something is compared.
pub(super) fn shows_turns(reference: &Column, channels: &Channels) -> bool {
    let known = (0..channels.run.len()).filter(|&row| reference.values[row].is_finite());
    let runs: Vec<usize> = known.map(|row| channels.run[row]).collect();
    runs.windows(2).any(|two| two[0] == two[1])
}

/// A gyro on a robot whose heading was measured.
pub(super) fn beside_odometry(dataset: &Dataset, channels: &mut Channels) -> Vec<Block> {
    let Some(reference) = dataset.column(Role::ReferenceHeading) else {
        return Vec::new();
    };
    let rates = rates(dataset, channels);
    let mut counts = None;
    rates.iter().map(|rate| against_heading(rate, reference, channels, &mut counts)).collect()
}

/// Heading at every row: references, and the gyro between them.
fn heading_between(channels: &Channels, headings: &[f64], nominal: &[f64]) -> Vec<f64> {
    let mut dense = Vec::with_capacity(headings.len());
    let mut now = 0.0;
    for row in 0..headings.len() {
        let starts = channels.segments.iter().any(|range| range.start == row);
        now = if headings[row].is_finite() {
            headings[row]
        } else if starts {
            0.0
        } else {
            now + nominal[row]
        };
        dense.push(now);
    }
    dense
}

/// Counts per rad/s if only headings are known: turned counts against turned headings, between consecutive references.
fn counts_from_heading(
    rate: &Rate<'_>,
    headings: &[f64],
    steps: &[f64],
    channels: &Channels,
) -> f64 {
    let (mut turned, mut referenced) = (Vec::new(), Vec::new());
    let (mut sum, mut last) = (0.0, None::<f64>);
    for row in 0..headings.len() {
        if row > 0 && channels.run[row] != channels.run[row - 1] {
            (sum, last) = (0.0, None);
        }
        sum += if rate.values[row].is_finite() { rate.values[row] * steps[row] } else { 0.0 };
        if headings[row].is_finite() {
            if let Some(last) = last {
                turned.push(sum);
                referenced.push(wrap(headings[row] - last));
            }
            (sum, last) = (0.0, Some(headings[row]));
        }
    }
    counts_per_unit(&turned, &referenced)
}
