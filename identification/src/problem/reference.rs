//! What a reference says at every row, also where it is known in few of them, and its noise, told from that of the readings.

use super::Channels;
use crate::dataset::{Column, Constant, Dataset};
use crate::robust;
use crate::signal::interpolate;
use std::ops::Range;

/// Widths of a reference that was evened out, from either end of a stretch, within which it is known from one side more than from
/// the other; a stretch that is not that many times as long keeps them.
const ENDS: f64 = 3.0;
const SPARES: f64 = 12.0;

/// Rows in which the reference `column` is as well known as elsewhere.
pub(super) fn known_around(dataset: &Dataset, column: &Column, channels: &Channels) -> Vec<bool> {
    let mut known = vec![true; channels.time.len()];
    let Some(width) = dataset.constants.get(&Constant::evened(&column.name)) else { return known };
    for range in &channels.segments {
        let ends = [channels.time[range.start], channels.time[range.end - 1]];
        if ends[1] - ends[0] < SPARES * width.si() {
            continue;
        }
        for row in range.clone() {
            let near = (channels.time[row] - ends[0]).min(ends[1] - channels.time[row]);
            known[row] = near >= ENDS * width.si();
        }
    }
    known
}

/// Share of the rows, those where it bends least, that tell the noise of a reference.
const STEADY: f64 = 0.8;
/// Times the spread of a reference about the line between its neighbours from which it makes a step.
const STEP: f64 = 8.0;

/// Standard deviation of the white noise of the reference `column`, which is `truth`, or was before it was evened out.
pub(super) fn noise_of(
    dataset: &Dataset,
    column: &Column,
    channels: &Channels,
    truth: &[f64],
    values: &[f64],
) -> f64 {
    let before = dataset.constants.get(&Constant::noise_of(&column.name));
    before.map_or(0.0, Constant::si).max(noise(channels, truth, values))
}

/// Standard deviation of the white noise of a reference. How far it stands off the line between its neighbours does not go
/// with the noise of the readings, but with what it lacks itself in the error: minus one and a half times its variance.
fn noise(channels: &Channels, truth: &[f64], values: &[f64]) -> f64 {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for range in &channels.segments {
        for row in range.start + 1..range.end.max(1) - 1 {
            let off = truth[row] - 0.5 * (truth[row - 1] + truth[row + 1]);
            let error = |row: usize| values[row] - truth[row];
            let of_error = error(row) - 0.5 * (error(row - 1) + error(row + 1));
            if (off + of_error).is_finite() {
                found.push((off, of_error));
            }
        }
    }
    // Beside a step the scale error of the readings would tell, which goes with it, and not the noise.
    let off: Vec<f64> = found.iter().map(|pair| pair.0).collect();
    let step = STEP * robust::spread(&off);
    found.retain(|pair| pair.0.abs() <= step);
    found.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    found.truncate((STEADY * found.len() as f64) as usize);
    let limit =
        robust::GROSS * robust::spread(&found.iter().map(|pair| pair.1).collect::<Vec<f64>>());
    found.retain(|pair| pair.1.abs() <= limit);
    let mean = found.iter().map(|(off, of)| off * of).sum::<f64>() / found.len().max(1) as f64;
    // Mean square of a standard normal value among those rows.
    const OF_THOSE: f64 = 0.4377;
    (-mean / (1.5 * OF_THOSE)).max(0.0).sqrt()
}

/// Whether most rows have a reference.
pub(super) fn is_dense(truth: &[f64]) -> bool {
    2 * truth.iter().filter(|value| value.is_finite()).count() > truth.len()
}

/// What is measured at every row: a dense reference, and what is missing of it on a line between its neighbours. Between sparse
/// references it follows a cubic through them, or the course of the readings less a smooth course of their error, whichever tells a
/// reference better from those around it.
pub(super) fn everywhere(channels: &Channels, truth: &[f64], readings: &[f64]) -> Vec<f64> {
    let mut found = Vec::with_capacity(truth.len());
    if is_dense(truth) {
        for range in &channels.segments {
            let (times, known) = finite(channels, range, truth);
            found.extend(range.clone().map(|row| interpolate(&times, &known, channels.time[row])));
        }
        found.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
        return found;
    }
    // The noise of a reading that has a reference is part of its error: a course that held it would explain it, by a delay.
    let others = readings.iter().zip(truth);
    let others = others.map(|(reading, truth)| if truth.is_finite() { f64::NAN } else { *reading });
    let course = channels.smooth(&others.collect::<Vec<f64>>()).level;
    let error: Vec<f64> = truth.iter().zip(&course).map(|(truth, value)| truth - value).collect();
    let missed = |of: &[f64], reach: usize| {
        let mut found = Vec::new();
        for range in &channels.segments {
            let (times, known) = finite(channels, range, of);
            for at in reach..times.len().saturating_sub(reach) {
                let around = |all: &[f64]| {
                    let mut near = all[at - reach..=at + reach].to_vec();
                    near.remove(reach);
                    near
                };
                found.push(known[at] - polynomial(&around(&times), &around(&known), times[at]));
            }
        }
        if found.is_empty() { f64::INFINITY } else { robust::spread(&found) }
    };
    // Noise of the references would be in what they are compared with, and a scale of zero would explain it.
    if !(missed(truth, 2) < missed(&error, 1)) {
        let error = channels.smooth(&error).level;
        let sum = |(reading, error): (&f64, &f64)| match reading + error {
            sum if sum.is_finite() => sum,
            _ if reading.is_finite() => *reading,
            _ => 0.0,
        };
        return course.iter().zip(&error).map(sum).collect();
    }
    for range in &channels.segments {
        let (times, known) = finite(channels, range, truth);
        for row in range.clone() {
            let time = channels.time[row];
            let above = times.partition_point(|other| *other <= time);
            let told = if above > 1 && above + 1 < times.len() {
                let four = above - 2..above + 2;
                polynomial(&times[four.clone()], &known[four], time)
            } else {
                interpolate(&times, &known, time)
            };
            let reading = if course[row].is_finite() { course[row] } else { 0.0 };
            found.push(if told.is_finite() { told } else { reading });
        }
    }
    found
}

/// Times and values of the rows of a stretch that have one.
fn finite(channels: &Channels, rows: &Range<usize>, of: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let known = rows.clone().filter(|&row| of[row].is_finite());
    known.map(|row| (channels.time[row], of[row])).unzip()
}

/// The polynomial through these points (Lagrange).
fn polynomial(times: &[f64], values: &[f64], at: f64) -> f64 {
    let share = |i: usize| -> f64 {
        (0..times.len())
            .filter(|&j| j != i)
            .map(|j| (at - times[j]) / (times[i] - times[j]))
            .product()
    };
    values.iter().enumerate().map(|(i, value)| value * share(i)).sum()
}

#[cfg(test)]
mod tests {
    use super::noise;
    use crate::dataset::{Column, Dataset, Kind, Role, Unit};
    use crate::problem::Channels;
    use chacha20::ChaCha8Rng;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn the_noise_of_a_reference_is_told_from_that_of_the_readings() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
        let times: Vec<f64> = (0..6000).map(|row| f64::from(row) * 0.1).collect();
        let true_values: Vec<f64> = times.iter().map(|time| 40.0 * (0.3 * time).sin()).collect();
        let columns = vec![Column::new("t", Role::Time, Unit::Second, times)];
        let dataset = Dataset::new("any", Kind::Sensor, columns, vec![0; 6000]);
        let channels = Channels::new(&dataset);
        // A staircase, of which two rows in five lie beside a step.
        let stairs: Vec<f64> = (0..6000).map(|row| f64::from(row / 5 % 11) * 30.0).collect();
        for (course, scale) in [(&true_values, 1.0), (&stairs, 1.01)] {
            for (of_reference, of_readings) in [(0.1, 0.3), (0.3, 0.1), (0.0, 0.3)] {
                let mut noisy = |scale: f64, size: f64| -> Vec<f64> {
                    course.iter().map(|value| scale * value + size * normal()).collect()
                };
                let (truth, readings) = (noisy(1.0, of_reference), noisy(scale, of_readings));
                let found = noise(&channels, &truth, &readings);
                assert!((found - of_reference).abs() < 0.06, "{found} of {of_reference}");
            }
        }
    }
}
