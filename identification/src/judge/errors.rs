//! Squared errors on held-out data, run by run, and the certainty of a difference between two models.

use rand::{RngExt, SeedableRng};

/// Draws of the bootstrap over runs.
const DRAWS: usize = 400;

/// Squared errors, run by run.
#[derive(Debug, Clone, Default)]
pub struct Errors {
    /// Index, sum of squared errors and their number, for each run that has any.
    pub runs: Vec<(usize, f64, f64)>,
    /// The fold that held each of them out.
    pub held_by: Vec<usize>,
    /// Number of folds.
    pub folds: usize,
}

impl Errors {
    /// Root of the mean square.
    pub fn rmse(&self) -> f64 {
        let (sum, count) = self.runs.iter().fold((0.0, 0.0), |(s, c), run| (s + run.1, c + run.2));
        if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
    }

    pub(crate) fn add(&mut self, run: usize, square: f64, fold: usize) {
        match self.runs.iter_mut().find(|(index, _, _)| *index == run) {
            Some((_, sum, count)) => {
                *sum += square;
                *count += 1.0;
            }
            None => {
                self.runs.push((run, square, 1.0));
                self.held_by.push(fold);
            }
        }
    }

    /// The runs that `fold` held out, or all others.
    pub fn part(&self, fold: usize, held_out: bool) -> Self {
        let mut part = Self { folds: self.folds, ..Self::default() };
        for (run, held_by) in self.runs.iter().zip(&self.held_by) {
            if (*held_by == fold) == held_out {
                part.runs.push(*run);
                part.held_by.push(*held_by);
            }
        }
        part
    }

    /// Adds the runs of `other`.
    pub fn join(&mut self, other: Self) {
        self.runs.extend(other.runs);
        self.held_by.extend(other.held_by);
        self.folds = other.folds;
    }

    pub fn mean_square(&self) -> f64 {
        self.rmse().powi(2)
    }

    /// Standard error of the mean square, with runs drawn at random.
    pub fn standard_error(&self) -> f64 {
        let runs = self.runs.iter().map(|run| (run.0, 0.0, run.2)).collect();
        let zero = Self { runs, ..Self::default() };
        self.beyond(&zero).1
    }

    /// Difference of the mean square to that of `other` over the same runs, and its standard error: that of a ratio of
    /// sums, by its linear part (Cochran 1977, section 2.11).
    pub fn beyond(&self, other: &Self) -> (f64, f64) {
        let pairs: Vec<(f64, f64)> = self
            .runs
            .iter()
            .filter_map(|run| {
                let same = other.runs.iter().find(|one| one.0 == run.0)?;
                Some((run.1 - same.1, run.2))
            })
            .collect();
        let n = pairs.len() as f64;
        let count: f64 = pairs.iter().map(|pair| pair.1).sum();
        if pairs.is_empty() || !(count > 0.0) {
            return (0.0, f64::INFINITY);
        }
        let mean = pairs.iter().map(|pair| pair.0).sum::<f64>() / count;
        if pairs.len() < 2 {
            return (mean, f64::INFINITY);
        }
        let square: f64 = pairs.iter().map(|pair| (pair.0 - mean * pair.1).powi(2)).sum();
        (mean, (square * n / (n - 1.0)).sqrt() / count)
    }

    /// Share of the runs in which the error is above that of `other`.
    pub fn share_above(&self, other: &Self) -> f64 {
        let above = self
            .runs
            .iter()
            .filter(|run| other.runs.iter().any(|one| one.0 == run.0 && run.1 > one.1));
        above.count() as f64 / self.runs.len().max(1) as f64
    }

    /// 95 % interval of the root mean square, from drawing runs with replacement.
    pub(crate) fn interval(&self, seed: u64) -> [f64; 2] {
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

#[cfg(test)]
mod tests {
    use super::Errors;

    fn errors(squares: &[f64]) -> Errors {
        let runs =
            squares.iter().enumerate().map(|(run, square)| (run, 2.0 * square, 2.0)).collect();
        Errors { runs, folds: 5, ..Errors::default() }
    }

    #[test]
    fn the_error_of_a_mean_is_the_usual_one_and_pairs_take_out_what_runs_share() {
        let rough = errors(&[1.0, 9.0, 4.0, 16.0]);
        let better = errors(&[0.9, 8.9, 3.9, 15.9]);
        // Mean 7.5, standard deviation of 1, 9, 4, 16 over the root of 4.
        assert!((rough.mean_square() - 7.5).abs() < 1e-12);
        assert!((rough.standard_error() - (129.0_f64 / 3.0 / 4.0).sqrt()).abs() < 1e-12);
        let (more, error) = rough.beyond(&better);
        assert!((more - 0.1).abs() < 1e-12 && error < 1e-12, "{more} {error}");
        assert_eq!(errors(&[1.0]).standard_error(), f64::INFINITY);
    }
}
