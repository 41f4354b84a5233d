//! The entry: data and a model in, finding and a better model out.

use crate::dataset::Dataset;
use crate::experiment::{self, Doubt, Experiment};
use crate::finding::{Figure, Finding, HeldOut, Left, SCHEMA, Verdict};
use crate::judge::{Holding, Judge, Metric};
use crate::model::{Acts, KNOT, Model, Shape, Term, exposure};
use crate::noise::{self, Layout, NoiseModel};
use crate::outcome::{self, Diagnostics};
use crate::problem::{Aggregate, Block, Known, Problem};
use crate::select::{Asked, BlockFit, Data, Found, fit_terms, identify_block, without_rounding};

pub use crate::outcome::predict;

/// What the caller may choose.
#[derive(Debug, Clone)]
pub struct Options {
    /// Seed of whatever is drawn.
    pub seed: u64,
    /// Most effects to add.
    pub max_effects: usize,
    /// A static set of the same device, from which the noise is taken.
    pub noise_from: Option<Dataset>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, max_effects: 8, noise_from: None }
    }
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Identified {
    /// For `finding.json`.
    pub finding: Finding,
    /// For `model.toml`: the model given with what was found.
    pub model: Model,
    /// For a report.
    pub diagnostics: Diagnostics,
    /// The plan that would decide between what was found and its rivals, where there are any.
    pub experiment: Option<Experiment>,
}

/// Why a data set cannot be identified.
#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    /// It lacks what the kind needs.
    #[error("{0}")]
    Data(String),
    /// The model does not fit the data.
    #[error("{0}")]
    Model(String),
}

/// How far it is: a share from 0 to 1 and what is being done.
pub type Progress<'a> = &'a mut dyn FnMut(f64, &str);

/// One block with what came of it.
struct Done<'a> {
    data: Data<'a>,
    plain: Vec<Found>,
    fit: BlockFit,
    judge: Judge<'a>,
}

impl Done<'_> {
    /// Held-out errors of the model given, and with what was found; these without what the choice saw of a run.
    fn errors(&self) -> (&[Metric], &[Metric]) {
        (&self.fit.path[0].metrics, &self.fit.nested)
    }

    /// Held-out error over the white noise of a reading, where readings are alone.
    fn error_over_white(&self) -> Option<f64> {
        let is_row = self.data.block.aggregate == Aggregate::Row;
        let error = self.errors().1.first()?.errors.rmse();
        (is_row && self.fit.floor > 0.0).then(|| error / self.fit.floor)
    }

    /// Held-out errors without an effect.
    fn without(&self, effect: usize) -> Vec<Metric> {
        let mut shapes = self.fit.shapes();
        shapes.remove(self.fit.base.len() + effect);
        self.judge.judge(&shapes, &self.fit.noise, &self.fit.left_out)
    }
}

/// Finds what `model` (by default the plain model of the kind) lacks to explain `dataset`.
///
/// # Errors
///
/// When the data lack what the kind needs, or the model is of another kind.
pub fn identify(
    dataset: &Dataset,
    model: Option<&Model>,
    options: &Options,
    progress: Progress<'_>,
) -> Result<Identified, IdentifyError> {
    if let Some(model) = model
        && model.kind != dataset.kind
    {
        return Err(IdentifyError::Model("the model is of another kind than the data".to_owned()));
    }
    progress(0.0, "reading");
    let problem = Problem::new(dataset, model.map(Model::known).unwrap_or_default())?;
    let noises = options.noise_from.as_ref().map(static_noises).transpose()?;
    let mut notices = Vec::new();
    let mut working = Vec::new();
    for block in &problem.blocks {
        let base = base_terms(model, block, &problem)?;
        match without_rounding(block, problem.channels_of(block), &base) {
            Some((corrected, step)) => {
                notices.push(format!(
                    "`{}` is rounded to steps of {:.3e} {}, coarser than its noise; the mean rounding error is taken out",
                    block.label,
                    step / block.unit.si,
                    block.unit.text
                ));
                working.push(corrected);
            }
            None => working.push(block.clone()),
        }
    }
    let mut layouts: Vec<Layout> = Vec::new();
    for block in &working {
        layouts.push(layout(block, &problem, &base_terms(model, block, &problem)?));
    }
    let count = problem.blocks.len();
    let mut done = Vec::new();
    for (index, (block, layout)) in working.iter().zip(&layouts).enumerate() {
        let data = Data { block, channels: problem.channels_of(block), layout };
        let base = base_terms(model, block, &problem)?;
        let known = noises.as_ref().and_then(|noises| matching(noises, block));
        let mut report = |share: f64| {
            progress((index as f64 + share) / count as f64, &block.label);
        };
        // Errors are of the readings as they are.
        let read = Data { block: &problem.blocks[index], ..data };
        let judge = Judge { data: read, path: problem.path.as_ref(), holding: Holding::Spread };
        let asked =
            Asked { share: 1.0 / count as f64, effects_max: options.max_effects, noise: known };
        let fit = identify_block(data, &judge, base.clone(), asked, &mut report);
        let plain = fit_terms(data, &base, &fit.noise, &fit.left_out);
        done.push(Done { data, judge, plain, fit });
    }
    progress(1.0, "done");
    let mut identified = assemble(dataset, &problem, &done, options);
    identified.finding.notices.extend(notices);
    Ok(identified)
}

/// What the model has for a block: the terms given, or what the plain model of the kind fits.
fn base_terms(
    model: Option<&Model>,
    block: &Block,
    problem: &Problem,
) -> Result<Vec<Shape>, IdentifyError> {
    let plain =
        || block.constants.iter().map(|known| Shape::constant(known.name, known.acts)).collect();
    let Some(model) = model else {
        return Ok(plain());
    };
    let mut shapes = Vec::new();
    for term in &model.terms {
        let mine = term.axis.is_none() || block.axis.is_none() || term.axis == block.axis;
        let here = term.quantity.is_none() || term.quantity == block.apart;
        if mine && here && exposure(block, term.term).is_some() {
            let (shape, _) =
                term.to_shape(problem.channels_of(block)).map_err(IdentifyError::Model)?;
            if shape.observed(block, problem.channels_of(block)).is_none() {
                return Err(IdentifyError::Model(format!(
                    "term `{}` needs what the data do not have",
                    term.name
                )));
            }
            shapes.push(shape);
        }
    }
    Ok(shapes)
}

/// When the observations of a block were made, and how noise adds up in them.
fn layout(block: &Block, problem: &Problem, base: &[Shape]) -> Layout {
    let plain = Layout::new(block, problem.channels_of(block));
    let Some(bias) = block.exposure(Acts::Bias) else {
        return plain;
    };
    let durations: Vec<f64> = block.rows.iter().map(|&row| bias.per_row[row]).collect();
    let data = Data { block, channels: problem.channels_of(block), layout: &plain };
    let columns = data.all_columns(base);
    noise::likeliest_layout(plain, &durations, &block.residual, &columns)
}

/// Noise of each quantity of a static set.
fn static_noises(dataset: &Dataset) -> Result<Vec<(Block, NoiseModel)>, IdentifyError> {
    let problem = Problem::new(dataset, Known::default())?;
    Ok(problem
        .blocks
        .iter()
        .map(|block| {
            let layout = Layout::new(block, problem.channels_of(block));
            let data = Data { block, channels: problem.channels_of(block), layout: &layout };
            let base: Vec<Shape> = block
                .constants
                .iter()
                .map(|known| Shape::constant(known.name, known.acts))
                .collect();
            let (noise, _) = noise::fit(&layout, &block.residual, &data.all_columns(&base), None);
            (block.clone(), noise)
        })
        .collect())
}

fn matching<'a>(noises: &'a [(Block, NoiseModel)], block: &Block) -> Option<&'a NoiseModel> {
    noises
        .iter()
        .find(|(other, _)| other.aggregate == block.aggregate && other.axis == block.axis)
        .map(|(_, noise)| noise)
}

fn assemble(
    dataset: &Dataset,
    problem: &Problem,
    done: &[Done<'_>],
    options: &Options,
) -> Identified {
    let (seed, noise_is_known) = (options.seed, options.noise_from.is_some());
    let mut effects = Vec::new();
    let mut terms: Vec<Term> = Vec::new();
    let mut plain = Vec::new();
    let mut base = Vec::new();
    let mut left = Vec::new();
    let mut notices: Vec<String> =
        dataset.notices.iter().chain(&problem.notices).cloned().collect();
    let mut diagnostics =
        Diagnostics { blocks: Vec::new(), run_labels: dataset.run_labels.clone() };
    for one in done {
        for found in &one.plain {
            plain.push(outcome::term(one.data, found));
        }
        for found in &one.fit.base {
            let term = outcome::term(one.data, found);
            let numbers = term.parameters.iter().filter(|one| !KNOT.contains(&one.name.as_str()));
            base.extend(numbers.cloned().map(|mut parameter| {
                parameter.name.clone_from(&term.name);
                parameter
            }));
            terms.push(term);
        }
        for (index, found) in one.fit.effects.iter().enumerate() {
            let after = &one.fit.path[one.fit.chosen].metrics;
            let without = one.without(index);
            let of = |metrics: &[Metric]| metrics[0].errors.rmse() / metrics[0].unit.si;
            let mut effect = outcome::effect(one.data, found, of(&without), of(after));
            if found.shape.acts == Acts::Axis && sees_little(&one.fit.base) {
                effect.name = "wrong_axis".to_owned();
            }
            effects.push((found.strength, effect));
            terms.push(outcome::term(one.data, found));
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
        if let Some(slow) = above_white(one, noise_is_known) {
            left.push(slow);
        }
        if let Some(goes) = &one.fit.goes {
            left.push(goes.left(&one.data.block.label));
        }
        if let Some(ratio) = one.error_over_white() {
            notices.push(format!(
                "the held-out error of `{}` is {ratio:.1} times the white noise of a reading",
                one.data.block.label
            ));
        }
        match outcome::whiteness(one.data, &one.fit) {
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
    effects.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut effects: Vec<_> = effects.into_iter().map(|(_, effect)| effect).collect();
    outcome::lines_before_their_zero(&mut effects);
    let (held_out, held_out_also) = errors(done, seed);
    let verdict = if !left.is_empty() {
        Verdict::StructureLeft
    } else if effects.is_empty() {
        Verdict::NothingMissing
    } else if held_out.after < held_out.before
        || held_out_also.iter().any(|also| also.after < also.before)
    {
        Verdict::Explained
    } else {
        Verdict::StructureLeft
    };
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
    let experiment = experiment::next(dataset, problem, &doubts);
    let mut identified = Identified {
        finding: Finding {
            schema: SCHEMA,
            dataset: dataset.name.clone(),
            kind: dataset.kind,
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
            next_experiment: None,
            notices,
        },
        model: Model {
            schema: SCHEMA,
            kind: dataset.kind,
            dataset: Some(dataset.name.clone()),
            fields,
            counts_per_rad_per_s: problem.counts_per_unit,
            closing_lever_m: problem.closing_lever_m,
            terms,
            plain,
        },
        diagnostics,
        experiment,
    };
    if let Some(experiment) = &identified.experiment {
        experiment.note(&mut identified.finding);
    }
    identified
}

/// An error this many times the white noise from row to row is no noise by itself.
const ABOVE_WHITE_MAX: f64 = 5.0;

/// What is left so far above the white noise that something slow is in it, which no cause explains.
fn above_white(one: &Done<'_>, noise_is_known: bool) -> Option<Left> {
    let ratio = one.error_over_white()?;
    (ratio > ABOVE_WHITE_MAX && !noise_is_known).then(|| Left {
        drivers: vec![one.data.channels.time_name.clone()],
        shape: format!("error of {} at {ratio:.0} times its white noise", one.data.block.label),
        share_of_residual_variance: 1.0 - ratio.powi(-2),
    })
}

/// Does the gyro see less than half of the rotation that it should measure?
fn sees_little(base: &[Found]) -> bool {
    base.iter()
        .find(|found| found.shape.acts == Acts::Scale && found.shape.drivers.is_empty())
        .and_then(|found| found.coefficients.first())
        .is_some_and(|(scale, _)| *scale < -0.5)
}

/// The block that the headline is about: the one with the strongest effect.
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

/// Held-out errors in every metric: where a robot was driven, of its final position first.
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
