//! Applies a model to other data.

use crate::corrections::applied;
use crate::dataset::Dataset;
use crate::error::IdentifyError;
use crate::finding::{PredictedQuantity, Prediction, RmsePair, SCHEMA};
use crate::judge::add_driven;
use crate::model::{Model, Shape, Term, exposure};
use crate::noise::Layout;
use crate::problem::{Added, Aggregate, Block, Closing, Path, PathError, Problem};
use crate::robust::root_mean_square;
use crate::select::{Data, combine};

/// Shapes and coefficients of the terms that apply to a block.
fn of_block(
    terms: &[Term],
    block: &Block,
    problem: &Problem,
) -> Result<(Vec<Shape>, Vec<f64>), IdentifyError> {
    let (mut shapes, mut coefficients) = (Vec::new(), Vec::new());
    for term in terms {
        let mine = term.axis.is_none() || block.axis.is_none() || term.axis == block.axis;
        let here = term.quantity.is_none() || term.quantity == block.apart;
        if !mine || !here || exposure(block, term.term).is_none() {
            continue;
        }
        let (shape, values) =
            term.to_shape(problem.channels_of(block)).map_err(IdentifyError::Model)?;
        if shape.observed(block, problem.channels_of(block)).is_none() {
            let drivers: Vec<String> = term.drivers.iter().map(ToString::to_string).collect();
            return Err(IdentifyError::Model(format!(
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
    let fitted = combine(&data.all_columns(&terms.0), &terms.1);
    let mut left: Vec<f64> = data
        .block
        .residual
        .iter()
        .enumerate()
        .map(|(i, value)| value - fitted.get(i).copied().unwrap_or(0.0))
        .collect();
    if data.block.aggregate == Aggregate::Level {
        let mut first = 0.0;
        for i in 0..left.len() {
            if i == 0 || data.layout.run[i] != data.layout.run[i - 1] {
                first = left[i];
            }
            left[i] -= first;
        }
    }
    left
}

/// Applies `model` to `dataset` without changing it.
///
/// # Errors
///
/// When the data lack what the kind or the model needs.
pub fn predict(dataset: &Dataset, model: &Model) -> Result<Prediction, IdentifyError> {
    if model.kind != dataset.kind {
        return Err(IdentifyError::Model(format!(
            "the model is of kind `{}`, the data of kind `{}`",
            word(model.kind),
            word(dataset.kind)
        )));
    }
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
        let mut residual = vec![None; rows];
        let mut predicted = vec![None; rows];
        for (i, &row) in block.rows.iter().enumerate() {
            residual[row] = Some(after[i] / block.unit.si);
            if block.aggregate == Aggregate::Row {
                // In the unit of the residual; counts are converted to a rate.
                predicted[row] = Some((block.measured(i) - after[i]) / block.unit.si);
            } else {
                predicted[row] = Some((block.residual[i] - after[i]) / block.unit.si);
            }
        }
        quantities.push(PredictedQuantity {
            quantity: block.label.clone(),
            unit: block.unit.text.clone(),
            rmse: RmsePair {
                before: root_mean_square(&before) / block.unit.si,
                after: root_mean_square(&after) / block.unit.si,
            },
            predicted,
            residual,
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
        predicted: first.predicted,
        residual: first.residual,
        also: quantities,
    })
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
            let (mut residual, mut predicted) = (vec![None; rows], vec![None; rows]);
            let (mut lefts, mut mine) = (Vec::new(), Vec::new());
            for (i, &row) in block.rows.iter().enumerate() {
                if closing.component[i] != which {
                    continue;
                }
                let lever = closing.lever_of(i, row) / si;
                lefts.push(before[i] * lever);
                mine.push(after[i] * lever);
                residual[row] = Some(after[i] * lever);
                predicted[row] = Some((block.residual[i] - after[i]) * lever);
            }
            PredictedQuantity {
                quantity: closing.labels[which].clone(),
                unit: unit.to_owned(),
                rmse: RmsePair { before: root_mean_square(&lefts), after: root_mean_square(&mine) },
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
    let mut residual = vec![None; path.distance.len()];
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for (run, rows) in path.runs.iter().enumerate() {
        if let Some(error) = stated.error(run, plain) {
            before.push(of(&error) / si);
        }
        if let Some(error) = path.error(run, all) {
            after.push(of(&error) / si);
            residual[rows.end - 1] = Some(of(&error) / si);
        }
    }
    PredictedQuantity {
        quantity: name.to_owned(),
        unit: unit.to_owned(),
        rmse: RmsePair { before: root_mean_square(&before), after: root_mean_square(&after) },
        predicted: vec![None; path.distance.len()],
        residual,
    }
}

fn word(kind: crate::dataset::Kind) -> String {
    format!("{kind:?}").to_lowercase()
}
