//! Dead reckoning of a driven path, and its final distance from the reference.

use super::Moves;
use std::ops::Range;

/// A driven path: the motion of each row by odometry, and the reference poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Nominal distance of each row, m.
    pub distance: Vec<f64>,
    /// Nominal turn of each row, rad.
    pub turn: Vec<f64>,
    /// Reference x, y (m) and heading (rad) of each row; NaN where there is none.
    pub reference: [Vec<f64>; 3],
    /// Rows of each run.
    pub runs: Vec<Range<usize>>,
}

/// Error of dead reckoning over one run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PathError {
    /// Distance from the last reference position, m.
    pub position: f64,
    /// Heading at the last reference, rad.
    pub heading: f64,
    /// Mean square distance over all references of the run, m^2.
    pub position_mean_square: f64,
}

/// Contribution of a model to each row.
#[derive(Debug, Clone, PartialEq)]
pub struct Added {
    /// Turn, rad.
    pub turn: Vec<f64>,
    /// Distance, m.
    pub along: Vec<f64>,
    /// Displacement to the left, m: of a reference that does not sit on the axle.
    pub aside: Vec<f64>,
}

impl Added {
    /// Zero contribution to that many rows.
    pub fn nothing(rows: usize) -> Self {
        Self { turn: vec![0.0; rows], along: vec![0.0; rows], aside: vec![0.0; rows] }
    }

    /// The part that terms with these `moves` add to.
    pub fn of(&mut self, moves: Moves) -> &mut [f64] {
        match moves {
            Moves::Turns => &mut self.turn,
            Moves::Along => &mut self.along,
            Moves::Aside => &mut self.aside,
        }
    }
}

impl Path {
    /// First row of `run` where the whole pose is known.
    pub fn first_whole(&self, run: &Range<usize>) -> Option<usize> {
        let [xs, ys, headings] = &self.reference;
        run.clone()
            .find(|&row| xs[row].is_finite() && ys[row].is_finite() && headings[row].is_finite())
    }

    /// Nominal dead reckoning (x, y, heading) of the rows from `start` to `end`, from the reference at `start`.
    pub fn reckon(&self, start: usize, end: usize) -> Vec<(f64, f64, f64)> {
        let [xs, ys, headings] = &self.reference;
        let (mut x, mut y, mut heading) = (xs[start], ys[start], headings[start]);
        let mut found = vec![(x, y, heading)];
        for row in start + 1..end {
            let middle = heading + self.turn[row] / 2.0;
            x += self.distance[row] * middle.cos();
            y += self.distance[row] * middle.sin();
            heading += self.turn[row];
            found.push((x, y, heading));
        }
        found
    }

    /// Error of dead reckoning of run `run` from its first whole reference, with `added` in each row.
    pub fn error(&self, run: usize, added: &Added) -> Option<PathError> {
        let [xs, ys, headings] = &self.reference;
        let rows = self.runs.get(run)?.clone();
        let whole = |row: &usize| {
            xs[*row].is_finite() && ys[*row].is_finite() && headings[*row].is_finite()
        };
        let start = rows.clone().find(whole)?;
        let (mut x, mut y, mut heading) = (xs[start], ys[start], headings[start]);
        let mut error = PathError::default();
        let (mut sum, mut count) = (0.0, 0.0);
        for row in start + 1..rows.end {
            let step = self.distance[row] + added.along[row];
            let turned = self.turn[row] + added.turn[row];
            let aside = added.aside[row];
            let middle = heading + turned / 2.0;
            x += step * middle.cos() - aside * middle.sin();
            y += step * middle.sin() + aside * middle.cos();
            heading += turned;
            if xs[row].is_finite() && ys[row].is_finite() {
                let square = (x - xs[row]).powi(2) + (y - ys[row]).powi(2);
                sum += square;
                count += 1.0;
                error.position = square.sqrt();
            }
            if headings[row].is_finite() {
                error.heading = super::wrap(heading - headings[row]);
            }
        }
        error.position_mean_square = if count > 0.0 { sum / count } else { return None };
        Some(error)
    }
}
