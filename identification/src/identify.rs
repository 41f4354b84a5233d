//! The entry point: takes data and a model, returns a finding and a better model.

use crate::assemble::assemble;
use crate::clipping::{Clipped, clip};
use crate::dataset::Dataset;
use crate::done::{Done, Quantity};
use crate::finding::{Prediction, SetAside, Verdict};
use crate::fit::Data;
use crate::model::{Model, Shape};
use crate::noise::{Layout, NoiseModel};
use crate::outliers::{self, Wild};
use crate::problem::{Block, Known, Problem};
use crate::select::{Asked, BlockFit, agreed, fewer, is_against};
use crate::set_right::{set_right, worthwhile};
use crate::settling::{self, Unsettled};
use crate::{corrections, outcome, still, unreferenced, untold};

pub use crate::assemble::Identified;
pub use crate::error::IdentifyError;
pub use crate::options::Options;

/// Receives the progress: a share from 0 to 1 and the current activity.
pub type Progress<'a> = &'a mut dyn FnMut(f64, &str);

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
    model.map_or(Ok(()), |model| outcome::is_of_kind(model, dataset))?;
    progress(0.0, "reading");
    let (mut dataset, mut told) = without_outliers(dataset, model)?;
    let mut found = once(&dataset, model, options, progress)?;
    // What an effect hid shows once the effect is known.
    if !found.wild.is_empty() {
        outliers::set_aside(&mut dataset, &found.wild);
        outliers::join(&mut told, found.wild);
        found = once(&dataset, model, options, progress)?;
    }
    // What is late shows what was before the record, which the reference does not say.
    if model.is_none() && unreferenced::set_aside(&mut dataset, &found.identified.model) {
        found = once(&dataset, model, options, progress)?;
    }
    // A lag shows it as well, until it has settled.
    for _ in 0..SETTLING_ROUNDS {
        if model.is_some() || found.unsettled.is_empty() {
            break;
        }
        let mut less = dataset.clone();
        settling::set_aside(&mut less, &found.unsettled);
        let settled = once(&less, model, options, progress)?;
        if !found.unsettled.iter().all(|one| settling::is_same(one, &settled.terms)) {
            break;
        }
        (dataset, found) = (less, settled);
    }
    let mut identified = found.identified;
    progress(1.0, "done");
    identified.finding.set_aside = told;
    Ok(identified)
}

/// Applies `model` to `dataset`, less its outliers, without changing it.
///
/// # Errors
///
/// When the data lack what the kind or the model needs.
pub fn predict(dataset: &Dataset, model: &Model) -> Result<Prediction, IdentifyError> {
    outcome::is_of_kind(model, dataset)?;
    let (dataset, set_aside) = without_outliers(dataset, Some(model))?;
    Ok(Prediction { set_aside, ..outcome::predict(&dataset, model)? })
}

/// `dataset` without the rows that are wrong by themselves, beside the given model, and these.
fn without_outliers(
    dataset: &Dataset,
    model: Option<&Model>,
) -> Result<(Dataset, Vec<SetAside>), IdentifyError> {
    let (mut dataset, mut told) = (dataset.clone(), Vec::new());
    let mut wild = outliers::senseless(&dataset);
    outliers::set_aside(&mut dataset, &wild);
    still::without(&mut dataset)?;
    let fields = model.map_or_else(|| corrections::fields(&dataset), |one| one.corrections.clone());
    still::without_standing(&mut dataset, &fields)?;
    // Beside fields that are read wrongly all would be wild, or nothing.
    let exact = model.map_or_else(|| corrections::exact(&dataset), |one| one.corrections.clone());
    for _ in 0..=OUTLIER_ROUNDS {
        outliers::set_aside(&mut dataset, &wild);
        outliers::join(&mut told, wild);
        wild = plain_outliers(&corrections::applied(&dataset, &exact), model)?;
        if wild.is_empty() {
            break;
        }
    }
    Ok((dataset, told))
}

/// Rounds in which readings of a lag that has not settled show: its time constant was told from them as well.
const SETTLING_ROUNDS: usize = 3;

/// Rounds in which outliers that larger ones hid are found beside the plain model.
const OUTLIER_ROUNDS: usize = 3;

/// Outliers of `dataset`, which is set right, beside the given model.
fn plain_outliers(dataset: &Dataset, model: Option<&Model>) -> Result<Vec<Wild>, IdentifyError> {
    let problem = Problem::new(dataset, model.map(Model::known).unwrap_or_default())?;
    let terms = |block: &Block| base_terms(model, block, &problem);
    let terms: Vec<Vec<Shape>> = problem.blocks.iter().map(terms).collect::<Result<_, _>>()?;
    Ok(outliers::find(dataset, &problem, &terms).0)
}

/// What one identification finds.
struct Once {
    identified: Identified,
    /// Terms of all quantities.
    terms: Vec<Shape>,
    /// Outliers that show beside them.
    wild: Vec<Wild>,
    /// Readings of lags that have not settled.
    unsettled: Vec<Unsettled>,
}

/// Identification of `dataset` as it is.
fn once(
    dataset: &Dataset,
    model: Option<&Model>,
    options: &Options,
    progress: Progress<'_>,
) -> Result<Once, IdentifyError> {
    // A given model already holds its corrections.
    let corrections = model.map_or_else(
        || worthwhile(dataset, corrections::find(dataset)),
        |one| one.corrections.clone(),
    );
    let (stated, right) = (dataset, corrections::applied(dataset, &corrections));
    let dataset = &right;
    let fitted = corrections.iter().filter(|one| one.standard_error.is_some()).count();
    let effects_max = options.max_effects.saturating_sub(fitted);
    let mut problem = Problem::new(dataset, model.map(Model::known).unwrap_or_default())?;
    // A given model already holds its correction.
    let is_plain = model.is_none();
    let Problem { blocks, channels, .. } = &mut problem;
    let mut notices: Vec<String> =
        corrections.iter().filter_map(corrections::Correction::notice).collect();
    let mut clipped: Vec<Option<Clipped>> = Vec::new();
    for block in blocks.iter_mut() {
        let own = block.own.clone();
        let channels = own.as_deref().unwrap_or(channels);
        if is_plain {
            notices.extend(untold::without_scale(block, channels, dataset));
        }
        clipped.push(is_plain.then(|| clip(block, channels)).flatten());
    }
    let problem = problem;
    let noises = options.noise_from.as_ref().map(static_noises).transpose()?;
    let quantity = |block| {
        let base = base_terms(model, block, &problem)?;
        Ok(Quantity::new(block, problem.channels_of(block), base))
    };
    let quantities: Vec<Quantity<'_>> =
        problem.blocks.iter().map(quantity).collect::<Result<_, IdentifyError>>()?;
    notices.extend(quantities.iter().filter_map(Quantity::notice));
    let count = quantities.len() as f64;
    let mut done = Vec::new();
    for (index, quantity) in quantities.iter().enumerate() {
        let label = &quantity.read.label;
        let noise = noises.as_ref().and_then(|noises| matching(noises, quantity.read));
        let asked = Asked { share: 1.0 / count, effects_max, noise, timing: None };
        let factor = corrections::factor(&corrections, |field| field == label);
        let mut report = |share: f64| progress((index as f64 + share) / count, label);
        done.push(Done::new(quantity, &problem, asked, factor, &mut report));
    }
    let timing = agreed(&fits(&done));
    for one in &mut done {
        if timing.is_some_and(|timing| is_against(timing, &one.fit)) {
            one.search(Asked { timing, ..one.asked });
            one.fit_plain();
        }
    }
    let few = fewer(&fits(&done), effects_max);
    for (one, effects_max) in done.iter_mut().zip(few) {
        if let Some(effects_max) = effects_max {
            one.search(Asked { effects_max, timing, ..one.asked });
        }
    }
    for (one, clipped) in done.iter_mut().zip(&clipped) {
        clipped.iter().for_each(|clipped| one.put_before(clipped));
    }
    let set_right = match is_plain {
        true => set_right(stated, &corrections, &mut done)?,
        false => Vec::new(),
    };
    let mut identified = assemble(dataset, &problem, &done, set_right, options);
    identified.model.corrections = corrections;
    identified.finding.notices.extend(notices);
    let terms: Vec<Vec<Shape>> = done.iter().map(|one| one.fit.shapes()).collect();
    let (wild, mut left) = outliers::find(dataset, &problem, &terms);
    if left.is_empty() {
        let swallowed = |one: &Done<'_>| {
            outliers::swallowed(one.data.block, one.data.channels, &one.fit.noise.left_out)
        };
        left.extend(done.iter().filter_map(swallowed));
    }
    if !left.is_empty() {
        identified.finding.left.extend(left);
        identified.finding.verdict = Verdict::StructureLeft;
    }
    let unsettled = if is_plain { settling::unsettled(problem.kind, &done) } else { Vec::new() };
    Ok(Once { identified, terms: terms.concat(), wild, unsettled })
}

fn fits<'a>(done: &'a [Done<'_>]) -> Vec<&'a BlockFit> {
    done.iter().map(|one| &one.fit).collect()
}

/// Base terms of a block: the given ones, or those that the plain model of the kind fits.
fn base_terms(
    model: Option<&Model>,
    block: &Block,
    problem: &Problem,
) -> Result<Vec<Shape>, IdentifyError> {
    let Some(model) = model else { return Ok(constants(block)) };
    let mut shapes = Vec::new();
    for term in model.terms.iter().filter(|term| term.applies_to(block)) {
        let channels = problem.channels_of(block);
        let (shape, _) = term.to_shape(channels).map_err(IdentifyError)?;
        let shape = shape.anywhere();
        if shape.observed(block, channels).is_none() {
            return Err(IdentifyError(format!(
                "term `{}` needs what the data do not have",
                term.name
            )));
        }
        shapes.push(shape);
    }
    Ok(shapes)
}

/// What the plain model of the kind fits.
fn constants(block: &Block) -> Vec<Shape> {
    block.constants.iter().map(|known| Shape::constant(known.name, known.acts)).collect()
}

/// Noise of each quantity of a static data set.
fn static_noises(dataset: &Dataset) -> Result<Vec<(Block, NoiseModel)>, IdentifyError> {
    let problem = Problem::new(dataset, Known::default())?;
    Ok(problem
        .blocks
        .iter()
        .map(|block| {
            let layout = Layout::new(block, problem.channels_of(block));
            let data = Data::new(block, problem.channels_of(block), &layout);
            let columns = data.all_columns(&constants(block));
            let noise = data.residual(&columns).fit().of_all();
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
