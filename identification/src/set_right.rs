//! What corrections of the data gain: the errors on held-out runs as the package states its fields, and without each
//! correction.

use crate::corrections::{Correction, applied};
use crate::dataset::Dataset;
use crate::done::Done;
use crate::error::IdentifyError;
use crate::finding::Effect;
use crate::fit::Data;
use crate::judge::{Holding, Judge, Metric};
use crate::model::{Acts, Shape};
use crate::noise::{Layout, NoiseModel};
use crate::problem::{Known, Problem};
use crate::select::fall;

/// The corrections as effects. The path of each block that they concern begins with what the
/// package states.
///
/// # Errors
///
/// When the data lack something as stated.
pub(crate) fn set_right(
    stated: &Dataset,
    corrections: &[Correction],
    done: &mut [Done<'_>],
) -> Result<Vec<Effect>, IdentifyError> {
    if corrections.is_empty() {
        return Ok(Vec::new());
    }
    let right = applied(stated, corrections);
    let mut found = Vec::new();
    for (index, correction) in corrections.iter().enumerate() {
        // A reference is mounted once, at whatever times its angle was told.
        let is_same = |other: &Correction| correction.is_part_of(other);
        if !correction.is_effect() || corrections[..index].iter().any(is_same) {
            continue;
        }
        let parts = corrections[index + 1..].iter().filter(|other| is_same(other));
        let effect = parts.fold(correction.clone(), Correction::joined).effect(&right);
        let concerns =
            |one: &&Done<'_>| effect.axis.is_none() || one.data.block.axis == effect.axis;
        let Some(one) = done.iter().find(concerns) else { continue };
        let others: Vec<Correction> = corrections
            .iter()
            .enumerate()
            .filter(|(at, other)| *at != index && !is_same(other))
            .map(|(_, other)| other.clone())
            .collect();
        let without = errors(&applied(stated, &others), one, &one.fit.shapes())?;
        let with = &one.fit.path[one.fit.chosen].metrics;
        let (held_out_before, held_out_after) = (without[0].value(), with[0].value());
        let effect = Effect { held_out_before, held_out_after, ..effect };
        found.push(effect);
    }
    let found = of_the_sensor(found, done.len());
    // What evening out a noisy reference gains is no gain of an effect.
    let others = corrections.iter().filter(|one| !one.is_effect()).cloned();
    let stated = &applied(stated, &others.collect::<Vec<Correction>>());
    for one in done.iter_mut() {
        let axis = one.data.block.axis;
        let concerns = |effect: &&Effect| effect.axis.is_none() || effect.axis == axis;
        let names: Vec<String> =
            found.iter().filter(concerns).map(|effect| effect.name.clone()).collect();
        if !names.is_empty() {
            let base: Vec<Shape> = one.fit.base.iter().map(|found| found.shape.clone()).collect();
            let metrics = errors(stated, one, &base)?;
            one.put_first(metrics, &names);
        }
    }
    Ok(found)
}

/// Puts what is wrong with each of several axes alike into one effect of the sensor.
fn of_the_sensor(effects: Vec<Effect>, axes: usize) -> Vec<Effect> {
    let alike = |one: &Effect| -> usize {
        let same = |other: &&Effect| {
            other.axis.is_some() && other.name == one.name && other.drivers.is_empty()
        };
        effects.iter().filter(same).count()
    };
    let mut found: Vec<Effect> = Vec::new();
    for effect in &effects {
        let is_shared = axes > 1 && effect.axis.is_some() && alike(effect) == axes;
        if !is_shared {
            found.push(effect.clone());
        } else if !found.iter().any(|one| one.name == effect.name && one.axis.is_none()) {
            found.push(Effect { axis: None, ..effect.clone() });
        }
    }
    found
}

/// Those of `corrections` of a drive that lower an error on held-out runs, beside the constants of the drive. A correction
/// that can only be what it is needs no such proof.
pub(crate) fn worthwhile(stated: &Dataset, corrections: Vec<Correction>) -> Vec<Correction> {
    let mut kept = corrections;
    loop {
        let Some(with) = with_constants(&applied(stated, &kept)) else { return kept };
        let mut least: Option<(f64, usize)> = None;
        for index in (0..kept.len()).filter(|&index| kept[index].standard_error.is_some()) {
            let mut others = kept.clone();
            others.remove(index);
            let Some(without) = with_constants(&applied(stated, &others)) else { continue };
            let gain = fall(&without, &with);
            if !pays(&without, &with) && least.is_none_or(|(least, _)| gain < least) {
                least = Some((gain, index));
            }
        }
        let Some((_, index)) = least else { return kept };
        kept.remove(index);
    }
}

/// Whether some error falls by more than the standard error of the difference, and none rises by more.
fn pays(without: &[Metric], with: &[Metric]) -> bool {
    let exceeds = |more: &Metric, less: &Metric| {
        let (difference, error) = more.errors.beyond(&less.errors);
        difference > error
    };
    let pairs = || without.iter().zip(with);
    pairs().any(|(without, with)| exceeds(without, with))
        && !pairs().any(|(without, with)| exceeds(with, without))
}

/// Held-out errors of a drive as `dataset` has it, with the constants that the plain model lacks.
fn with_constants(dataset: &Dataset) -> Option<Vec<Metric>> {
    let problem = Problem::new(dataset, Known::default()).ok()?;
    let block = problem.blocks.first().filter(|block| block.pose.is_some())?;
    let channels = problem.channels_of(block);
    let layout = Layout::new(block, channels);
    let data = Data::new(block, channels, &layout);
    let judge = Judge { data, path: problem.path.as_ref(), holding: Holding::Spread };
    let acts = [Acts::Turn, Acts::Curvature, Acts::Drive, Acts::Reference];
    let shapes = acts.map(|acts| Shape::constant("constant", acts));
    Some(judge.judge(&shapes, &NoiseModel::walking(&layout)))
}

/// Held-out errors of `shapes` on the quantity of `one` as `dataset` has it.
fn errors(
    dataset: &Dataset,
    one: &Done<'_>,
    shapes: &[Shape],
) -> Result<Vec<Metric>, IdentifyError> {
    let problem = Problem::new(dataset, Known::default())?;
    let same = problem.blocks.iter().find(|block| block.label == one.data.block.label);
    let Some(block) = same else { return Ok(one.fit.path[0].metrics.clone()) };
    let channels = problem.channels_of(block);
    let layout = Layout::new(block, channels);
    let data = Data::new(block, channels, &layout);
    let judge = Judge { data, path: problem.path.as_ref(), holding: one.judge.holding };
    let seen: Vec<Shape> =
        shapes.iter().filter(|shape| shape.observed(block, channels).is_some()).cloned().collect();
    Ok(judge.judge(&seen, &NoiseModel::white(layout.runs())))
}
