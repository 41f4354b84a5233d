//! Readings of a lag or a play that has not settled yet. It knows what was before the record, and the record does not: the model
//! takes a lag to be in equilibrium at the first row, and a play to be in its middle. Where it was not, what is left of its state
//! dies out with its time constant, or when the play was gone through, and whoever fits that number makes up for it. The
//! readings until then take no part.

mod sight;

use crate::dataset::{Dataset, Kind};
use crate::done::Done;
use crate::fit::{Data, White, combine, fit_terms, less, robust_fit, values_of};
use crate::linear::{dot, solve};
use crate::model::{Driver, Form, Shape, Wrap, exposure, see};
use crate::noise::NoiseModel;
use crate::problem::{Aggregate, Block};
use crate::robust;
use crate::signal;
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
    let terms = one.fit.shapes();
    let added = &terms[one.fit.base.len()..];
    // Of several the one that settles last.
    let left =
        |rests: &Rests| rests.iter().flat_map(|(_, rest)| rest).map(|rest| rest.abs()).sum::<f64>();
    // What firmware takes off a sensor's readings starts anew where some are left out: a lag of something else would have to
    // settle again.
    let may_go = |term: &&Shape| term.form == Form::Delay || !data.channels.of_sensor;
    let all = added.iter().filter(may_go).filter_map(|term| Some((term, rests(data, term)?)));
    if let Some((longest, _)) = all.max_by(|(_, a), (_, b)| left(a).total_cmp(&left(b))) {
        return beside(data, &terms, &values_of(&one.fit.all()), longest);
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

/// The readings in which `lag`, one of `terms`, has not settled.
fn beside(data: Data<'_>, terms: &[Shape], coefficients: &[f64], lag: &Shape) -> Option<Unsettled> {
    let (begins, rests): (Vec<_>, Vec<_>) = rests(data, lag)?.into_iter().unzip();
    let k = rests.len() + terms.len();
    if rests.is_empty() || k * k * data.block.rows.len() > PRODUCTS_MAX {
        return None;
    }
    // Beside what is left of the state: its noise is not that of a model without it.
    // A tangent of a lag is how it changes with its constant, and not the lag itself.
    let tangents = data.tangents(terms, coefficients).into_iter().map(|one| one.column);
    let model = data.all_columns(terms).into_iter().chain(tangents);
    let columns: Vec<Vec<f64>> = model.chain(rests.iter().cloned()).collect();
    let noise = data.residual(&columns).fit().of_all();
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
        // What is left from a row on has this share of the squares.
        let mut share = dot(&rests[at], &rests[at]) * (LEFT_MAX / off).powi(2);
        let last = rests[at].iter().rposition(|rest| {
            share -= rest * rest;
            share < 0.0
        });
        let until = last.map_or(range.start, |last| data.block.rows[last] + 1);
        let time = |row: usize| data.channels.time[row] - data.channels.time[range.start];
        if until > range.start && time(until - 1) <= SHARE_MAX * time(range.end - 1) {
            rows.push(range.start..until);
        }
    }
    let (column, lag) = (data.block.label.clone(), lag.clone());
    (!rows.is_empty()).then_some(Unsettled { column, rows, lag })
}

/// Stretches of time with readings, and of each what one unit of a state at its first reading leaves in the readings.
type Rests = Vec<(Range<usize>, Vec<f64>)>;

/// Those of the state of `term`, if it has one.
fn rests(data: Data<'_>, term: &Shape) -> Option<Rests> {
    let Data { block, channels, .. } = data;
    let driver = term.drivers.first()?;
    let exposed = exposure(block, term.acts)?;
    // All of what is measured is late, whatever else its number says.
    let per_row = |row: usize| if term.form == Form::Delay { 1.0 } else { exposed.per_row[row] };
    let state: Box<dyn Fn(Range<usize>) -> Vec<f64>> = match driver.wrap {
        Wrap::LagOf => {
            let constant = term.number("time_constant").filter(|constant| *constant > 0.0)?;
            Box::new(move |rows: Range<usize>| {
                let times = &channels.time[rows];
                times.iter().map(|time| (-(time - times[0]) / constant).exp()).collect()
            })
        }
        // A play is anywhere in its width at first, until its driver has gone through all of that.
        Wrap::BranchOf => {
            let plain = Driver { wrap: Wrap::Plain, ..driver.clone() };
            let (values, half) = (see(channels, &plain, &term.fixed)?, term.number("half_width")?);
            Box::new(move |rows: Range<usize>| signal::undecided(&values[rows], half))
        }
        _ => return None,
    };
    let of = |range: &Range<usize>| -> Option<(Range<usize>, Vec<f64>)> {
        let from = first_reading(block, range)?;
        let state = state(from..range.end);
        let rest = |row: &usize| match (from..range.end).contains(row) {
            true => per_row(*row) * state[row - from],
            false => 0.0,
        };
        Some((range.clone(), block.rows.iter().map(rest).collect()))
    };
    Some(channels.segments.iter().filter_map(of).collect())
}

/// The first row of `range` with a reading.
fn first_reading(block: &Block, range: &Range<usize>) -> Option<usize> {
    let from = block.rows.partition_point(|row| *row < range.start);
    block.rows.get(from).copied().filter(|row| range.contains(row))
}
