//! Errors of readings and of references in the order of time, as outliers are looked for in them.

use super::apart::{REACH, from_neighbours};
use crate::fit::{Data, fit_terms, values_of};
use crate::model::{Acts, Shape};
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Aggregate, Block, Channels, Component, Problem, wrap};
use crate::robust::{self, median};
use crate::signal::running_total;
use std::ops::Range;

/// Errors of a quantity in the order of time.
pub(super) struct Errors {
    /// One per reading or reference, SI.
    pub value: Vec<f64>,
    pub row: Vec<usize>,
    /// Smallest difference of two readings.
    pub step: f64,
    /// Least distance of an outlier, one per error, whatever the others are.
    pub least: Vec<f64>,
    /// Motion in each row of the data that adds up to what is measured; empty if nothing does.
    pub motion: Vec<f64>,
}

impl Errors {
    /// Changes from row to row that stay, as far as the motion of that row is unlike that of the rows around: what a wrong
    /// reading of the motion leaves. A wheel that slips reads on evenly.
    pub fn changes(&self, run: &[usize]) -> Self {
        let next = |i: &usize| {
            let (row, before) = (self.row[*i], self.row[*i - 1]);
            row == before + 1 && run[row] == run[before]
        };
        let at: Vec<usize> = (1..self.row.len()).filter(next).collect();
        let unlike = from_neighbours(&self.motion, run);
        let change = |i: usize| {
            let side = |range: Range<usize>| median(self.value[range].to_vec());
            let stays =
                side(i..(i + STAYS).min(self.value.len())) - side(i.saturating_sub(STAYS)..i);
            let now = self.value[i] - self.value[i - 1];
            if now.abs() < stays.abs() { now } else { stays }
        };
        let value: Vec<f64> = at.iter().map(|&i| change(i)).collect();
        let is_unlike =
            |(&i, change): (&usize, &f64)| MOST * unlike[self.row[i]].abs() > change.abs();
        let least = |pair| if is_unlike(pair) { 0.0 } else { f64::INFINITY };
        Self {
            least: at.iter().zip(&value).map(least).collect(),
            value,
            row: at.iter().map(|&i| self.row[i]).collect(),
            step: self.step,
            motion: Vec::new(),
        }
    }
}

/// How many times the unlike part of a motion a change can be: neighbours tell a motion only roughly.
const MOST: f64 = 2.0;
/// Number of rows over which a change must stay.
const STAYS: usize = 3;

/// What `terms` leave of a block.
pub(super) fn residual(block: &Block, channels: &Channels, terms: &[Shape]) -> Errors {
    let layout = Layout::new(block, channels);
    let data = Data::new(block, channels, &layout);
    let fit = fit_terms(data, terms, &NoiseModel::white(layout.runs()));
    let step = match block.aggregate {
        Aggregate::Row => step(&block.raw) * block.raw_si.abs(),
        _ => 0.0,
    };
    Errors {
        least: vec![0.0; block.rows.len()],
        value: data.left(terms, &values_of(&fit)),
        row: block.rows.clone(),
        step,
        motion: match block.aggregate {
            Aggregate::Level => {
                block.exposure(Acts::Scale).map_or_else(Vec::new, |one| one.per_row.clone())
            }
            _ => Vec::new(),
        },
    }
}

/// Smallest difference of two readings.
fn step(readings: &[f64]) -> f64 {
    let mut sorted = readings.to_vec();
    sorted.sort_by(f64::total_cmp);
    // One reading that is far off does not say how finely the others are written.
    let least = RESOLVED * robust::spread(readings);
    let steps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let step = steps.filter(|step| *step > least).fold(f64::INFINITY, f64::min);
    if step.is_finite() { step } else { 0.0 }
}

/// Share of the typical size of readings below which a difference is rounding of the numbers.
const RESOLVED: f64 = 1e-9;

/// Errors of dead reckoning at each reference, in x, y and heading (as metres at a metre's distance).
pub(super) fn poses(problem: &Problem) -> Vec<Errors> {
    let Some(path) = &problem.path else { return Vec::new() };
    let [x, y, heading] = &path.reference;
    let quantities = [
        (Component::X, x, &path.distance),
        (Component::Y, y, &path.distance),
        (Component::Heading, heading, &path.turn),
    ];
    quantities
        .map(|(component, reference, motion)| {
            let motion = motion.clone();
            let way: Vec<f64> = motion.iter().map(|one| one.abs()).collect();
            let way = running_total(&way);
            let mut errors =
                Errors { value: Vec::new(), row: Vec::new(), step: 0.0, least: Vec::new(), motion };
            for run in &path.runs {
                let Some(start) = path.first_whole(run) else { continue };
                let first = errors.value.len();
                for (row, (x, y, heading)) in (start..run.end).zip(path.reckon(start, run.end)) {
                    if !reference[row].is_finite() {
                        continue;
                    }
                    let value = match component {
                        Component::X => reference[row] - x,
                        Component::Y => reference[row] - y,
                        Component::Heading => {
                            let last = &errors.value[first..];
                            let last = median(last[last.len().saturating_sub(REACH)..].to_vec());
                            last + wrap(reference[row] - heading - last)
                        }
                    };
                    errors.value.push(value);
                    errors.row.push(row);
                }
            }
            // Between two references the given place is off by at most what the robot moves between them.
            let row = |i: usize| errors.row[i.min(errors.row.len() - 1)];
            let moved = |i: usize| way[row(i + 1)] - way[row(i.saturating_sub(1))];
            errors.least = (0..errors.row.len()).map(moved).collect();
            errors
        })
        .into()
}
