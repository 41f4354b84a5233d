//! A driven path cut into legs between references: what the reference says of each, and what the wheels say.

use crate::dataset::{Dataset, Role};
use crate::linear::dot;
use crate::problem::{self, Channels, TRACK, motion, wrap};
use crate::signal::{interpolate, running_total};
use std::ops::Range;

/// Fewer legs tell nothing for certain.
pub(super) const LEGS_MIN: usize = 24;

/// Poses that are known as a whole.
pub(crate) struct Poses {
    /// Time of each row, s.
    pub time: Vec<f64>,
    /// Rows of each run.
    pub runs: Vec<Range<usize>>,
    x: Vec<f64>,
    y: Vec<f64>,
    heading: Vec<f64>,
    /// Rows of each run with a whole pose.
    known: Vec<Vec<usize>>,
}

/// How poses are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// Times the heading that is stated.
    pub heading: f64,
    /// Whether x is y.
    pub is_exchanged: bool,
    /// Times the positions, then.
    pub x: f64,
    pub y: f64,
}

impl Default for Frame {
    fn default() -> Self {
        Self { heading: 1.0, is_exchanged: false, x: 1.0, y: 1.0 }
    }
}

/// Motion between two references, as they say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leg {
    pub run: usize,
    /// Row of the reference at its start and its end.
    pub rows: (usize, usize),
    /// Turn, rad.
    pub turned: f64,
    /// Distance ahead, m.
    pub along: f64,
    /// Distance to the left, m.
    pub aside: f64,
}

impl Poses {
    /// The poses of `dataset`; `None` without them.
    pub fn new(dataset: &Dataset) -> Option<Self> {
        use crate::dataset::Role;
        let column = |role| dataset.column(role).map(|column| column.si().collect::<Vec<f64>>());
        let (x, y) = (column(Role::ReferenceX)?, column(Role::ReferenceY)?);
        let heading = column(Role::ReferenceHeading)?;
        let time = column(Role::Time)?;
        let runs: Vec<Range<usize>> = problem::runs(&dataset.run_of_row).collect();
        let whole =
            |row: &usize| x[*row].is_finite() && y[*row].is_finite() && heading[*row].is_finite();
        let known = runs.iter().map(|rows| rows.clone().filter(whole).collect()).collect();
        Some(Self { time, runs, x, y, heading, known })
    }

    /// About `count` legs.
    pub fn legs(&self, count: usize) -> Vec<Leg> {
        self.legs_in(count, &Frame::default())
    }

    /// About `count` legs of the poses as `frame` reads them.
    pub fn legs_in(&self, count: usize, frame: &Frame) -> Vec<Leg> {
        let steps: usize = self.known.iter().map(|known| known.len().saturating_sub(1)).sum();
        let size = (steps / count).max(1);
        let mut legs = Vec::new();
        for (run, known) in self.known.iter().enumerate() {
            let mut from = 0;
            while from + 1 < known.len() {
                let to = (from + size).min(known.len() - 1);
                legs.push(self.leg(run, &known[from..=to], frame));
                from = to;
            }
        }
        legs
    }

    fn leg(&self, run: usize, rows: &[usize], frame: &Frame) -> Leg {
        let mut leg =
            Leg { run, rows: (rows[0], rows[rows.len() - 1]), turned: 0.0, along: 0.0, aside: 0.0 };
        for pair in rows.windows(2) {
            let heading = |row: usize| frame.heading * self.heading[row];
            let turned = wrap(heading(pair[1]) - heading(pair[0]));
            let middle = heading(pair[0]) + turned / 2.0;
            let (dx, dy) = (self.x[pair[1]] - self.x[pair[0]], self.y[pair[1]] - self.y[pair[0]]);
            let (dx, dy) = if frame.is_exchanged { (dy, dx) } else { (dx, dy) };
            let (dx, dy) = (frame.x * dx, frame.y * dy);
            // Between poses that lie far apart the robot drives an arc, and not its chord.
            let half = turned / 2.0;
            let arc = if half.abs() > 1e-6 { half / half.sin() } else { 1.0 };
            leg.turned += turned;
            leg.along += arc * (dx * middle.cos() + dy * middle.sin());
            leg.aside += arc * (dy * middle.cos() - dx * middle.sin());
        }
        leg
    }

    /// Sums over each leg of `per_row`, what each row adds, where the legs come `late` by that much, s.
    pub fn sums(&self, legs: &[Leg], per_row: &[f64], late: f64) -> Vec<f64> {
        let total = running_total(per_row);
        let at = |run: usize, row: usize| {
            if late == 0.0 {
                return total[row];
            }
            let rows = self.runs[run].clone();
            interpolate(&self.time[rows.clone()], &total[rows], self.time[row] - late)
        };
        legs.iter().map(|leg| at(leg.run, leg.rows.1) - at(leg.run, leg.rows.0)).collect()
    }
}

/// Share of the squares of `seen` that the best multiple of `said` within `range` leaves.
pub(crate) fn leaves(said: &[f64], seen: &[f64], range: [f64; 2]) -> f64 {
    let (square, total) = (dot(said, said), dot(seen, seen));
    if !(square > 0.0 && total > 0.0) {
        return 1.0;
    }
    let slope = (dot(said, seen) / square).clamp(range[0], range[1]);
    let left: f64 = said.iter().zip(seen).map(|(said, seen)| (seen - slope * said).powi(2)).sum();
    left / total
}

/// Cluster of each leg.
pub(super) fn clusters(legs: &[Leg]) -> Vec<usize> {
    problem::clusters(&legs.iter().map(|leg| leg.run).collect::<Vec<usize>>())
}

/// Motion of each row by the wheels, if a metre counts as half a radian of both: the distance, and half the difference.
pub(super) struct Wheels {
    pub distance: Vec<f64>,
    pub side: Vec<f64>,
    /// Metres of `side` for a turn of one radian, as the package says.
    pub metres_per_radian: f64,
}

impl Wheels {
    pub fn new(dataset: &Dataset) -> Option<Self> {
        let channels = Channels::new(dataset);
        let found = motion(dataset, &channels).ok()?;
        let track = TRACK.iter().find_map(|name| dataset.constants.get(*name));
        let is_pair = dataset.column(Role::WheelLeft).is_some();
        let metres_per_radian = match track {
            Some(track) if is_pair => track.si() / 2.0,
            _ => 1.0,
        };
        let side = found.turn.iter().map(|turn| turn * metres_per_radian).collect();
        Some(Self { distance: found.distance, side, metres_per_radian })
    }
}

#[cfg(test)]
mod tests {
    use super::Poses;

    /// The chord of a radian is 4 % shorter: a tricycle that was seen seldom had a false scale of its steering.
    #[test]
    fn between_poses_that_lie_far_apart_lies_an_arc() {
        let angles: Vec<f64> = (0..9).map(f64::from).collect();
        let poses = Poses {
            time: angles.clone(),
            runs: std::iter::once(0..9).collect(),
            x: angles.iter().map(|angle| 3.0 * angle.sin()).collect(),
            y: angles.iter().map(|angle| -3.0 * angle.cos()).collect(),
            heading: angles,
            known: vec![(0..9).collect()],
        };
        for leg in poses.legs(4) {
            assert!((leg.along - 3.0 * leg.turned).abs() < 1e-9, "{leg:?}");
            assert!(leg.aside.abs() < 1e-9, "{leg:?}");
        }
    }
}
