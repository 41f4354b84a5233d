//! Builds the finding and the model from the fits of all blocks.

use crate::dataset::{Dataset, Drive};
use crate::done::Done;
use crate::experiment::{self, Doubt, Experiment};
use crate::finding::{Effect, Figure, Finding, HeldOut, Left, SCHEMA, Verdict};
use crate::fit::{Found, residual};
use crate::judge::{Metric, Whiteness, of_innovations, stretches};
use crate::model::{Acts, Model, Term, is_frame};
use crate::noise::Whitener;
use crate::options::Options;
use crate::outcome::{self, Diagnostics, OffsetOfRuns};
use crate::problem::{Aggregate, Problem};

/// Result of an identification.
#[derive(Debug, Clone)]
pub struct Identified {
    /// For `finding.json`.
    pub finding: Finding,
    /// For `model.toml`: the given model plus what was found.
    pub model: Model,
    /// For a report.
    pub diagnostics: Diagnostics,
    /// The plan that would decide between an effect and its rivals, if there are any.
    pub experiment: Option<Experiment>,
}

/// Builds the finding, the model and the report data from all blocks.
pub(crate) fn assemble(
    dataset: &Dataset,
    problem: &Problem,
    done: &[Done<'_>],
    set_right: Vec<(f64, Effect)>,
    options: &Options,
) -> Identified {
    let (seed, noise_is_known) = (options.seed, options.noise_from.is_some());
    let mut effects = set_right;
    let mut terms: Vec<Term> = Vec::new();
    let mut plain = Vec::new();
    let mut base = Vec::new();
    let mut left = Vec::new();
    let mut notices: Vec<String> =
        dataset.notices.iter().chain(&problem.notices).cloned().collect();
    let mut diagnostics =
        Diagnostics { blocks: Vec::new(), run_labels: dataset.run_labels.clone() };
    let offsets: Vec<Option<OffsetOfRuns>> =
        done.iter().map(|one| outcome::offset_of_runs(one.data, &one.fit)).collect();
    for (one, offset) in done.iter().zip(&offsets) {
        if let Some((found, effect)) = one.clipping() {
            terms.push(outcome::term(one.data, &found));
            effects.push((found.strength, effect));
        }
        for found in &one.plain {
            plain.push(outcome::term(one.data, found));
        }
        for found in &one.fit.base {
            let term = outcome::term(one.data, found);
            let numbers = term.parameters.iter().filter(|one| !is_frame(&one.name));
            base.extend(numbers.cloned().map(|mut parameter| {
                parameter.name.clone_from(&term.name);
                parameter
            }));
        }
        terms.extend(one.fit.applied.iter().map(|found| outcome::term(one.data, found)));
        for (index, found) in one.fit.effects.iter().enumerate() {
            let after = &one.fit.path[one.fit.chosen].metrics;
            let without = one.without(index);
            let of = |metrics: &[Metric]| metrics[0].errors.rmse() / metrics[0].unit.si;
            let mut effect = outcome::effect(one.data, found, of(&without), of(after));
            if found.shape.acts == Acts::Axis && sees_little(&one.fit.base) {
                effect.name = "wrong_axis".to_owned();
            }
            effects.push((found.strength, effect));
        }
        for contender in &one.fit.left {
            left.push(Left {
                drivers: contender
                    .candidate
                    .shape
                    .drivers
                    .iter()
                    .map(ToString::to_string)
                    .collect(),
                shape: contender.candidate.shape.name.clone(),
                share_of_residual_variance: (contender.score.statistic
                    / one.data.block.rows.len().max(1) as f64)
                    .min(1.0),
            });
        }
        if let Some(slow) = above_floor(one, offset.as_ref(), noise_is_known) {
            left.push(slow);
        }
        if let Some(goes) = &one.fit.goes {
            left.push(goes.left(&one.data.block.label));
        }
        if let Some(ratio) = one.error_over_floor() {
            notices.push(format!(
                "the held-out error of `{}` is {ratio:.1} times the noise that is new in a reading",
                one.data.block.label
            ));
        }
        match whiteness(one) {
            Some(found) => {
                notices.push(found.notice(one.data, done.len()));
                if !found.is_white(done.len()) {
                    left.push(found.left(one.data, done.len()));
                }
            }
            None => notices.push(format!(
                "`{}` has too few observations to judge whether what is left is white",
                one.data.block.label
            )),
        }
        diagnostics.blocks.push(outcome::diagnose(
            one.data,
            &one.plain,
            &one.fit,
            (&one.errors().0[0].errors, &one.errors().1[0].errors),
        ));
    }
    if done.iter().any(|one| one.data.block.pose.is_some()) {
        // Beside a driven path everything is certain; what matters more goes first.
        for (strength, effect) in &mut effects {
            *strength = effect.held_out_before / effect.held_out_after;
        }
    }
    effects.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut effects: Vec<_> = effects.into_iter().map(|(_, effect)| effect).collect();
    outcome::lines_before_their_zero(&mut effects);
    let (held_out, held_out_also) = errors(done, seed);
    let both = || std::iter::once(&held_out).chain(&held_out_also);
    let verdict = if !left.is_empty() {
        Verdict::StructureLeft
    } else if effects.is_empty() {
        Verdict::NothingMissing
    } else if both().any(|one| one.after < one.before * (1.0 - ALIKE)) {
        Verdict::Explained
    } else if both().all(|one| one.after <= one.before + (one.ci95[1] - one.ci95[0]) / 4.0) {
        // Within a standard error: a unit or a sign that is stated wrongly is no more than a scale.
        Verdict::NothingMissing
    } else {
        Verdict::StructureLeft
    };
    for (one, offset) in done.iter().zip(offsets) {
        effects.extend(one.rounding());
        // Each quantity has its share of the risk of a false alarm.
        let share = 1.0 / done.len() as f64;
        if let Some(offset) = offset.filter(|offset| offset.is_certain(share)) {
            effects.push(offset.effect);
        } else if let Some(slow) = outcome::slow_noise(one.data, &one.fit, share) {
            effects.push(slow.effect);
            notices.extend(slow.notice);
        }
    }
    let main = main_block(done);
    let runs = dataset.run_labels.len();
    let mut fields = std::collections::BTreeMap::new();
    for term in &terms {
        for driver in &term.drivers {
            if let Some(column) = dataset.named(&driver.field) {
                fields.insert(driver.field.clone(), column.role);
            }
        }
    }
    let doubts: Vec<Doubt<'_>> =
        done.iter().map(|one| Doubt { data: one.data, fit: &one.fit }).collect();
    let mut cases = experiment::cases(&doubts);
    experiment::refuse(&mut cases, &mut effects);
    let experiment = experiment::next(dataset, problem, &doubts, &cases);
    let compensation = done.first().and_then(|one| one.compensation(dataset, seed));
    let mut identified = Identified {
        finding: Finding {
            schema: SCHEMA,
            dataset: dataset.name.clone(),
            kind: dataset.kind,
            drive: dataset.drive.filter(|drive| *drive != Drive::Differential),
            rows: dataset.rows(),
            runs,
            seed,
            verdict,
            noise_floor: Figure {
                value: done[main].fit.floor / done[main].data.block.unit.si,
                unit: done[main].data.block.unit.text.clone(),
            },
            held_out,
            held_out_also,
            base,
            effects,
            path: outcome::path(&done.iter().map(|one| &one.fit).collect::<Vec<_>>()),
            left,
            compensation: compensation.clone(),
            next_experiment: None,
            set_aside: Vec::new(),
            notices,
        },
        model: Model {
            schema: SCHEMA,
            kind: dataset.kind,
            dataset: Some(dataset.name.clone()),
            fields,
            counts_per_rad_per_s: problem.counts_per_unit,
            closing_lever_m: problem.closing_lever_m,
            corrections: Vec::new(),
            compensation,
            terms,
            plain,
        },
        diagnostics,
        experiment,
    };
    if let Some(experiment) = &identified.experiment {
        experiment.note(&mut identified.finding);
    }
    outcome::join_powers(&mut identified.finding.effects);
    identified
}

/// Largest ratio of error to innovation noise that still counts as noise.
const ABOVE_FLOOR_MAX: f64 = 5.0;

/// Errors within this share are one and the same.
const ALIKE: f64 = 1e-9;

/// A residual far above the innovation noise: it holds something slow that no cause explains.
fn above_floor(
    one: &Done<'_>,
    offset: Option<&OffsetOfRuns>,
    noise_is_known: bool,
) -> Option<Left> {
    let ratio = one.error_over_known(offset)?;
    (ratio > ABOVE_FLOOR_MAX && !noise_is_known).then(|| Left {
        drivers: vec![one.data.channels.time_name.clone()],
        shape: format!(
            "error of {} at {ratio:.0} times the noise that is new in a reading",
            one.data.block.label
        ),
        share_of_residual_variance: 1.0 - ratio.powi(-2),
    })
}

/// Whether what is left of the quantity is white; `None` if there are too few observations to tell.
fn whiteness(Done { data, fit, .. }: &Done<'_>) -> Option<Whiteness> {
    let whitener = Whitener::new(data.layout, &fit.noise);
    of_innovations(&whitener.apply(&residual(*data, &fit.all())), &stretches(*data))
}

/// Whether the gyro sees less than half of the rotation that it should measure.
fn sees_little(base: &[Found]) -> bool {
    base.iter()
        .find(|found| found.shape.acts == Acts::Scale && found.shape.drivers.is_empty())
        .and_then(|found| found.coefficients.first())
        .is_some_and(|(scale, _)| *scale < -0.5)
}

/// The block of the headline: the one with the strongest effect.
fn main_block(done: &[Done<'_>]) -> usize {
    let strength =
        |one: &Done<'_>| one.fit.effects.iter().map(|found| found.strength).fold(0.0, f64::max);
    let mut best = 0;
    for index in 1..done.len() {
        if strength(&done[index]) > strength(&done[best]) {
            best = index;
        }
    }
    best
}

/// Held-out errors in every metric; for a driven path, the final position comes first.
fn errors(done: &[Done<'_>], seed: u64) -> (HeldOut, Vec<HeldOut>) {
    let main = main_block(done);
    let is_pose = |index: &usize| done[*index].data.block.aggregate == Aggregate::Pose;
    let mut order: Vec<usize> = (0..done.len()).filter(is_pose).collect();
    order.extend((0..done.len()).filter(|index| *index == main && !is_pose(index)));
    order.extend((0..done.len()).filter(|index| *index != main && !is_pose(index)));
    let several = done.iter().map(|one| one.errors().0.len()).sum::<usize>() > 1;
    let mut all: Vec<HeldOut> = order
        .into_iter()
        .flat_map(|index| {
            let (before, after) = done[index].errors();
            after
                .iter()
                .zip(before)
                .map(move |(after, before)| after.held_out(before, several, seed))
        })
        .collect();
    let first = all.remove(0);
    (first, all)
}
