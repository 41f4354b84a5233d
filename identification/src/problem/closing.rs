//! Closing error of a square path: heading, x and y at the end of a lap are three readings of one error.
//!
//! To first order an error that turns the robot by `q` over a lap (spread over the corners, or over the sides) moves
//! its end by `lever * (q * direction, -q)`, with half a side as the lever (Borenstein and Feng's UMBmark, types A and
//! B alike). So all three are readings of `q`, with different noise.

use crate::linear::Basis;
use crate::robust;
use crate::significance::surprise_chi2;

/// The errors of laps: reference minus odometry.
#[derive(Debug, Clone)]
pub(super) struct Ends<'a> {
    /// Heading, rad.
    pub heading: &'a [f64],
    /// x, m.
    pub x: &'a [f64],
    /// y, m.
    pub y: &'a [f64],
    /// +1 counter-clockwise, -1 clockwise.
    pub direction: &'a [f64],
}

/// Relation of the three readings of a lap.
#[derive(Debug, Clone, PartialEq)]
pub struct Closing {
    /// Names of the fields: heading, x, y.
    pub labels: [String; 3],
    /// Half a side, m.
    pub lever: f64,
    /// Direction of each row.
    pub direction: Vec<f64>,
    /// Which reading each observation is: 0 heading, 1 x, 2 y.
    pub component: Vec<usize>,
}

impl Closing {
    /// Displacement of an observation per unit of `q`, in its own unit (rad or m).
    pub fn lever_of(&self, observation: usize, row: usize) -> f64 {
        match self.component[observation] {
            0 => 1.0,
            1 => self.lever * self.direction[row],
            _ => -self.lever,
        }
    }
}

/// Range of the side length in the search, m.
const SIDES_M: (f64, f64) = (0.2, 200.0);
/// Side length if the data do not determine it, m: the paper's.
const SIDE_ASSUMED_M: f64 = 4.0;
/// Surprise of the errors across the square's pattern from which the path is not a square, in nats.
const NO_SQUARE: f64 = 9.2;

/// The lever that fits the ends of laps best: half a side. `causes` are possible causes of the errors, one value per
/// lap. `None` if the ends do not fit a square.
pub(super) fn lever(ends: &Ends<'_>, causes: &[Vec<f64>]) -> Option<f64> {
    let n = ends.heading.len();
    let mut basis = Basis::default();
    for cause in causes {
        basis.push(cause.clone());
        basis.push(cause.iter().zip(ends.direction).map(|(cause, d)| cause * d).collect());
    }
    let along: Vec<f64> =
        (0..n).map(|i| (ends.direction[i] * ends.x[i] - ends.y[i]) / 2.0).collect();
    let across: Vec<f64> =
        (0..n).map(|i| (ends.direction[i] * ends.x[i] + ends.y[i]) / 2.0).collect();
    let noise = |values: &[f64]| {
        let mut left = values.to_vec();
        basis.project(&mut left);
        robust::spread(&left).max(f64::MIN_POSITIVE)
    };
    let shares = |values: &[f64]| -> Vec<f64> {
        basis.columns().iter().map(|q| crate::linear::dot(q, values)).collect()
    };
    let (position, heading) = (noise(&along), noise(ends.heading));
    let off: f64 = shares(&across).iter().map(|share| (share / noise(&across)).powi(2)).sum();
    if surprise_chi2(off, basis.len() as f64) > NO_SQUARE {
        return None;
    }
    // Total least squares of the two on each other, each in units of its noise.
    let (mut hh, mut pp, mut hp) = (0.0, 0.0, 0.0);
    for (h, p) in shares(ends.heading).iter().zip(shares(&along)) {
        let (h, p) = (h / heading, p / position);
        hh += h * h;
        pp += p * p;
        hp += h * p;
    }
    let slope = (pp - hh + ((pp - hh).powi(2) + 4.0 * hp * hp).sqrt()) / (2.0 * hp);
    let found = slope * position / heading;
    let fits = found.is_finite() && (SIDES_M.0..SIDES_M.1).contains(&(2.0 * found));
    // In pure noise any lever fits.
    let says = surprise_chi2(hh + pp, 2.0 * basis.len() as f64) > NO_SQUARE;
    match (fits, says) {
        (true, true) => Some(found),
        (false, true) => None,
        _ => Some(SIDE_ASSUMED_M / 2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::{Ends, lever};

    fn wave(i: usize, k: f64) -> f64 {
        (i as f64 * k).sin()
    }

    fn direction(n: usize) -> Vec<f64> {
        (0..n).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect()
    }

    #[test]
    fn half_the_side_is_found_from_where_laps_end() {
        let n = 40;
        let d = direction(n);
        let q: Vec<f64> = d.iter().map(|d| 0.02 * d + 0.01).collect();
        let noise = |k: f64, size: f64| (0..n).map(|i| size * wave(i, k)).collect::<Vec<f64>>();
        let add = |a: Vec<f64>, b: Vec<f64>| -> Vec<f64> {
            a.iter().zip(&b).map(|(a, b)| a + b).collect()
        };
        let heading = add(q.clone(), noise(2.1, 0.003));
        let x = add(q.iter().zip(&d).map(|(q, d)| 3.0 * q * d).collect(), noise(1.3, 0.005));
        let y = add(q.iter().map(|q| -3.0 * q).collect(), noise(0.7, 0.005));
        let ones = vec![vec![1.0; n]];
        let ends = Ends { heading: &heading, x: &x, y: &y, direction: &d };
        let found = lever(&ends, &ones).unwrap();
        assert!((found - 3.0).abs() < 0.2, "{found}");
        // A path that is not a square.
        let ends = Ends { heading: &heading, x: &x, y: &heading, direction: &d };
        assert_eq!(lever(&ends, &ones), None);
    }

    #[test]
    fn in_noise_alone_a_side_is_assumed() {
        let n = 40;
        let d = direction(n);
        let of = |k: f64| (0..n).map(|i| 0.01 * wave(i, k)).collect::<Vec<f64>>();
        let (heading, x, y) = (of(2.1), of(1.3), of(0.7));
        let ends = Ends { heading: &heading, x: &x, y: &y, direction: &d };
        assert_eq!(lever(&ends, &[vec![1.0; n]]), Some(2.0));
    }
}
