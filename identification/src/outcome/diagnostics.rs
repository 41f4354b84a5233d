//! Report data of a block.

use crate::finding::Parameter;
use crate::fit::{Data, Found, combine, residual};
use crate::judge::Errors;
use crate::model::{exposure, place_unit, see};
use crate::noise::Whitener;
use crate::problem::{Aggregate, runs};
use crate::select::BlockFit;
use std::ops::Range;

/// Lags of the autocorrelation plot.
const LAGS: usize = 60;
/// Points of a fitted curve.
const POINTS: usize = 80;

/// Named numbers with a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// One per observation.
    pub values: Vec<f64>,
}

/// A fitted effect over its first driver.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCurve {
    /// Name of the effect.
    pub name: String,
    /// Driver on the horizontal axis.
    pub driver: String,
    /// Unit of the driver.
    pub driver_unit: String,
    /// Unit of the effect's contribution to an observation.
    pub unit: String,
    /// Driver and effect, sorted by driver.
    pub points: Vec<(f64, f64)>,
    /// Driver and residual without this effect, one per observation.
    pub observed: Vec<(f64, f64)>,
}

/// Held-out error of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunError {
    /// Index of the run.
    pub run: usize,
    /// Root mean square before.
    pub before: f64,
    /// Root mean square after.
    pub after: f64,
}

/// Report data of one observed quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockDiagnostics {
    /// The quantity.
    pub label: String,
    /// Unit of residuals.
    pub unit: String,
    /// Time of each observation.
    pub time: Vec<f64>,
    /// Its unit.
    pub time_unit: String,
    /// Run of each observation.
    pub run: Vec<usize>,
    /// Residual of the given model.
    pub before: Vec<f64>,
    /// Residual of the model found.
    pub after: Vec<f64>,
    /// Which observations count as outliers.
    pub outliers: Vec<bool>,
    /// Possible causes.
    pub channels: Vec<Series>,
    /// The effects that were added.
    pub effects: Vec<EffectCurve>,
    /// Autocorrelation of the whitened residual at lag 1, 2 ..., before and after.
    pub autocorrelation: (Vec<f64>, Vec<f64>),
    /// Averaging time, and the Allan deviation of the residual before and after.
    pub allan: Vec<(f64, f64, f64)>,
    /// Held-out errors.
    pub by_run: Vec<RunError>,
    /// The noise that remains, in words and numbers.
    pub noise: Vec<Parameter>,
}

/// Report data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Diagnostics {
    /// One per observed quantity.
    pub blocks: Vec<BlockDiagnostics>,
    /// Labels of the runs.
    pub run_labels: Vec<String>,
}

fn autocorrelation(values: &[f64]) -> Vec<f64> {
    let power: f64 = values.iter().map(|value| value * value).sum();
    (1..=LAGS.min(values.len() / 4))
        .map(|lag| values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / power)
        .collect()
}

/// Overlapping Allan deviation of consecutive values.
fn allan(values: &[f64], interval: f64) -> Vec<(f64, f64)> {
    let n = values.len();
    let mut sums = vec![0.0; n + 1];
    for i in 0..n {
        sums[i + 1] = sums[i] + values[i];
    }
    let mut found = Vec::new();
    let mut m = 1;
    while 3 * m <= n {
        let count = n + 1 - 2 * m;
        let total: f64 = (0..count)
            .map(|i| ((sums[i + 2 * m] - 2.0 * sums[i + m] + sums[i]) / m as f64).powi(2))
            .sum();
        found.push((m as f64 * interval, (total / (2.0 * count as f64)).sqrt()));
        m = (m * 3 / 2).max(m + 1);
    }
    found
}

/// Curve of an effect over its driver; `all` starts with `base` terms of the given model.
fn curve(data: Data<'_>, all: &[Found], base: usize, index: usize) -> Option<EffectCurve> {
    let shape = &all[index].shape;
    let is_mine = |at: usize| at == index || at >= base && all[at].shape.shares_polynomial(shape);
    let mine: Vec<&Found> = (0..all.len()).filter(|&at| is_mine(at)).map(|at| &all[at]).collect();
    // The lowest power stands for its polynomial.
    let lowest = mine.iter().min_by_key(|found| found.shape.form)?;
    if !std::ptr::eq(*lowest, &all[index]) {
        return None;
    }
    let driver = shape.drivers.first()?;
    let x_rows = see(data.channels, driver, &shape.fixed)?;
    let exposed = exposure(data.block, shape.acts)?;
    let x = place_unit(data.channels, shape, 0);
    let (x_unit, x_si) = (x.text, x.si);
    let mut per_row = vec![0.0; x_rows.len()];
    for found in mine {
        let added = combine(&found.shape.per_row(data.channels)?, &found.values());
        per_row.iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
    }
    let mut points: Vec<(f64, f64)> =
        x_rows.iter().zip(&per_row).map(|(x, y)| (x / x_si, y / exposed.unit.si)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let step = (points.len() / POINTS).max(1);
    let points = points.into_iter().step_by(step).collect();
    let others: Vec<Found> =
        (0..all.len()).filter(|&at| !is_mine(at)).map(|at| all[at].clone()).collect();
    let left = residual(data, &others);
    // The residual per unit of exposure, if the exposure is large enough.
    let observed = if data.block.aggregate == Aggregate::Row {
        let largest = exposed.per_row.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        data.block
            .rows
            .iter()
            .zip(&left)
            .filter(|(row, _)| exposed.per_row[**row].abs() > 0.1 * largest)
            .map(|(&row, left)| (x_rows[row] / x_si, left / exposed.per_row[row] / exposed.unit.si))
            .collect()
    } else {
        Vec::new()
    };
    Some(EffectCurve {
        name: shape.name.clone(),
        driver: driver.to_string(),
        driver_unit: x_unit,
        unit: exposed.unit.text.clone(),
        points,
        observed,
    })
}

/// Report data of a block.
pub(crate) fn diagnose(
    data: Data<'_>,
    plain: &[Found],
    fit: &BlockFit,
    errors: (&Errors, &Errors),
) -> BlockDiagnostics {
    let (all, base) = (fit.all(), fit.base.len());
    let unit = &data.block.unit;
    let (before, after) =
        (data.since_start(residual(data, plain)), data.since_start(residual(data, &all)));
    let whitener = Whitener::new(data.layout, &fit.noise);
    let interval = data.layout.interval();
    let longest = longest_run(&data.layout.run);
    let (a, b) = (allan(&before[longest.clone()], interval), allan(&after[longest], interval));
    let shown = |values: &[f64]| values.iter().map(|value| value / unit.si).collect::<Vec<f64>>();
    BlockDiagnostics {
        label: data.block.label.clone(),
        unit: unit.text.clone(),
        time: data.block.rows.iter().map(|&row| data.channels.time[row]).collect(),
        time_unit: data.channels.time_unit.text().to_owned(),
        run: data.layout.run.clone(),
        autocorrelation: (
            autocorrelation(&whitener.apply(&before)),
            autocorrelation(&whitener.apply(&after)),
        ),
        allan: a.iter().zip(&b).map(|(a, b)| (a.0, a.1 / unit.si, b.1 / unit.si)).collect(),
        before: shown(&before),
        after: shown(&after),
        outliers: fit.noise.left_out.clone(),
        channels: channels(data),
        effects: (base..all.len()).filter_map(|index| curve(data, &all, base, index)).collect(),
        by_run: by_run(errors, unit.si),
        noise: noise(data, fit),
    }
}

fn by_run((before, after): (&Errors, &Errors), unit: f64) -> Vec<RunError> {
    before
        .runs
        .iter()
        .filter_map(|(run, sum, count)| {
            let other = after.runs.iter().find(|(index, _, _)| index == run)?;
            let root = |sum: f64, count: f64| (sum / count).sqrt() / unit;
            Some(RunError { run: *run, before: root(*sum, *count), after: root(other.1, other.2) })
        })
        .collect()
}

fn longest_run(run: &[usize]) -> Range<usize> {
    let longer =
        |best: Range<usize>, rows: Range<usize>| if rows.len() > best.len() { rows } else { best };
    let best = runs(run).fold(0..0, longer);
    // Many short runs (turns of a table) count as one record.
    if best.len() * 8 < run.len() { 0..run.len() } else { best }
}

fn channels(data: Data<'_>) -> Vec<Series> {
    let rows = &data.block.rows;
    let mut found: Vec<Series> = data
        .channels
        .channels
        .iter()
        .map(|channel| Series {
            name: channel.name.clone(),
            unit: channel.unit.text().to_owned(),
            values: rows.iter().map(|&row| channel.values[row] / channel.unit.si()).collect(),
        })
        .collect();
    if !data.channels.rotation.is_empty() {
        let unit = data.channels.rotation_unit;
        found.push(Series {
            name: data.channels.rotation_name.clone(),
            unit: unit.text().to_owned(),
            values: rows.iter().map(|&row| data.channels.rotation[row] / unit.si()).collect(),
        });
    }
    found
}

fn noise(data: Data<'_>, fit: &BlockFit) -> Vec<Parameter> {
    let unit = &data.block.unit;
    let white = fit.scale * fit.noise.white.sqrt();
    let mut found = vec![Parameter::new("white", white / unit.si, &unit.text)];
    for part in &fit.noise.coloured {
        let rms = fit.scale * part.variance.sqrt();
        let name = if part.correlation_s.is_finite() {
            format!("correlated_over_{:.3}_{}", part.correlation_s, data.channels.time_unit.text())
        } else {
            "offset_of_each_run".to_owned()
        };
        found.push(Parameter::new(&name, rms / unit.si, &unit.text));
    }
    found
}
