//! Laps of a closed path: readings of gyro and odometry at the end of each.
//!
//! Heading, x and y at the end of a lap of a square are three readings of one error. To first order an error that turns the
//! robot by `q` over a lap (spread over the corners, or over the sides) moves its end by `lever * (q * direction, -q)`, with
//! half a side as the lever (Borenstein and Feng's UMBmark, types A and B alike). So all three are readings of `q`, with
//! different noise.

use super::channels::Channels;
use super::gyro::{angle_block, durations, rotation_of, signed};
use super::{Acts, Block, DisplayUnit, Exposure, Known, Problem, wrap};
use crate::dataset::{Dataset, Kind, Role, Unit};
use crate::error::IdentifyError;
use crate::linear::Basis;
use crate::robust;
use crate::significance::surprise_chi2;

/// The default angle of one lap.
const LAP: f64 = std::f64::consts::TAU;

pub(super) fn laps(
    dataset: &Dataset,
    mut channels: Channels,
    known: Known,
) -> Result<Problem, IdentifyError> {
    let direction: Vec<f64> = dataset.required(Role::Direction, "direction")?.si().collect();
    let gyro = dataset.required(Role::GyroAngle, "gyro angle")?;
    let measured = signed(gyro, &direction);
    let headings: Option<Vec<f64>> =
        dataset.column(Role::ReferenceHeading).map(|c| c.si().collect());
    let angle: Vec<f64> = match (dataset.column(Role::ReferenceAngle), &headings) {
        (Some(reference), _) => signed(reference, &direction),
        // Only the heading at the end: the angle turned is the one nearest to the gyro's.
        (None, Some(headings)) => measured
            .iter()
            .zip(headings)
            .map(|(measured, heading)| measured - wrap(measured - heading))
            .collect(),
        (None, None) => direction.iter().map(|direction| LAP * direction).collect(),
    };
    let duration = durations(dataset, &angle);
    // Of the intended lap: the actual angle contains the error of the odometry, which must not be its own cause.
    let meant: Vec<f64> = direction.iter().map(|direction| LAP * direction).collect();
    rotation_of(&mut channels, dataset, &meant, &duration);
    let mut blocks = vec![angle_block(dataset, gyro, &measured, &angle, &duration)];
    let ends = end_errors(dataset);
    let mut closing_lever = known.closing_lever_m;
    if let [Some(heading), Some(x), Some(y)] = &ends {
        let ends = [heading, x, y];
        closing_lever = closing_lever
            .or_else(|| lever(ends.map(|end| &*end.error), &direction, &causes(&channels)));
        if let Some(lever) = closing_lever {
            blocks.push(closing_block(ends, &direction, lever));
        }
    }
    if closing_lever.is_none() {
        for (end, (size, swaps)) in ends.iter().zip([(LAP, false), (1.0, true), (1.0, false)]) {
            if let Some(end) = end {
                blocks.push(end_block(end, &direction, size, swaps));
            }
        }
    }
    Ok(Problem { closing_lever_m: closing_lever, ..Problem::of(Kind::Laps, channels, blocks) })
}

/// Error of the odometry at the end of a lap: reference minus odometry, for one reading.
struct End {
    label: String,
    unit: DisplayUnit,
    error: Vec<f64>,
    raw: Vec<f64>,
}

/// Errors of heading, x and y, as far as both odometry and reference have them.
fn end_errors(dataset: &Dataset) -> [Option<End>; 3] {
    [
        (Role::OdometryHeading, Role::ReferenceHeading, Unit::Degree),
        (Role::OdometryX, Role::ReferenceX, Unit::Metre),
        (Role::OdometryY, Role::ReferenceY, Unit::Metre),
    ]
    .map(|(odometry, reference, unit)| {
        let (odometry, reference) = (dataset.column(odometry)?, dataset.column(reference)?);
        let turns = reference.role == Role::ReferenceHeading;
        let error = odometry.si().zip(reference.si()).map(|(odometry, reference)| {
            if turns { wrap(reference - odometry) } else { reference - odometry }
        });
        Some(End {
            label: odometry.name.clone(),
            unit: unit.into(),
            error: error.collect(),
            raw: odometry.values.clone(),
        })
    })
}

/// Possible causes of lap errors, to find how the ends are related: none, the time, every channel.
fn causes(channels: &Channels) -> Vec<Vec<f64>> {
    let centred = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let mut found = vec![vec![1.0; channels.time.len()], centred(&channels.time)];
    if let Some(temperature) = channels.of(Role::Temperature) {
        found.push(centred(&temperature.values));
    }
    found
}

/// The three readings of a lap's end as readings of one error of the heading.
fn closing_block(ends: [&End; 3], direction: &[f64], lever: f64) -> Block {
    let n = direction.len();
    let mut closing = Closing {
        labels: ends.map(|end| end.label.clone()),
        lever,
        direction: direction.to_vec(),
        component: Vec::new(),
    };
    let (mut rows, mut residual) = (Vec::new(), Vec::new());
    let mut spread = Vec::new();
    let mut noises = Vec::new();
    for (which, end) in ends.iter().enumerate() {
        let mut own = Vec::new();
        for row in (0..n).filter(|&row| end.error[row].is_finite()) {
            closing.component.push(which);
            rows.push(row);
            own.push(end.error[row] / closing.lever_of(rows.len() - 1, row));
        }
        // Between consecutive laps of the same direction, slow errors cancel.
        let steps: Vec<f64> = own
            .windows(3)
            .map(|three| (three[2] - three[0]) * std::f64::consts::FRAC_1_SQRT_2)
            .collect();
        noises.push(robust::spread(&steps).max(f64::MIN_POSITIVE));
        let relative = noises[noises.len() - 1] / noises[0];
        spread.extend(own.iter().map(|_| relative));
        residual.extend(own);
    }
    let degree = Unit::Degree.si();
    let odd = direction.iter().map(|direction| LAP * direction).collect();
    Block {
        raw: residual.iter().map(|value| value / degree).collect(),
        raw_si: degree,
        rows,
        residual,
        spread,
        exposures: vec![
            Exposure::new(Acts::Turn, odd, DisplayUnit::one()),
            Exposure::new(Acts::Curvature, vec![1.0; n], Unit::Degree.into()),
        ],
        closing: Some(closing),
        ..Block::new("closing", Unit::Degree.into())
    }
}

/// One reading by itself, if the ends do not fit a square. A turning error changes sign with the direction, a curvature
/// does not; along the first side it is the reverse (type A and type B errors of UMBmark).
fn end_block(end: &End, direction: &[f64], size: f64, swaps: bool) -> Block {
    let rows: Vec<usize> = (0..end.error.len()).filter(|&row| end.error[row].is_finite()).collect();
    let odd: Vec<f64> = direction.iter().map(|direction| size * direction).collect();
    let even = vec![1.0; end.error.len()];
    let (turn, curvature) = if swaps { (even, odd) } else { (odd, even) };
    let one = if size == 1.0 { end.unit.clone() } else { DisplayUnit::one() };
    Block {
        apart: Some(end.label.clone()),
        residual: rows.iter().map(|&row| end.error[row]).collect(),
        raw: rows.iter().map(|&row| end.raw[row]).collect(),
        raw_si: end.unit.si,
        rows,
        exposures: vec![
            Exposure::new(Acts::Turn, turn, one),
            Exposure::new(Acts::Curvature, curvature, end.unit.clone()),
        ],
        ..Block::new(&end.label, end.unit.clone())
    }
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

/// The lever that fits the errors of heading (rad), x and y (m) at the ends of laps best: half a side. A `direction` of +1 is
/// counter-clockwise, of -1 clockwise. `causes` are possible causes of the errors, one value per lap. `None` if the ends do
/// not fit a square.
fn lever([angle, x, y]: [&[f64]; 3], direction: &[f64], causes: &[Vec<f64>]) -> Option<f64> {
    let mut basis = Basis::default();
    for cause in causes {
        basis.push(cause.clone());
        basis.push(cause.iter().zip(direction).map(|(cause, d)| cause * d).collect());
    }
    let laps = 0..angle.len();
    let along: Vec<f64> = laps.clone().map(|i| (direction[i] * x[i] - y[i]) / 2.0).collect();
    let across: Vec<f64> = laps.map(|i| (direction[i] * x[i] + y[i]) / 2.0).collect();
    let noise = |values: &[f64]| {
        let mut left = values.to_vec();
        basis.project(&mut left);
        robust::spread(&left).max(f64::MIN_POSITIVE)
    };
    let shares = |values: &[f64]| -> Vec<f64> {
        basis.columns().iter().map(|q| crate::linear::dot(q, values)).collect()
    };
    let (position, heading) = (noise(&along), noise(angle));
    let off: f64 = shares(&across).iter().map(|share| (share / noise(&across)).powi(2)).sum();
    if surprise_chi2(off, basis.len() as f64) > NO_SQUARE {
        return None;
    }
    // Total least squares of the two on each other, each in units of its noise.
    let (mut hh, mut pp, mut hp) = (0.0, 0.0, 0.0);
    for (h, p) in shares(angle).iter().zip(shares(&along)) {
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
    use super::lever;

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
        let found = lever([&heading, &x, &y], &d, &ones).unwrap();
        assert!((found - 3.0).abs() < 0.2, "{found}");
        // A path that is not a square.
        assert_eq!(lever([&heading, &x, &heading], &d, &ones), None);
    }

    #[test]
    fn in_noise_alone_a_side_is_assumed() {
        let n = 40;
        let d = direction(n);
        let of = |k: f64| (0..n).map(|i| 0.01 * wave(i, k)).collect::<Vec<f64>>();
        let (heading, x, y) = (of(2.1), of(1.3), of(0.7));
        assert_eq!(lever([&heading, &x, &y], &d, &[vec![1.0; n]]), Some(2.0));
    }
}
