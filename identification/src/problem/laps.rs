//! Laps of a closed path: what the gyro and the odometry say at the end of each.

use super::channels::Channels;
use super::gyro::{angle_block, durations, missing, rotation_of, signed};
use super::{Aggregate, Block, DisplayUnit, Exposure, Problem, wrap};
use crate::dataset::{Dataset, Kind, Role};
use crate::identify::IdentifyError;
use crate::model::Acts;

/// The angle of one lap, where nothing says otherwise.
const LAP: f64 = std::f64::consts::TAU;

pub(super) fn laps(dataset: &Dataset, mut channels: Channels) -> Result<Problem, IdentifyError> {
    let direction: Vec<f64> =
        dataset.column(Role::Direction).ok_or_else(|| missing("direction"))?.si().collect();
    let gyro = dataset.column(Role::GyroAngle).ok_or_else(|| missing("gyro angle"))?;
    let measured = signed(gyro, &direction);
    let headings: Option<Vec<f64>> =
        dataset.column(Role::ReferenceHeading).map(|c| c.si().collect());
    let angle: Vec<f64> = match (dataset.column(Role::ReferenceAngle), &headings) {
        (Some(reference), _) => signed(reference, &direction),
        // Only the heading at the end: the turned angle is the one nearest to the gyro's.
        (None, Some(headings)) => measured
            .iter()
            .zip(headings)
            .map(|(measured, heading)| measured - wrap(measured - heading))
            .collect(),
        (None, None) => direction.iter().map(|direction| LAP * direction).collect(),
    };
    let duration = durations(dataset, &channels, &angle);
    rotation_of(&mut channels, dataset, &angle, &duration);
    let mut blocks = vec![angle_block(dataset, gyro, &measured, &angle, &duration)];
    let pair = |odometry, reference| Some((dataset.column(odometry)?, dataset.column(reference)?));
    if let Some((odometry, reference)) = pair(Role::OdometryHeading, Role::ReferenceHeading) {
        let error: Vec<f64> = odometry.si().zip(reference.si()).map(|(o, r)| wrap(r - o)).collect();
        let unit = DisplayUnit::new("deg", crate::dataset::Unit::Degree.si());
        blocks.push(end_block(
            &odometry.name,
            &error,
            &odometry.values,
            unit,
            &direction,
            LAP,
            false,
        ));
    }
    for (odometry, reference, swaps) in
        [(Role::OdometryX, Role::ReferenceX, true), (Role::OdometryY, Role::ReferenceY, false)]
    {
        if let Some((odometry, reference)) = pair(odometry, reference) {
            let error: Vec<f64> = odometry.si().zip(reference.si()).map(|(o, r)| r - o).collect();
            let unit = DisplayUnit::new("m", 1.0);
            blocks.push(end_block(
                &odometry.name,
                &error,
                &odometry.values,
                unit,
                &direction,
                1.0,
                swaps,
            ));
        }
    }
    Ok(Problem {
        kind: Kind::Laps,
        channels,
        blocks,
        path: None,
        counts_per_unit: None,
        notices: Vec::new(),
    })
}

/// What the odometry lacks at the end of a lap: reference minus odometry. A wrong turn changes sign with the direction, a curvature does not; along the
/// first side it is the other way round (type A and type B errors of UMBmark).
fn end_block(
    label: &str,
    error: &[f64],
    raw: &[f64],
    unit: DisplayUnit,
    direction: &[f64],
    size: f64,
    swaps: bool,
) -> Block {
    let rows: Vec<usize> = (0..error.len()).filter(|&row| error[row].is_finite()).collect();
    let odd: Vec<f64> = direction.iter().map(|direction| size * direction).collect();
    let even = vec![1.0; error.len()];
    let (turn, curvature) = if swaps { (even, odd) } else { (odd, even) };
    let one = if size == 1.0 { unit.clone() } else { DisplayUnit::new("1", 1.0) };
    Block {
        label: label.to_owned(),
        axis: None,
        apart: Some(label.to_owned()),
        aggregate: Aggregate::Row,
        residual: rows.iter().map(|&row| error[row]).collect(),
        raw: rows.iter().map(|&row| raw[row]).collect(),
        raw_si: unit.si,
        rows,
        spread: Vec::new(),
        exposures: vec![
            Exposure { acts: Acts::Turn, per_row: turn, unit: one },
            Exposure { acts: Acts::Curvature, per_row: curvature, unit: unit.clone() },
        ],
        constants: Vec::new(),
        unit,
        activity: None,
        pose: None,
    }
}
