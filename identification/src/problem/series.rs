//! Samples of a gyro against a rate or a heading.

use super::channels::Channels;
use super::gyro::{GYRO_CONSTANTS, exposures, rate_unit};
use super::heading::{against_heading, shows_turns};
use super::rate::{Rate, rates, slope};
use super::reference::{everywhere, known_around, noise_of};
use super::{Acts, Block, Problem};
use crate::dataset::{Axis, Column, Dataset, Dimension, Kind, Role};
use crate::error::IdentifyError;
use std::cell::OnceCell;
use std::rc::Rc;

pub(super) fn series(
    dataset: &Dataset,
    mut channels: Channels,
    counts: Option<f64>,
) -> Result<Problem, IdentifyError> {
    let rates = rates(dataset, &channels);
    if rates.is_empty() {
        return Err(IdentifyError::missing("gyro"));
    }
    let mut counts = counts;
    let mut notices = Vec::new();
    let mut blocks = Vec::new();
    let mut references: Vec<Option<&Column>> = Vec::new();
    for rate in &rates {
        let mine = |column: &&Column| Axis::agree(column.axis, rate.column.axis);
        let reference_rate = dataset.columns_of(Role::ReferenceRate).find(mine);
        let reference_heading = dataset.columns_of(Role::ReferenceHeading).find(mine);
        let block = match (reference_rate, reference_heading) {
            (Some(reference), _) => {
                against_rate(dataset, rate, reference, &mut channels, &mut counts)
            }
            (None, Some(reference)) if !shows_turns(reference, &channels) => {
                return Err(IdentifyError(format!(
                    "`{}` has one value in each run, which tells no turn: expected two or more, such as one at either \
                     end",
                    reference.name
                )));
            }
            (None, Some(reference)) => against_heading(rate, reference, &mut channels, &mut counts),
            (None, None) => {
                notices.push(format!("`{}` has no reference and is left out", rate.column.name));
                continue;
            }
        };
        blocks.push(block);
        references.push(reference_rate);
    }
    if blocks.is_empty() {
        return Err(IdentifyError::missing("reference"));
    }
    // A rotation about another axis may be the measured one.
    let turns_about: Vec<&Column> =
        dataset.columns_of(Role::ReferenceRate).filter(|column| column.axis.is_some()).collect();
    let mut measured_apart = true;
    for rate in &rates {
        measured_apart &= turns_about.iter().any(|column| column.axis == rate.column.axis);
    }
    for reference in &turns_about {
        if rates.iter().any(|rate| rate.column.axis.is_some() && rate.column.axis != reference.axis)
        {
            let values: Vec<f64> = reference.si().collect();
            channels.add(&reference.name, Role::ReferenceRate, reference.unit, values);
        }
    }
    // Another axis of the gyro, or another gyro, may leak in: each is a channel for the others, unless a reference
    // provides a better record of that axis.
    if rates.len() > 1 && !measured_apart {
        for rate in &rates {
            let name = rate.column.name.clone();
            channels.add(&name, rate.column.role, rate.column.unit, rate.values.clone());
        }
    }
    each_its_own_rotation(&mut blocks, &references, &channels);
    Ok(Problem { counts_per_unit: counts, notices, ..Problem::of(Kind::Series, channels, blocks) })
}

/// With a reference for each axis, effects depend on the rotation about their own axis.
fn each_its_own_rotation(
    blocks: &mut [Block],
    references: &[Option<&Column>],
    channels: &Channels,
) {
    for (block, reference) in blocks.iter_mut().zip(references) {
        let Some(reference) = reference else { continue };
        let several = references.iter().flatten().any(|other| other.name != reference.name);
        if !several {
            continue;
        }
        let mut own = channels.clone();
        own.channels.retain(|channel| channel.name != reference.name);
        own.rotation_name.clone_from(&reference.name);
        own.rotation_unit = reference.unit;
        if let Some(exposure) = block.exposure(Acts::Scale) {
            own.rotation.clone_from(&exposure.per_row);
            own.bends = OnceCell::new();
        }
        block.own = Some(Rc::new(own));
    }
}

fn against_rate(
    dataset: &Dataset,
    rate: &Rate<'_>,
    reference: &Column,
    channels: &mut Channels,
    counts: &mut Option<f64>,
) -> Block {
    let measured_reference: Vec<f64> = reference.si().collect();
    let is_counts = rate.column.unit.dimension() == Dimension::Count;
    let factor = if is_counts {
        *counts.get_or_insert_with(|| slope(&rate.values, &measured_reference))
    } else {
        1.0
    };
    let measured: Vec<f64> = rate.values.iter().map(|value| value / factor).collect();
    let rotation = everywhere(channels, &measured_reference, &measured);
    if channels.rotation.is_empty() {
        channels.rotation.clone_from(&rotation);
        channels.rotation_noise =
            noise_of(dataset, reference, channels, &measured_reference, &measured);
        channels.rotation_name.clone_from(&reference.name);
        channels.rotation_unit = reference.unit;
    }
    let known = known_around(dataset, reference, channels);
    let rows: Vec<usize> = (0..measured.len())
        .filter(|&row| known[row] && (measured[row] - measured_reference[row]).is_finite())
        .collect();
    let unit = if is_counts { rate_unit(reference.unit) } else { rate_unit(rate.column.unit) };
    let at_rest = measured_reference.iter().all(|value| !(value.abs() > 0.0));
    let constants = if at_rest { GYRO_CONSTANTS[..1].to_vec() } else { GYRO_CONSTANTS.to_vec() };
    let scale = (!at_rest).then_some(rotation);
    let error = |row: usize| measured[row] - measured_reference[row];
    Block {
        raw_si: rate.column.unit.si() / factor,
        exposures: exposures((vec![1.0; measured.len()], unit.clone()), scale),
        constants,
        ..Block::of_readings(rate.column, rows, error, unit)
    }
}
