//! Whether what a sensor reads is the course of something that moves. Slow noise of a sensor at rest wanders as well: but each of
//! its steps is as likely as another, and knows nothing of the step before.

use crate::problem::runs;
use crate::robust::{root_mean_square, spread, third_difference, white_variance};

/// Change of a step over the step itself, up to which a course is smooth: of independent steps it is 1.4 and more.
const SMOOTH: f64 = 0.7;
/// Size of all steps over that of most, from which they are jumps: of a Gaussian process it is 1, and 1.7 of white noise with tails
/// like those of Student's with three degrees of freedom.
const JUMPS: f64 = 3.0;
/// Minimum number of steps that are compared, and least number of them one after the other in the longest run.
const STEPS_MIN: usize = 30;
const LONGEST: usize = 32;

/// Rows apart from which the white noise of a row is taken off: of slow noise it is the step from row to row.
const NOISE_FROM: usize = 4;
/// Share of the squares that must be left then.
const LEFT_MIN: f64 = 0.5;

/// Whether `values`, of which those of a run belong together, move evenly or in jumps when they are compared over some time.
pub(super) fn is_course(values: &[f64], run_of_row: &[usize]) -> bool {
    let thirds: Vec<f64> = runs(run_of_row)
        .flat_map(|run| values[run].windows(4))
        .map(|four| third_difference([0, 1, 2, 3].map(|at| four[at])))
        .filter(|third| third.is_finite())
        .collect();
    let white = white_variance(&thirds);
    let longest = runs(run_of_row).map(|run| run.len()).max().unwrap_or(0);
    let mut lag = 1;
    while lag <= longest / LONGEST {
        let (mut steps, mut changes) = (Vec::new(), Vec::new());
        for run in runs(run_of_row) {
            for row in run.start + 2 * lag..run.end.max(run.start + 2 * lag) {
                let step = values[row] - values[row - lag];
                let change = step - (values[row - lag] - values[row - 2 * lag]);
                if change.is_finite() {
                    steps.push(step);
                    changes.push(change);
                }
            }
        }
        let size = root_mean_square(&steps);
        let white = if lag >= NOISE_FROM { white } else { 0.0 };
        let step = size.powi(2) - 2.0 * white;
        let change = root_mean_square(&changes).powi(2) - 6.0 * white;
        let is_smooth = step > LEFT_MIN * size.powi(2) && change < SMOOTH.powi(2) * step;
        if steps.len() >= STEPS_MIN && (is_smooth || size > JUMPS * spread(&steps)) {
            return true;
        }
        lag *= 2;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::is_course;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn waves_and_levels_are_a_course_and_noise_is_none() {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let run: Vec<usize> = (0..4000).map(|row| row / 1000).collect();
        let with_noise = |of: &dyn Fn(f64) -> f64, draw: &mut dyn FnMut() -> f64| -> Vec<f64> {
            (0..4000).map(|row| 40.0 * of(f64::from(row)) + draw()).collect()
        };
        let wave = with_noise(&|t| (t / 15.0).sin(), &mut draw);
        let levels = with_noise(&|t| (7.3 * (t / 60.0).floor()).sin(), &mut draw);
        assert!(is_course(&wave, &run) && is_course(&levels, &run));
        for keep in [0.0, 0.9, 0.99, 1.0] {
            let mut slow = 0.0;
            let noise: Vec<f64> = (0..4000)
                .map(|_| {
                    slow = keep * slow + draw();
                    slow
                })
                .collect();
            assert!(!is_course(&noise, &run), "{keep}");
        }
    }
}
