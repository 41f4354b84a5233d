//! Folds of whole runs.

use std::ops::Range;

/// Maximum number of folds.
pub const FOLDS_MAX: usize = 5;
/// Gap on each side of a held-out stretch of data without runs, as a share of the stretch.
const BLOCK_GAP: f64 = 0.1;

/// The runs that a fold holds out, and the observations that it uses, over `runs` (the run of each observation).
#[derive(Debug, Clone)]
pub struct Fold {
    /// Held out.
    pub test: Vec<bool>,
    /// Used for the fit.
    pub train: Vec<bool>,
}

/// Folds that never split a run. A single run is split into stretches with gaps between them.
pub fn folds(runs: &[usize]) -> Vec<Fold> {
    let mut order: Vec<usize> = Vec::new();
    for &run in runs {
        if order.last() != Some(&run) && !order.contains(&run) {
            order.push(run);
        }
    }
    if order.len() >= 2 {
        let count = order.len().min(FOLDS_MAX);
        return (0..count)
            .map(|fold| {
                let held: Vec<bool> = {
                    let mut of_run = vec![false; order.iter().max().map_or(0, |last| last + 1)];
                    for (position, run) in order.iter().enumerate() {
                        of_run[*run] = position % count == fold;
                    }
                    runs.iter().map(|run| of_run[*run]).collect()
                };
                let train = held.iter().map(|held| !held).collect();
                Fold { test: held, train }
            })
            .collect();
    }
    let n = runs.len();
    // Two stretches a fold, so that each fold sees early and late rows.
    let stretches = 2 * FOLDS_MAX;
    let bounds = |i: usize| -> Range<usize> { i * n / stretches..(i + 1) * n / stretches };
    let gap = (BLOCK_GAP * n as f64 / stretches as f64) as usize;
    (0..FOLDS_MAX)
        .map(|fold| {
            let mut test = vec![false; n];
            let mut train = vec![true; n];
            for i in [fold, fold + FOLDS_MAX] {
                let range = bounds(i);
                test[range.clone()].fill(true);
                train[range.start.saturating_sub(gap)..(range.end + gap).min(n)].fill(false);
            }
            Fold { test, train }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::folds;

    #[test]
    fn a_run_is_held_out_whole_and_each_once() {
        let runs = [0, 0, 0, 1, 1, 2, 2, 3, 4, 5, 6, 6];
        let found = folds(&runs);
        assert_eq!(found.len(), 5);
        for row in 0..runs.len() {
            assert_eq!(found.iter().filter(|fold| fold.test[row]).count(), 1);
        }
        for fold in &found {
            for (a, b) in [(0, 2), (3, 4), (5, 6), (10, 11)] {
                assert_eq!(fold.test[a], fold.test[b]);
            }
        }
    }

    #[test]
    fn one_run_is_split_with_gaps() {
        let found = folds(&[0; 1000]);
        for fold in &found {
            let unused = fold.test.iter().zip(&fold.train).filter(|(t, u)| !**t && !**u).count();
            assert!(unused >= 10, "{unused}");
            assert!(fold.test.iter().zip(&fold.train).all(|(test, train)| !(*test && *train)));
        }
    }
}
