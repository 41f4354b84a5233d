//! Applies a model to other data.

use crate::corrections::applied;
use crate::dataset::Dataset;
use crate::error::IdentifyError;
use crate::finding::{PredictedQuantity, Prediction, RmsePair, SCHEMA};
use crate::fit::Data;
use crate::judge::add_driven;
use crate::model::{Model, Shape, Term};
use crate::noise::Layout;
use crate::problem::{Added, Aggregate, Block, Closing, Path, PathError, Problem};
use crate::robust::root_mean_square;

/// Shapes and coefficients of the terms that apply to a block.
fn of_block(
    terms: &[Term],
    block: &Block,
    problem: &Problem,
) -> Result<(Vec<Shape>, Vec<f64>), IdentifyError> {
    let (mut shapes, mut coefficients) = (Vec::new(), Vec::new());
    for term in terms.iter().filter(|term| term.applies_to(block)) {
        let (shape, values) = term.to_shape(problem.channels_of(block)).map_err(IdentifyError)?;
        if shape.observed(block, problem.channels_of(block)).is_none() {
            let drivers: Vec<String> = term.drivers.iter().map(ToString::to_string).collect();
            return Err(IdentifyError(format!(
                "term `{}` needs {}, which the data do not have",
                term.name,
                drivers.join(" and ")
            )));
        }
        shapes.push(shape);
        coefficients.extend(values);
    }
    Ok((shapes, coefficients))
}

/// Residual of a block after terms; a level counts from the start of its run.
fn left(data: Data<'_>, terms: &(Vec<Shape>, Vec<f64>)) -> Vec<f64> {
    data.since_start(data.left(&terms.0, &terms.1))
}

/// Whether a model and data are of one kind.
///
/// # Errors
///
/// When they are not.
pub fn is_of_kind(model: &Model, dataset: &Dataset) -> Result<(), IdentifyError> {
    if model.kind == dataset.kind {
        return Ok(());
    }
    Err(IdentifyError(format!(
        "the model is of kind `{}`, the data of kind `{}`",
        model.kind.name(),
        dataset.kind.name()
    )))
}

/// Applies `model` to `dataset` as it is.
///
/// # Errors
///
/// When the data lack what the kind or the model needs.
pub fn predict(dataset: &Dataset, model: &Model) -> Result<Prediction, IdentifyError> {
    let stated = Problem::new(dataset, model.known())?.path;
    let right = applied(dataset, &model.corrections);
    let problem = Problem::new(&right, model.known())?;
    let mut quantities = Vec::new();
    let rows = dataset.rows();
    let (mut corrections, mut plain_corrections) = (Added::nothing(rows), Added::nothing(rows));
    for block in &problem.blocks {
        let layout = Layout::new(block, problem.channels_of(block));
        let data = Data::new(block, problem.channels_of(block), &layout);
        let all = of_block(&model.terms, block, &problem)?;
        let plain = of_block(&model.plain, block, &problem)?;
        if block.aggregate == Aggregate::Pose {
            for (terms, added) in [(&all, &mut corrections), (&plain, &mut plain_corrections)] {
                add_driven(data, &terms.0, &terms.1, added);
            }
            continue;
        }
        let (before, after) = (left(data, &plain), left(data, &all));
        if let Some(closing) = &block.closing {
            quantities.extend(readings(closing, block, rows, &before, &after));
            continue;
        }
        let si = block.unit.si;
        let predicted = after.iter().enumerate().map(|(i, after)| match block.aggregate {
            // In the unit of the residual; counts are converted to a rate.
            Aggregate::Row => (block.measured(i) - after) / si,
            _ => (block.residual[i] - after) / si,
        });
        quantities.push(PredictedQuantity {
            quantity: block.label.clone(),
            unit: block.unit.text.clone(),
            rmse: RmsePair {
                before: root_mean_square(&before) / si,
                after: root_mean_square(&after) / si,
            },
            at: places(block.rows.clone(), rows),
            predicted: predicted.collect(),
            residual: after.iter().map(|after| after / si).collect(),
        });
    }
    if let Some((stated, path)) = stated.as_ref().zip(problem.path.as_ref()) {
        let both = [(stated, &plain_corrections), (path, &corrections)];
        quantities.insert(0, headings(both));
        quantities.insert(0, positions(both));
    }
    let first = quantities.remove(0);
    Ok(Prediction {
        schema: SCHEMA,
        dataset: dataset.name.clone(),
        kind: dataset.kind,
        rows,
        quantity: first.quantity,
        unit: first.unit,
        rmse: first.rmse,
        at: first.at,
        predicted: first.predicted,
        residual: first.residual,
        also: quantities,
        set_aside: Vec::new(),
    })
}

/// Rows of figures; none if every one of `rows` has one.
fn places(at: Vec<usize>, rows: usize) -> Vec<usize> {
    if at.iter().copied().eq(0..rows) { Vec::new() } else { at }
}

/// Readings at the ends of laps, each in its own unit. The prediction is the error of the odometry.
fn readings(
    closing: &Closing,
    block: &Block,
    rows: usize,
    before: &[f64],
    after: &[f64],
) -> Vec<PredictedQuantity> {
    let degree = crate::dataset::Unit::Degree.si();
    [("deg", degree), ("m", 1.0), ("m", 1.0)]
        .into_iter()
        .enumerate()
        .map(|(which, (unit, si))| {
            let (mut lefts, mut residual) = (Vec::new(), Vec::new());
            let (mut at, mut predicted) = (Vec::new(), Vec::new());
            for (i, &row) in block.rows.iter().enumerate() {
                if closing.component[i] != which {
                    continue;
                }
                let lever = closing.lever_of(i, row) / si;
                lefts.push(before[i] * lever);
                at.push(row);
                residual.push(after[i] * lever);
                predicted.push((block.residual[i] - after[i]) * lever);
            }
            let rmse =
                RmsePair { before: root_mean_square(&lefts), after: root_mean_square(&residual) };
            PredictedQuantity {
                quantity: closing.labels[which].clone(),
                unit: unit.to_owned(),
                rmse,
                at: places(at, rows),
                predicted,
                residual,
            }
        })
        .collect()
}

/// Final positions of dead reckoning, one per run (in its last row): distance from the reference.
fn positions(both: [(&Path, &Added); 2]) -> PredictedQuantity {
    finals(both, ("final_position", "m", 1.0), |error| error.position)
}

/// Final headings, in the same way.
fn headings(both: [(&Path, &Added); 2]) -> PredictedQuantity {
    let degree = crate::dataset::Unit::Degree.si();
    finals(both, ("final_heading", "deg", degree), |error| error.heading)
}

fn finals(
    [(stated, plain), (path, all)]: [(&Path, &Added); 2],
    (name, unit, si): (&str, &str, f64),
    of: impl Fn(&PathError) -> f64,
) -> PredictedQuantity {
    let (mut at, mut before, mut after) = (Vec::new(), Vec::new(), Vec::new());
    for (run, rows) in path.runs.iter().enumerate() {
        if let Some(error) = stated.error(run, plain) {
            before.push(of(&error) / si);
        }
        if let Some(error) = path.error(run, all) {
            after.push(of(&error) / si);
            at.push(rows.end - 1);
        }
    }
    PredictedQuantity {
        quantity: name.to_owned(),
        unit: unit.to_owned(),
        rmse: RmsePair { before: root_mean_square(&before), after: root_mean_square(&after) },
        at: places(at, path.distance.len()),
        predicted: Vec::new(),
        residual: after,
    }
}
