//! Readings of a lag that has not settled yet. A lag knows what was before the record, and the record does not: the model takes
//! it to be in equilibrium at the first row. Where it was not, what is left of its state dies out with its time constant, and
//! whoever fits that constant makes up for it. The readings until then take no part.

mod sight;

use crate::dataset::{Dataset, Kind};
use crate::done::Done;
use crate::fit::{Data, White, combine, fit_terms, less, robust_fit, values_of};
use crate::linear::{dot, solve};
use crate::model::{Form, Shape, Wrap, exposure};
use crate::noise::NoiseModel;
use crate::problem::{Aggregate, Block};
use crate::robust;
use crate::significance::surprise_chi2;
use std::ops::Range;

/// Risk that a lag in equilibrium at the beginning of all stretches of time is taken for one that is not.
const RISK: f64 = 0.01;
/// Standard errors of what is left of the state that the readings after it may hold.
const LEFT_MAX: f64 = 0.3;
/// Largest share of a stretch of time that is set aside: the time constant must show in the rest.
const SHARE_MAX: f64 = 0.5;
/// Maximum number of products of a fit: of a record with so many stretches each begins with a small part of it.
const PRODUCTS_MAX: usize = 400_000_000;

/// Error over what is new in a reading from which a model lacks something.
const STRUCTURE: f64 = 2.0;

/// Rows of a quantity in which a lag of its model has not settled yet.
pub(crate) struct Unsettled {
    /// Name of its column.
    column: String,
    rows: Vec<Range<usize>>,
    /// The lag.
    pub lag: Shape,
}

/// Sets those readings of `dataset` aside, and says so.
pub(crate) fn set_aside(dataset: &mut Dataset, all: &[Unsettled]) {
    for Unsettled { column: name, rows, lag } in all {
        let mut count = 0;
        for column in dataset.columns.iter_mut().filter(|column| column.name == *name) {
            for rows in rows {
                let values = &mut column.values[rows.clone()];
                count += values.iter().filter(|value| value.is_finite()).count();
                values.fill(f64::NAN);
            }
        }
        let stretches = if rows.len() == 1 { "stretch" } else { "stretches" };
        dataset.notices.push(format!(
            "{count} readings of `{name}` at the beginning of {} {stretches} of time are set aside: its {} had not settled",
            rows.len(),
            lag.name
        ));
    }
}

/// The lag of each quantity of `done` that had not settled at the beginning of some stretch of time.
pub(crate) fn unsettled(kind: Kind, done: &[Done<'_>]) -> Vec<Unsettled> {
    if !matches!(kind, Kind::Series | Kind::Sensor) {
        return Vec::new();
    }
    done.iter().filter_map(of_quantity).collect()
}

/// Whether a model of `done` still has the lag of `before`.
pub(crate) fn is_same(before: &Unsettled, shapes: &[Shape]) -> bool {
    shapes.iter().any(|shape| shape.says(&before.lag))
}

fn of_quantity(one: &Done<'_>) -> Option<Unsettled> {
    let data = one.data;
    if data.block.aggregate != Aggregate::Row {
        return None;
    }
    // A lag of something else starts anew where readings are left out: a compensation would have to settle again.
    let is_lag = |term: &&Shape| {
        term.form == Form::Delay && term.drivers.iter().any(|driver| driver.wrap == Wrap::LagOf)
    };
    let terms = one.fit.shapes();
    let added = &terms[one.fit.base.len()..];
    // Of several lags the longest settles last.
    let longest = added.iter().filter(is_lag).max_by(|a, b| constant(a).total_cmp(&constant(b)));
    if let Some(lag) = longest {
        return beside(data, &terms, &values_of(&one.fit.all()), lag);
    }
    // What a lag holds at the beginning may hide it.
    if added.iter().any(|term| term.form == Form::Delay) || one.error_over(0.0)? < STRUCTURE {
        return None;
    }
    let lag = sight::lag(data)?;
    let mut terms = terms[..one.fit.base.len()].to_vec();
    terms.push(lag.clone());
    let coefficients = fit_terms(data, &terms, &NoiseModel::white(data.layout.runs()));
    beside(data, &terms, &values_of(&coefficients), &lag)
}

fn constant(lag: &Shape) -> f64 {
    lag.number("time_constant").unwrap_or(0.0)
}

/// The readings in which `lag`, one of `terms`, has not settled.
fn beside(data: Data<'_>, terms: &[Shape], coefficients: &[f64], lag: &Shape) -> Option<Unsettled> {
    let constant = constant(lag);
    if !(constant > 0.0) {
        return None;
    }
    let lag = lag.clone();
    let (begins, rests) = rests(data, &lag, constant);
    let k = rests.len() + terms.len();
    if rests.is_empty() || k * k * data.block.rows.len() > PRODUCTS_MAX {
        return None;
    }
    // Beside what is left of the state: its noise is not that of a model without it.
    // A tangent of a lag is how it changes with its constant, and not the lag itself.
    let tangents = data.tangents(terms, coefficients).into_iter().map(|one| one.column);
    let model = data.all_columns(terms).into_iter().chain(tangents);
    let columns: Vec<Vec<f64>> = model.chain(rests.iter().cloned()).collect();
    let noise = data.residual(&columns).fit(None).of_all();
    let White { whitener, target, .. } = data.whitened(&[], &noise);
    let white = whitener.apply_all(&columns);
    let left = robust_fit(&white, &target);
    let first = columns.len() - rests.len();
    let inverse = solve(&white, &target).inverse;
    let scale = robust::spread(&less(&target, &combine(&white, &left.coefficients)));
    let needed = (rests.len() as f64 / RISK).ln();
    let mut rows = Vec::new();
    for (at, range) in begins.iter().enumerate() {
        let column = first + at;
        let error = scale * inverse[column][column].sqrt();
        let off = (left.coefficients[column] / error).abs();
        if !(error > 0.0) || !(surprise_chi2(off * off, 1.0) > needed) {
            continue;
        }
        // As large as its own column tells: beside others it is less certain, and disturbs them as much.
        let own = dot(&white[column], &white[column]).sqrt() / scale;
        let off = left.coefficients[column].abs() * own;
        let time = &data.channels.time;
        let until = time[first_reading(data.block, range)?] + constant * (off / LEFT_MAX).ln();
        let ends = [time[range.start], time[range.end - 1]];
        if until - ends[0] > SHARE_MAX * (ends[1] - ends[0]) {
            continue;
        }
        let count = time[range.clone()].partition_point(|at| *at < until);
        rows.push(range.start..range.start + count);
    }
    (!rows.is_empty()).then(|| Unsettled { column: data.block.label.clone(), rows, lag })
}

/// The stretches of time with readings, and of each what one unit of the state of `lag` at its first reading leaves in the readings.
fn rests(data: Data<'_>, lag: &Shape, constant: f64) -> (Vec<Range<usize>>, Vec<Vec<f64>>) {
    let Data { block, channels, .. } = data;
    let Some(exposed) = exposure(block, lag.acts) else { return (Vec::new(), Vec::new()) };
    // All of what is measured is late, whatever else its number says.
    let per_row = |row: usize| if lag.form == Form::Delay { 1.0 } else { exposed.per_row[row] };
    let of = |range: &Range<usize>| -> Option<(Range<usize>, Vec<f64>)> {
        let from = channels.time[first_reading(block, range)?];
        let rest = |row: &usize| match range.contains(row) {
            true => per_row(*row) * (-(channels.time[*row] - from) / constant).exp(),
            false => 0.0,
        };
        let column: Vec<f64> = block.rows.iter().map(rest).collect();
        Some((range.clone(), column))
    };
    channels.segments.iter().filter_map(of).unzip()
}

/// The first row of `range` with a reading.
fn first_reading(block: &Block, range: &Range<usize>) -> Option<usize> {
    let from = block.rows.partition_point(|row| *row < range.start);
    block.rows.get(from).copied().filter(|row| range.contains(row))
}
