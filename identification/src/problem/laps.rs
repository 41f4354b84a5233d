//! Laps of a closed path: readings of gyro and odometry at the end of each.

use super::channels::Channels;
use super::closing::{self, Closing, Ends};
use super::gyro::{angle_block, durations, rotation_of, signed};
use super::{Acts, Block, DisplayUnit, Exposure, Known, Problem, wrap};
use crate::dataset::{Dataset, Kind, Role, Unit};
use crate::error::IdentifyError;
use crate::robust;

/// The default angle of one lap.
const LAP: f64 = std::f64::consts::TAU;

pub(super) fn laps(
    dataset: &Dataset,
    mut channels: Channels,
    known: Known,
) -> Result<Problem, IdentifyError> {
    let direction: Vec<f64> = dataset
        .column(Role::Direction)
        .ok_or_else(|| IdentifyError::missing("direction"))?
        .si()
        .collect();
    let gyro =
        dataset.column(Role::GyroAngle).ok_or_else(|| IdentifyError::missing("gyro angle"))?;
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
        let found =
            Ends { heading: &heading.error, x: &x.error, y: &y.error, direction: &direction };
        if closing_lever.is_none() {
            closing_lever = closing::lever(&found, &causes(&channels));
        }
        if let Some(lever) = closing_lever {
            blocks.push(closing_block(&ends, &direction, lever));
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
fn closing_block(ends: &[Option<End>; 3], direction: &[f64], lever: f64) -> Block {
    let n = direction.len();
    let mut closing = Closing {
        labels: [0, 1, 2]
            .map(|which| ends[which].as_ref().map_or_else(String::new, |end| end.label.clone())),
        lever,
        direction: direction.to_vec(),
        component: Vec::new(),
    };
    let (mut rows, mut residual) = (Vec::new(), Vec::new());
    let mut spread = Vec::new();
    let mut noises = Vec::new();
    for (which, end) in ends.iter().enumerate() {
        let Some(end) = end else { continue };
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
