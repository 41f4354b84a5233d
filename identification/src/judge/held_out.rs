//! Errors on whole runs that took no part in the fit.

use super::Errors;
use crate::fit::{Data, Fold, combine, folds, less};
use crate::linear::Normal;
use crate::model::{Shape, beside, exposure};
use crate::noise::{NoiseModel, Whitener};
use crate::problem::{Added, Aggregate, Component, Moves, Path};

/// Columns of the terms and the residual, whitened, as normal equations of stretches that the same folds use.
struct Equations {
    stretches: Vec<(Vec<bool>, Normal)>,
    width: usize,
}

impl Equations {
    /// `train` lists, for each fold, the observations that it uses.
    fn new(data: Data<'_>, columns: &[Vec<f64>], noise: &NoiseModel, train: &[Vec<bool>]) -> Self {
        let whitener = Whitener::new(data.layout, noise);
        let residual = whitener.apply(&data.block.residual);
        let columns = whitener.apply_all(columns);
        let uses = |i: usize| -> Vec<bool> { train.iter().map(|train| train[i]).collect() };
        let mut stretches: Vec<(Vec<bool>, Normal)> = Vec::new();
        let mut start = 0;
        for i in 1..=residual.len() {
            let ends = i == residual.len() || train.iter().any(|train| train[i] != train[i - 1]);
            if !ends {
                continue;
            }
            let mine = uses(start);
            let at = stretches.iter().position(|(uses, _)| *uses == mine).unwrap_or_else(|| {
                stretches.push((mine, Normal::new(columns.len())));
                stretches.len() - 1
            });
            stretches[at].1.add(&columns, &residual, start..i);
            start = i;
        }
        Self { stretches, width: columns.len() }
    }

    /// Coefficients from the observations that fold `number` uses.
    fn train(&self, number: usize) -> Vec<f64> {
        let mut all = Normal::new(self.width);
        for (_, normal) in self.stretches.iter().filter(|(uses, _)| uses[number]) {
            all.join(normal);
        }
        all.solve()
    }
}

/// How runs are held out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holding {
    /// Runs at regular intervals form a fold.
    Spread,
    /// Consecutive runs form a fold, since slow noise continues from one run to the next.
    Together,
}

/// Number of stretches that serve as clusters if consecutive runs are held out.
const STRETCHES: usize = 15;

impl Holding {
    /// The folds of observations in these runs, and the cluster of each observation.
    fn folds(self, run: &[usize]) -> (Vec<Fold>, Vec<usize>) {
        if self == Self::Spread {
            return (folds(run), run.to_vec());
        }
        let one = vec![0; run.len()];
        (folds(&one), (0..run.len()).map(|i| i * STRETCHES / run.len()).collect())
    }
}

impl Data<'_> {
    /// Coefficients of these columns without what each of `folds` holds out.
    fn train(&self, columns: &[Vec<f64>], folds: &[Fold], noise: &NoiseModel) -> Vec<Vec<f64>> {
        let train: Vec<Vec<bool>> = folds.iter().map(|fold| fold.train.clone()).collect();
        let white = Equations::new(*self, columns, noise, &train);
        (0..folds.len()).map(|fold| white.train(fold)).collect()
    }

    /// Squared innovations of held-out observations, with `terms`: the loss under the noise.
    pub(crate) fn innovations_held_out(&self, terms: &[Shape], noise: &NoiseModel) -> Errors {
        let white = self.whitened(terms, noise);
        let run = &self.layout.run;
        let alone = run.iter().all(|other| *other == run[0]);
        let trained = self.trained(terms, noise);
        let mut errors = Errors { folds: trained.len(), ..Errors::default() };
        for (number, (fold, coefficients)) in trained.iter().enumerate() {
            let left = white.left(coefficients);
            for i in (0..run.len()).filter(|&i| fold.test[i] && white.target[i] != 0.0) {
                errors.add(if alone { number } else { run[i] }, left[i].powi(2), number);
            }
        }
        errors
    }

    /// The folds, each with the coefficients of `terms` from the observations that it does not hold out.
    pub(crate) fn trained(&self, terms: &[Shape], noise: &NoiseModel) -> Vec<(Fold, Vec<f64>)> {
        let folds = folds(&self.layout.run);
        let coefficients = self.train(&self.all_columns(terms), &folds, noise);
        folds.into_iter().zip(coefficients).collect()
    }

    /// Errors of `terms` over held-out observations.
    pub(crate) fn held_out(&self, terms: &[Shape], noise: &NoiseModel, holding: Holding) -> Errors {
        let columns = self.all_columns(terms);
        let (folds, clusters) = holding.folds(&self.layout.run);
        let trained = self.train(&columns, &folds, noise);
        let mut errors = Errors { folds: folds.len(), ..Errors::default() };
        let run = &self.layout.run;
        let alone = clusters.iter().all(|other| *other == clusters[0]);
        for (number, (fold, coefficients)) in folds.iter().zip(&trained).enumerate() {
            // With a single run, each fold is its own cluster.
            let of = |i: usize| if alone { number } else { clusters[i] };
            let error = less(&self.block.residual, &combine(&columns, coefficients));
            let mut start = None;
            for i in 0..run.len() {
                if !fold.test[i] {
                    start = None;
                    continue;
                }
                if self.block.aggregate == Aggregate::Row {
                    errors.add(of(i), error[i].powi(2), number);
                    continue;
                }
                // A level counts from the start of its stretch.
                let component = self.block.pose.as_ref().map(|pose| pose.component[i]);
                if component.is_some_and(|component| component != Component::Heading) {
                    // With a single run, only the heading.
                    continue;
                }
                match start {
                    Some((from, first)) if from == run[i] => {
                        let first: f64 = first;
                        errors.add(of(i), (error[i] - first).powi(2), number);
                    }
                    _ => start = Some((run[i], error[i])),
                }
            }
        }
        errors
    }
}

/// Final position errors (m) and heading errors (rad) of dead reckoning over held-out runs; `None` if there is only one
/// run.
pub(crate) fn path_errors(
    path: &Path,
    data: Data<'_>,
    terms: &[Shape],
    noise: &NoiseModel,
) -> Option<(Errors, Errors)> {
    if path.runs.len() < 2 {
        return None;
    }
    let folds = folds(&data.channels.run);
    let (mut positions, mut headings) = (Errors::default(), Errors::default());
    (positions.folds, headings.folds) = (folds.len(), folds.len());
    let of_rows = |fold: &Fold| data.block.rows.iter().map(|&row| fold.train[row]).collect();
    let train: Vec<Vec<bool>> = folds.iter().map(of_rows).collect();
    let white = Equations::new(data, &data.all_columns(terms), noise, &train);
    for (number, fold) in folds.iter().enumerate() {
        let mut added = Added::nothing(data.channels.run.len());
        add_driven(data, terms, &white.train(number), &mut added);
        for (index, rows) in path.runs.iter().enumerate() {
            if fold.test[rows.clone()].iter().all(|test| *test)
                && let Some(error) = path.error(index, &added)
            {
                positions.add(index, error.position.powi(2), number);
                headings.add(index, error.heading.powi(2), number);
            }
        }
    }
    Some((positions, headings))
}

/// Adds the contribution of `terms` to each row.
pub(crate) fn add_driven(data: Data<'_>, terms: &[Shape], coefficients: &[f64], added: &mut Added) {
    let mut at = 0;
    for term in terms {
        let Some(exposed) = exposure(data.block, term.acts) else { continue };
        if data.columns(term).is_empty() {
            continue;
        }
        let also = beside(&term.name, (term.acts, term.form), data.block);
        let also = || also.iter().map(|(acts, per_row)| (*acts, per_row));
        for column in term.per_row(data.channels).unwrap_or_default() {
            let coefficient = coefficients.get(at).copied().unwrap_or(0.0);
            at += 1;
            for (acts, per_row) in std::iter::once((term.acts, &exposed.per_row)).chain(also()) {
                let to = added.of(Moves::of(acts));
                for ((total, value), per) in to.iter_mut().zip(&column).zip(per_row) {
                    *total += coefficient * value * per;
                }
            }
        }
    }
}
