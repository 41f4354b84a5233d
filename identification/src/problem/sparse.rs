//! What is measured, at every row, where its reference is known in few of them.

use super::channels::Channels;
use crate::robust;
use crate::signal::interpolate;
use std::ops::Range;

/// What is measured at every row: a dense reference, and what is missing of it on a line between its neighbours. Between sparse
/// references it follows a cubic through them, or the course of the readings corrected to them, whichever tells a reference
/// better from those around it.
pub(super) fn everywhere(channels: &Channels, truth: &[f64], readings: &[f64]) -> Vec<f64> {
    let known = truth.iter().filter(|value| value.is_finite()).count();
    let mut found = Vec::with_capacity(truth.len());
    if 2 * known > truth.len() {
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
    // Leaving a reference out doubles the distance between those around it: sixteen times the error of a cubic, four of a line.
    let by_readings = !(missed(truth, 2) < 4.0 * missed(&error, 1));
    for range in &channels.segments {
        let (times, known) = finite(channels, range, if by_readings { &error } else { truth });
        for row in range.clone() {
            let time = channels.time[row];
            let reading = if course[row].is_finite() { course[row] } else { 0.0 };
            let above = times.partition_point(|other| *other <= time);
            let told = match by_readings {
                false if above > 1 && above + 1 < times.len() => {
                    let four = above - 2..above + 2;
                    polynomial(&times[four.clone()], &known[four], time)
                }
                _ => interpolate(&times, &known, time),
            };
            let own = if by_readings { reading } else { 0.0 };
            found.push(if told.is_finite() { own + told } else { reading });
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
