//! Dead reckoning of a driven path, and its final distance from the reference.

use super::{Channels, Moves};
use std::ops::Range;

/// A driven path: the motion of each row by odometry, and the reference poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Nominal distance of each row, m.
    pub distance: Vec<f64>,
    /// Nominal turn of each row, rad.
    pub turn: Vec<f64>,
    /// Displacement of each row to the left of its chord, m, by a turn that is not even over it.
    pub bulge: Vec<f64>,
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

/// Chord of an arc over its length, for an arc that turns by this angle: between rows the robot drives an arc, and the
/// places of its ends lie a chord apart.
pub(super) fn chord(turned: f64) -> f64 {
    let half = turned / 2.0;
    if half.abs() > 1e-4 { half.sin() / half } else { 1.0 - half * half / 6.0 }
}

/// Displacement of each row to the left of its chord, m: where a robot speeds up in a turn it drives more of it late in
/// the row (Savage 1998, equation 48, in the plane). The motion changes from row to row as its neighbours say.
pub(super) fn bulges(distance: &[f64], turn: &[f64], channels: &Channels) -> Vec<f64> {
    let mut found = vec![0.0; distance.len()];
    // The first row of a stretch has no motion of its own.
    for range in channels.segments.iter().filter(|range| range.len() > 3) {
        let rows = range.start + 1..range.end;
        let (faster, sharper) = (slopes(&distance[rows.clone()]), slopes(&turn[rows.clone()]));
        for ((row, faster), sharper) in rows.zip(faster).zip(sharper) {
            found[row] = (turn[row] * faster - distance[row] * sharper) / 12.0;
        }
    }
    found
}

/// Change of `values` over a row, by the rows on both sides. None where only one side changes: there the motion starts or
/// stops between rows, and has no slope (van Leer 1977, equation 66).
pub(super) fn slopes(values: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; values.len()];
    for (i, three) in values.windows(3).enumerate() {
        let (before, after) = (three[1] - three[0], three[2] - three[1]);
        if before * after > 0.0 {
            let most = 2.0 * before.abs().min(after.abs());
            let central = (before + after) / 2.0;
            found[i + 1] = central.clamp(-most, most);
        }
    }
    found
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
            let way = self.distance[row] * chord(self.turn[row]);
            x += way * middle.cos() - self.bulge[row] * middle.sin();
            y += way * middle.sin() + self.bulge[row] * middle.cos();
            heading += self.turn[row];
            found.push((x, y, heading));
        }
        found
    }

    /// Error of dead reckoning of run `run` from its first whole reference, with `added` in each row.
    pub fn error(&self, run: usize, added: &Added) -> Option<PathError> {
        let [xs, ys, headings] = &self.reference;
        let rows = self.runs.get(run)?.clone();
        let start = self.first_whole(&rows)?;
        let (mut x, mut y, mut heading) = (xs[start], ys[start], headings[start]);
        let mut error = PathError::default();
        let mut is_told = false;
        for row in start + 1..rows.end {
            let turned = self.turn[row] + added.turn[row];
            let step = (self.distance[row] + added.along[row]) * chord(turned);
            let aside = self.bulge[row] + added.aside[row];
            let middle = heading + turned / 2.0;
            x += step * middle.cos() - aside * middle.sin();
            y += step * middle.sin() + aside * middle.cos();
            heading += turned;
            if xs[row].is_finite() && ys[row].is_finite() {
                error.position = ((x - xs[row]).powi(2) + (y - ys[row]).powi(2)).sqrt();
                is_told = true;
            }
            if headings[row].is_finite() {
                error.heading = super::wrap(heading - headings[row]);
            }
        }
        is_told.then_some(error)
    }
}

#[cfg(test)]
mod tests {
    use super::{Added, Path, slopes};

    /// Straight lines between rows would close a circle that is too large by a part in 250.
    #[test]
    fn a_circle_has_the_radius_that_its_wheels_say() {
        let (rows, turn, radius) = (21, 0.314, 2.0);
        let mut reference = [0.0, 0.0, 0.0].map(|start| vec![start; rows]);
        let last = turn * (rows - 1) as f64;
        for (values, end) in
            reference.iter_mut().zip([radius * last.sin(), radius * (1.0 - last.cos()), last])
        {
            values[rows - 1] = end;
        }
        let path = Path {
            distance: vec![radius * turn; rows],
            turn: vec![turn; rows],
            bulge: vec![0.0; rows],
            reference,
            runs: std::iter::once(0..rows).collect(),
        };
        let half = path.reckon(0, 11)[10];
        let (x, y) = (radius * (10.0 * turn).sin(), radius * (1.0 - (10.0 * turn).cos()));
        assert!((half.0 - x).hypot(half.1 - y) < 1e-12, "{half:?}");
        assert!(path.error(0, &Added::nothing(rows)).is_some_and(|one| one.position < 1e-12));
    }

    /// A robot that starts to turn while it speeds up, in rows of a tenth of a second, ends where it does in rows of a
    /// thousandth.
    #[test]
    fn a_turn_that_is_not_even_over_a_row_bulges() {
        let smooth = |t: f64| (1.0 - (2.0 * t).cos()) / 2.0;
        let fine = 1e-4;
        let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
        let (mut distance, mut turn) = (vec![0.0], vec![0.0]);
        for row in 0..30 {
            let (mut driven, mut turned) = (0.0, 0.0);
            for step in 0..1000 {
                let t = f64::from(row) * 0.1 + (f64::from(step) + 0.5) * fine;
                let (way, by) = (smooth(t) * fine, 1.5 * smooth(t - 0.7) * fine);
                x += way * (heading + by / 2.0).cos();
                y += way * (heading + by / 2.0).sin();
                heading += by;
                (driven, turned) = (driven + way, turned + by);
            }
            distance.push(driven);
            turn.push(turned);
        }
        let rows = distance.len();
        let path = |bulge: Vec<f64>| {
            let reference = [0.0; 3].map(|start| vec![start; rows]);
            let runs = std::iter::once(0..rows).collect();
            let path =
                Path { distance: distance.clone(), turn: turn.clone(), bulge, reference, runs };
            let end = path.reckon(0, rows)[rows - 1];
            (end.0 - x).hypot(end.1 - y)
        };
        let mut bulge = vec![0.0; rows];
        let (faster, sharper) = (slopes(&distance[1..]), slopes(&turn[1..]));
        for row in 1..rows {
            bulge[row] = (turn[row] * faster[row - 1] - distance[row] * sharper[row - 1]) / 12.0;
        }
        let (without, with) = (path(vec![0.0; rows]), path(bulge));
        assert!(without > 1e-4 && with < 0.1 * without, "{without} {with}");
        // What starts between two rows has no slope.
        assert_eq!(slopes(&[0.0, 0.0, 1.0, 1.0]), [0.0; 4]);
    }
}
