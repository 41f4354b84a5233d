//! Samples of a gyro against a heading.

use super::channels::Channels;
use super::course::{course, turns, within};
use super::gyro::{GYRO_CONSTANTS, angle_unit, exposures, rate_unit};
use super::rate::{Rate, rates, slope, steps};
use super::{Aggregate, Block, wrap};
use crate::dataset::{Column, Dataset, Dimension, Role, Unit};
use crate::rounding;

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
    let read: Vec<f64> = rate.values.iter().map(|value| value / factor).collect();
    let nominal = turns(channels, &read, rate.is_mean, &steps);
    let headings = at_edges(channels, headings);
    let mut time_step = vec![0.0; headings.len()];
    for range in &channels.segments {
        time_step[range.start + 1..range.end].copy_from_slice(&steps[range.start + 1..range.end]);
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
    let (course, delay) = course(channels, (&rows, &residual), (&read, rate.is_mean), &nominal);
    // What is late shows at first what was before the record.
    let within = within(channels, delay);
    residual =
        residual.iter().zip(&rows).filter(|(_, row)| within[**row]).map(|(one, _)| *one).collect();
    rows.retain(|row| within[*row]);
    // From one heading to the next the turn has their noise, which is in the residual as well.
    for range in &channels.segments {
        if range.clone().filter(|&row| headings[row].is_finite()).count() >= HEADINGS_MIN {
            for row in range.start + 1..range.end {
                turned[row] = f64::midpoint(course[row - 1], course[row]) * time_step[row];
            }
        }
    }
    if channels.rotation.is_empty() {
        channels.rotation = course;
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

/// Headings in a stretch from which their noise can be told.
const HEADINGS_MIN: usize = 3;

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

/// Share of the changes of an encoder that is coarse beside its motion that are a single step of it.
const SINGLE: f64 = 0.5;
/// Changes that are enough to go by.
const CHANGES_MIN: usize = 50;

/// Headings of a coarse encoder where it steps: there it says the angle best, halfway between its values, and elsewhere it errs
/// like the angle itself. Other headings stay as they are.
fn at_edges(channels: &Channels, headings: Vec<f64>) -> Vec<f64> {
    let Some(step) = rounding::step(&headings) else { return headings };
    let known = |row: &usize| (headings[*row] + headings[row - 1]).is_finite();
    let rows = channels.segments.iter().flat_map(|range| range.start + 1..range.end);
    let rows: Vec<usize> = rows.filter(known).collect();
    let jump = |row: usize| wrap(headings[row] - headings[row - 1]);
    let changes: Vec<usize> =
        rows.iter().copied().filter(|&row| jump(row).abs() > 0.5 * step).collect();
    let single = changes.iter().filter(|&&row| jump(row).abs() < 1.5 * step).count();
    let is_coarse = 2 * changes.len() < rows.len() && single as f64 > SINGLE * changes.len() as f64;
    if !is_coarse || changes.len() < CHANGES_MIN {
        return headings;
    }
    // It stepped between the two rows, at that angle and about that time; it turns as it does from the edge before to the next.
    let edge = |row: usize| headings[row - 1] + 0.5 * jump(row);
    let time = |row: usize| f64::midpoint(channels.time[row - 1], channels.time[row]);
    let stretch = channels.segment_of_rows();
    let mut found = vec![f64::NAN; headings.len()];
    for (at, &row) in changes.iter().enumerate() {
        let near = &changes[at.saturating_sub(1)..changes.len().min(at + 2)];
        let near: Vec<usize> =
            near.iter().copied().filter(|other| stretch[*other] == stretch[row]).collect();
        let (first, last) = (near[0], near[near.len() - 1]);
        let rate = wrap(edge(last) - edge(first)) / (time(last) - time(first));
        let since = channels.time[row] - time(row);
        found[row] = edge(row) + if rate.is_finite() { rate * since } else { 0.0 };
    }
    found
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
    slope(&turned, &referenced)
}
