//! Errors on whole runs that took no part in the fit, in the unit of the data.

use crate::finding::HeldOut;
use crate::linear::solve;
use crate::model::{Acts, Shape, exposure};
use crate::noise::{NoiseModel, Whitener};
use crate::problem::{Aggregate, Path};
use crate::select::{Data, combine, folds};
use rand::{RngExt, SeedableRng};

/// Draws of the bootstrap over runs.
const DRAWS: usize = 400;

/// Squared errors, run by run.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// For each run that has any: its index, the sum of squared errors and their number.
    pub runs: Vec<(usize, f64, f64)>,
    /// In how many folds they were had.
    pub folds: usize,
}

impl Errors {
    /// Root of the mean square.
    pub fn rmse(&self) -> f64 {
        let (sum, count) = self.runs.iter().fold((0.0, 0.0), |(s, c), run| (s + run.1, c + run.2));
        if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
    }

    fn add(&mut self, run: usize, square: f64) {
        match self.runs.iter_mut().find(|(index, _, _)| *index == run) {
            Some((_, sum, count)) => {
                *sum += square;
                *count += 1.0;
            }
            None => self.runs.push((run, square, 1.0)),
        }
    }

    /// 95 % interval of the root mean square, from drawing runs with replacement.
    fn interval(&self, seed: u64) -> [f64; 2] {
        let n = self.runs.len();
        if n < 2 {
            let value = self.rmse();
            return [value, value];
        }
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        let mut draws: Vec<f64> = (0..DRAWS)
            .map(|_| {
                let (sum, count) = (0..n).fold((0.0, 0.0), |(s, c), _| {
                    let run = &self.runs[random.random_range(0..n)];
                    (s + run.1, c + run.2)
                });
                (sum / count).sqrt()
            })
            .collect();
        draws.sort_by(f64::total_cmp);
        let at = |share: f64| draws[(share * (DRAWS - 1) as f64).round() as usize];
        [at(0.025), at(0.975)]
    }
}

/// Columns of the terms and the residual, whitened.
struct White {
    columns: Vec<Vec<f64>>,
    residual: Vec<f64>,
}

impl White {
    fn new(data: Data<'_>, columns: &[Vec<f64>], noise: &NoiseModel, left_out: &[bool]) -> Self {
        let whitener = Whitener::new(data.layout, noise, left_out);
        let residual = whitener.apply(&data.block.residual);
        Self { columns: whitener.apply_all(columns), residual }
    }

    /// Coefficients from the observations of `train`.
    fn train(&self, train: &[bool]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> =
            self.columns.iter().map(|column| masked(column, train)).collect();
        solve(&columns, &masked(&self.residual, train)).coefficients
    }
}

fn masked(column: &[f64], keep: &[bool]) -> Vec<f64> {
    column.iter().zip(keep).map(|(value, keep)| if *keep { *value } else { 0.0 }).collect()
}

impl Data<'_> {
    /// Errors of `terms` over held-out observations.
    pub(crate) fn held_out(
        &self,
        terms: &[Shape],
        noise: &NoiseModel,
        left_out: &[bool],
    ) -> Errors {
        let columns = self.all_columns(terms);
        let white = White::new(*self, &columns, noise, left_out);
        let folds = folds(&self.layout.run);
        let mut errors = Errors { folds: folds.len(), ..Errors::default() };
        let run = &self.layout.run;
        let alone = run.iter().all(|other| *other == run[0]);
        for (number, fold) in folds.iter().enumerate() {
            // Of one run alone, each fold stands for itself.
            let of = |run: usize| if alone { number } else { run };
            let coefficients = white.train(&fold.train);
            let fitted = combine(&columns, &coefficients);
            let error = |i: usize| self.block.residual[i] - fitted.get(i).copied().unwrap_or(0.0);
            let mut start = None;
            for i in 0..run.len() {
                if !fold.test[i] {
                    start = None;
                    continue;
                }
                if self.block.aggregate == Aggregate::Row {
                    errors.add(of(run[i]), error(i).powi(2));
                } else {
                    // A level counts from where its stretch begins.
                    let key =
                        (run[i], self.block.pose.as_ref().map(|pose| pose.component[i] as usize));
                    if key.1.is_some_and(|component| component > 0) {
                        // Of one run alone, the heading.
                        continue;
                    }
                    match start {
                        Some((from, first)) if from == key => {
                            let first: f64 = first;
                            errors.add(of(run[i]), (error(i) - first).powi(2));
                        }
                        _ => start = Some((key, error(i))),
                    }
                }
            }
        }
        errors
    }
}

/// Final position errors (m) and heading errors (rad) of dead reckoning over held-out runs; `None` where there is one
/// run only. `blocks` are the heading's and the distance's.
pub(crate) fn path_errors(
    path: &Path,
    blocks: &[(Data<'_>, Vec<Shape>, &NoiseModel, &[bool])],
) -> Option<(Errors, Errors)> {
    if path.runs.len() < 2 {
        return None;
    }
    let (mut positions, mut headings) = (Errors::default(), Errors::default());
    let first = blocks.first()?;
    let of_row: Vec<usize> = first.0.channels.run.clone();
    let row_folds = folds(&of_row);
    let n = of_row.len();
    let white: Vec<White> = blocks
        .iter()
        .map(|(data, terms, noise, left_out)| {
            White::new(*data, &data.all_columns(terms), noise, left_out)
        })
        .collect();
    for fold in &row_folds {
        let (mut turn, mut distance) = (vec![0.0; n], vec![0.0; n]);
        for ((data, terms, _, _), white) in blocks.iter().zip(&white) {
            let keep: Vec<bool> = data.block.rows.iter().map(|&row| fold.train[row]).collect();
            let coefficients = white.train(&keep);
            add_driven(*data, terms, &coefficients, &mut turn, &mut distance);
        }
        for (index, rows) in path.runs.iter().enumerate() {
            if fold.test[rows.start]
                && let Some(error) = path.error(index, &turn, &distance)
            {
                positions.add(index, error.position.powi(2));
                headings.add(index, error.heading.powi(2));
            }
        }
    }
    positions.folds = row_folds.len();
    headings.folds = row_folds.len();
    Some((positions, headings))
}

/// Adds what `terms` say of the turn and the distance of each row.
pub(crate) fn add_driven(
    data: Data<'_>,
    terms: &[Shape],
    coefficients: &[f64],
    turn: &mut [f64],
    distance: &mut [f64],
) {
    let mut at = 0;
    for term in terms {
        let to =
            if matches!(term.acts, Acts::Drive | Acts::Slip) { &mut *distance } else { &mut *turn };
        let Some(exposed) = exposure(data.block, term.acts) else { continue };
        if data.columns(term).is_empty() {
            continue;
        }
        for column in term.per_row(data.channels).unwrap_or_default() {
            let coefficient = coefficients.get(at).copied().unwrap_or(0.0);
            at += 1;
            for ((total, value), per) in to.iter_mut().zip(&column).zip(&exposed.per_row) {
                *total += coefficient * value * per;
            }
        }
    }
}

/// As the contract writes it.
pub(crate) fn held_out(
    before: &Errors,
    after: &Errors,
    unit: (&str, f64),
    quantity: Option<&str>,
    seed: u64,
) -> HeldOut {
    let interval = after.interval(seed);
    HeldOut {
        metric: "rmse".to_owned(),
        quantity: quantity.map(str::to_owned),
        unit: unit.0.to_owned(),
        before: before.rmse() / unit.1,
        after: after.rmse() / unit.1,
        ci95: interval.map(|value| value / unit.1),
        folds: after.folds,
    }
}
