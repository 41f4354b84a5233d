//! Any sensor against the quantity it measures.

use super::channels::Channels;
use super::gyro::{GYRO_CONSTANTS, exposures};
use super::rate::slope;
use super::reference::{everywhere, known_around, noise_of};
use super::{Block, DisplayUnit, Problem, wrap};
use crate::corrections::reference_of;
use crate::dataset::{Column, Dataset, Dimension, Role};
use crate::error::IdentifyError;
use crate::robust;
use std::rc::Rc;

pub(super) fn sensor(dataset: &Dataset, channels: Channels) -> Result<Problem, IdentifyError> {
    dataset.required(Role::Measured, "measured")?;
    dataset.required(Role::Reference, "reference")?;
    let measured: Vec<&Column> = dataset.columns_of(Role::Measured).collect();
    let references: Vec<&Column> = dataset.columns_of(Role::Reference).collect();
    let (mut blocks, mut notices, mut first) = (Vec::new(), Vec::new(), None);
    for column in &measured {
        let Some(reference) = reference_of(dataset, column) else {
            notices.push(format!("`{}` has no reference and is left out", column.name));
            continue;
        };
        // What the other axes measure may leak in.
        let mut own = channels.clone();
        for other in references.iter().filter(|other| other.name != reference.name) {
            own.add(&other.name, Role::Reference, other.unit, other.si().collect());
        }
        let block = against(dataset, column, reference, &mut own)?;
        let own = Rc::new(own);
        first.get_or_insert_with(|| Rc::clone(&own));
        blocks.push(Block { own: (measured.len() > 1).then_some(own), ..block });
    }
    let channels = first.ok_or_else(|| IdentifyError::missing("reference"))?;
    Ok(Problem { notices, ..Problem::of(dataset.kind, Rc::unwrap_or_clone(channels), blocks) })
}

/// One of its axes, with what is measured as the rotation of `channels`.
fn against(
    dataset: &Dataset,
    measured: &Column,
    reference: &Column,
    channels: &mut Channels,
) -> Result<Block, IdentifyError> {
    if measured.unit.dimension() != reference.unit.dimension() {
        return Err(IdentifyError(format!(
            "`{}` is in {} and its reference `{}` in {}: expected the same quantity",
            measured.name, measured.unit, reference.name, reference.unit
        )));
    }
    let turns = reference.unit.dimension() == Dimension::Angle;
    let values: Vec<f64> = measured.si().collect();
    let mut truth: Vec<f64> = reference.si().collect();
    if turns {
        // Consecutive runs without a break are one motion: a jump between them would look like a late one.
        channels.unwrap_angle(&mut truth);
    }
    channels.rotation = everywhere(channels, &truth, &values);
    channels.rotation_name.clone_from(&reference.name);
    channels.rotation_unit = reference.unit;
    let error = |row: usize| {
        let error = values[row] - truth[row];
        if turns { wrap(error) } else { error }
    };
    let (inner, known) = (inner(channels), known_around(dataset, reference, channels));
    let counts = |row: &usize| inner[*row] && known[*row] && error(*row).is_finite();
    let rows: Vec<usize> = (0..values.len()).filter(counts).collect();
    if rows.len() < 8 {
        return Err(IdentifyError::missing("reference in enough rows"));
    }
    channels.rotation_noise = noise_of(dataset, reference, channels, &truth, &values);
    let (low, high) = robust::ends(channels.rotation.iter().copied());
    let moves = high - low > 0.0;
    if moves && !turns {
        let of = |all: &[f64]| rows.iter().map(|&row| all[row]).collect::<Vec<f64>>();
        channels.gain = slope(&of(&values), &of(&truth));
    }
    let unit = unit_of(measured);
    let scale = moves.then(|| channels.rotation.clone());
    Ok(Block {
        exposures: exposures((vec![1.0; values.len()], unit.clone()), scale),
        // An angle that keeps turning has no error that grows with it.
        constants: GYRO_CONSTANTS[..if moves && !turns { 2 } else { 1 }].to_vec(),
        ..Block::of_readings(measured, rows, error, unit)
    })
}

/// Unit of errors, which are differences.
fn unit_of(measured: &Column) -> DisplayUnit {
    DisplayUnit::new(measured.unit.difference_text(), measured.unit.si())
}

/// Rows at either end of a stretch without information on delays: the truth before it was not recorded.
const ENDS: usize = 4;
/// Minimum length of a stretch that can spare those rows.
const SPARES_FROM: usize = 50;

/// Rows with known surroundings.
fn inner(channels: &Channels) -> Vec<bool> {
    let mut inner = vec![true; channels.time.len()];
    for range in channels.segments.iter().filter(|range| range.len() >= SPARES_FROM) {
        inner[range.start..range.start + ENDS].fill(false);
        inner[range.end - ENDS..range.end].fill(false);
    }
    inner
}
