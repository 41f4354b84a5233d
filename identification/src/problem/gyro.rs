//! A gyro on a table: whole turns, or samples.

use super::channels::Channels;
use super::{Acts, Block, Constant, DisplayUnit, Exposure, Problem, Turning};
use crate::dataset::{Column, Dataset, Role, Unit};
use crate::error::IdentifyError;

/// Constants that the plain model of a gyro fits: a bias and a scale factor.
pub(super) const GYRO_CONSTANTS: [Constant; 2] = [
    Constant { acts: Acts::Bias, name: "bias" },
    Constant { acts: Acts::Scale, name: "scale_factor" },
];

/// The unit of rate that belongs to a unit of angle, and vice versa.
pub(super) fn rate_unit(unit: Unit) -> DisplayUnit {
    match unit {
        Unit::Degree | Unit::DegreePerSecond => Unit::DegreePerSecond.into(),
        Unit::DegreePerHour => Unit::DegreePerHour.into(),
        _ => Unit::RadianPerSecond.into(),
    }
}

pub(super) fn angle_unit(unit: Unit) -> DisplayUnit {
    match unit {
        Unit::Radian | Unit::RadianPerSecond => Unit::Radian.into(),
        _ => Unit::Degree.into(),
    }
}

/// What a bias of a gyro, and a scale factor where there is one, add to each row.
pub(super) fn exposures(
    (bias, unit): (Vec<f64>, DisplayUnit),
    scale: Option<Vec<f64>>,
) -> Vec<Exposure> {
    let scale = scale.map(|per_row| Exposure::new(Acts::Scale, per_row, DisplayUnit::one()));
    std::iter::once(Exposure::new(Acts::Bias, bias, unit)).chain(scale).collect()
}

/// Duration of each row: stated, or from the rate; 1 if neither is known.
pub(super) fn durations(dataset: &Dataset, angle: &[f64]) -> Vec<f64> {
    if let Some(column) = dataset.column(Role::Duration) {
        return column.si().collect();
    }
    if let Some(column) = dataset.column(Role::TableRate) {
        let from_rate: Vec<f64> =
            angle.iter().zip(column.si()).map(|(angle, rate)| (angle / rate).abs()).collect();
        if from_rate.iter().all(|duration| duration.is_finite() && *duration > 0.0) {
            return from_rate;
        }
    }
    vec![1.0; dataset.rows()]
}

/// Whether the angle is written without its sign.
fn is_unsigned(values: &[f64], direction: &[f64]) -> bool {
    direction.iter().any(|d| *d < 0.0) && values.iter().all(|value| !(*value < 0.0))
}

pub(super) fn signed(column: &Column, direction: &[f64]) -> Vec<f64> {
    let values: Vec<f64> = column.si().collect();
    if is_unsigned(&values, direction) {
        values.iter().zip(direction).map(|(value, direction)| value * direction).collect()
    } else {
        values
    }
}

pub(super) fn rotation_of(
    channels: &mut Channels,
    dataset: &Dataset,
    angle: &[f64],
    duration: &[f64],
) {
    let timed =
        dataset.column(Role::Duration).is_some() || dataset.column(Role::TableRate).is_some();
    if timed {
        channels.rotation = angle.iter().zip(duration).map(|(a, t)| a / t).collect();
        if let Some(column) = dataset.column(Role::TableRate)
            && column.values.iter().all(|value| value.is_finite())
        {
            // The rate of the table itself; ramps lower the mean over a turn.
            channels.rotation = angle
                .iter()
                .zip(column.si())
                .map(|(angle, rate)| angle.signum() * rate.abs())
                .collect();
        }
    } else {
        // Only the direction is known.
        channels.rotation = angle.iter().map(|angle| angle.signum()).collect();
    }
    if let Some(column) = dataset.column(Role::TableRate) {
        channels.rotation_name.clone_from(&column.name);
        channels.rotation_unit = column.unit;
    }
}

pub(super) fn turns(dataset: &Dataset, mut channels: Channels) -> Result<Problem, IdentifyError> {
    let direction: Vec<f64> = dataset.required(Role::Direction, "direction")?.si().collect();
    let reference = dataset.required(Role::ReferenceAngle, "reference angle")?;
    let angle = signed(reference, &direction);
    let duration = durations(dataset, &angle);
    rotation_of(&mut channels, dataset, &angle, &duration);
    let rate: Option<Vec<f64>> = dataset.column(Role::TableRate).map(|rate| rate.si().collect());
    channels.turning = Some(Turning::new(&angle, &duration, rate.as_deref()));
    let blocks: Vec<Block> = dataset
        .columns_of(Role::GyroAngle)
        .map(|gyro| {
            let measured = signed(gyro, &direction);
            angle_block(dataset, gyro, &measured, &angle, &duration)
        })
        .collect();
    if blocks.is_empty() {
        return Err(IdentifyError::missing("gyro angle"));
    }
    Ok(Problem::of(dataset.kind, channels, blocks))
}

/// A block of one angle per row, against the reference angle of that row.
pub(super) fn angle_block(
    dataset: &Dataset,
    gyro: &Column,
    measured: &[f64],
    angle: &[f64],
    duration: &[f64],
) -> Block {
    let difference = |row: usize| measured[row] - angle[row];
    let rows: Vec<usize> = (0..dataset.rows()).filter(|&row| difference(row).is_finite()).collect();
    let bias = (duration.to_vec(), rate_unit(gyro.unit));
    Block {
        exposures: exposures(bias, Some(angle.to_vec())),
        constants: GYRO_CONSTANTS.to_vec(),
        ..Block::of_readings(gyro, rows, difference, angle_unit(gyro.unit))
    }
}
