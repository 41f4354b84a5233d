//! Which of a series of errors are outliers: far from their neighbours, beyond what their own tail explains, few, and
//! unrelated to every input.

use crate::problem::runs;
use crate::robust::{self, median};
use crate::significance::surprise;

/// Neighbours on either side whose median an error is compared with.
pub(super) const REACH: usize = 5;
/// Minimum number of errors; fewer have no tail to judge by.
const ERRORS_MIN: usize = 60;
/// Minimum number of errors of a run for a spread of its own.
const RUN_ERRORS_MIN: usize = 40;
/// Smallest deviation of an outlier, over the spread of all.
const BEYOND_MIN: f64 = 6.0;
/// Number of errors of that size that the tail alone may be expected to have.
const EXPECTED_MAX: f64 = 0.01;
/// Maximum share of outliers; more of them are a property of the sensor.
const SHARE_MAX: f64 = 0.05;
/// Rounds in which the tail is judged without the outliers of the round before.
const ROUNDS: usize = 4;
/// Probability, over all inputs, below which outliers go with an input and are structure.
const GOES_WITH: f64 = 0.01;

/// Student's distribution by the ratio of its 95 % point to its median, both of absolute values: ratio, degrees of
/// freedom, median.
const TAILS: [(f64, f64, f64); 9] = [
    (2.991, 30.0, 0.6828),
    (3.083, 15.0, 0.6912),
    (3.184, 10.0, 0.6998),
    (3.326, 7.0, 0.7111),
    (3.538, 5.0, 0.7267),
    (3.748, 4.0, 0.7407),
    (4.160, 3.0, 0.7649),
    (5.270, 2.0, 0.8165),
    (12.706, 1.0, 1.0),
];

/// Name of an input, and its value at each error.
pub(super) type Input = (String, Vec<f64>);

/// Outliers among errors.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Apart {
    /// Indices of the outliers.
    pub at: Vec<usize>,
    /// Smallest deviation from the neighbours that counts, in the unit of the errors.
    pub limit: f64,
    /// Largest deviation found.
    pub largest: f64,
    /// Input that they go with: they are then no outliers.
    pub goes_with: Option<String>,
}

/// Outliers among `errors`, in the order of time, with the run of each. No difference below `step`, that of the readings,
/// and no deviation below that of `least` counts. `inputs` returns the inputs as they are without the outliers. `None` if
/// there are none.
pub(super) fn apart(
    errors: &[f64],
    run: &[usize],
    (step, least): (f64, &[f64]),
    inputs: impl FnOnce(&[usize]) -> Vec<Input>,
) -> Option<Apart> {
    if errors.len() < ERRORS_MIN {
        return None;
    }
    let away = from_neighbours(errors, run);
    let scale: Vec<f64> = scales(&away, run).iter().map(|scale| scale.max(step)).collect();
    let size: Vec<f64> = away.iter().zip(&scale).map(|(a, s)| a.abs() / s).collect();
    let beyond = beyond(&size)?;
    // A row beside a step is far from the middle of both sides, and not from its own side.
    let at: Vec<usize> = (0..size.len())
        .filter(|&i| size[i] > beyond && beside(errors, run, i) > beyond * scale[i])
        .filter(|&i| away[i].abs() >= least[i])
        .collect();
    if at.is_empty() || at.len() as f64 > SHARE_MAX * size.len() as f64 {
        return None;
    }
    let limit = beyond * robust::spread(&away).max(step);
    let largest = at.iter().map(|&i| away[i].abs()).fold(0.0, f64::max);
    let goes_with = gone_with(&at, &inputs(&at)).map(|(name, _)| name.clone());
    Some(Apart { at, limit, largest, goes_with })
}

/// Deviation of each error from those around it in its run: the least of those from the median of its neighbours on both
/// sides, and, near an end, from what the neighbours on one side lead to.
pub(super) fn from_neighbours(errors: &[f64], run: &[usize]) -> Vec<f64> {
    let mut found = vec![0.0; errors.len()];
    for range in runs(&run[..errors.len()]) {
        let own = &errors[range.clone()];
        for (i, away) in found[range].iter_mut().enumerate() {
            let reach = REACH.min(i).min(own.len() - 1 - i);
            let around: Vec<f64> =
                own[i - reach..i].iter().chain(&own[i + 1..=i + reach]).copied().collect();
            *away = if reach >= 2 {
                own[i] - median(around)
            } else {
                let side: Vec<f64> = match i < own.len() / 2 {
                    true => own[i + 1..].iter().take(REACH).copied().collect(),
                    false => own[..i].iter().rev().take(REACH).copied().collect(),
                };
                let [level, ahead] = lead(&side);
                let both = [own[i] - level, own[i] - ahead];
                if both[0].abs() < both[1].abs() { both[0] } else { both[1] }
            };
        }
    }
    found
}

/// Distance of an error from the median of the nearer of its two sides.
fn beside(errors: &[f64], run: &[usize], i: usize) -> f64 {
    let mine = |j: &usize| run[*j] == run[i];
    let before: Vec<f64> = (0..i).rev().take_while(mine).take(REACH).map(|j| errors[j]).collect();
    let after: Vec<f64> =
        (i + 1..errors.len()).take_while(mine).take(REACH).map(|j| errors[j]).collect();
    let away = |side: Vec<f64>| {
        if side.len() < 2 { f64::INFINITY } else { (errors[i] - median(side)).abs() }
    };
    away(before).min(away(after))
}

/// The median of the nearest values of one side, and where their course leads.
fn lead(side: &[f64]) -> [f64; 2] {
    if side.len() < 4 {
        return [median(side.to_vec()); 2];
    }
    let slopes = (0..side.len() - 1).map(|i| side[i] - side[i + 1]).collect();
    let middle = median(side.to_vec());
    [middle, middle + (side.len() + 1) as f64 / 2.0 * median(slopes)]
}

/// Spread of the run of each deviation, or of all where the run is short.
fn scales(away: &[f64], run: &[usize]) -> Vec<f64> {
    let all = robust::spread(away);
    let mut found = vec![all; away.len()];
    for range in runs(run).filter(|range| range.len() >= RUN_ERRORS_MIN) {
        found[range.clone()].fill(robust::spread(&away[range]));
    }
    found
}

/// Size from which the tail of the other sizes explains none.
fn beyond(size: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = size.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    let mut beyond = BEYOND_MIN;
    for _ in 0..ROUNDS {
        let rest = sorted.partition_point(|size| *size <= beyond);
        let quantile = |share: f64| sorted[((rest as f64 * share) as usize).min(n - 1)];
        let (middle, high) = (quantile(0.5), quantile(0.95));
        if !(middle > 0.0) {
            return None;
        }
        // A ratio of two quantiles is uncertain by this share of itself, in normal noise.
        let ratio = high / middle * (1.0 + 1.2 / (rest as f64).sqrt());
        let &(_, free, of_median) =
            TAILS.iter().find(|tail| tail.0 >= ratio).or_else(|| TAILS.last())?;
        let unit = middle / of_median;
        let needed = (n as f64 / EXPECTED_MAX).ln();
        // The least size that surprises enough, to one per cent.
        let mut next = BEYOND_MIN;
        while surprise((next / unit).powi(2), 1.0, free) < needed && next < sorted[n - 1] {
            next *= 1.01;
        }
        if next == beyond {
            break;
        }
        beyond = next;
    }
    Some(beyond)
}

/// The first input that these errors go with.
pub(super) fn gone_with<'a>(at: &[usize], inputs: &'a [Input]) -> Option<&'a Input> {
    // Neighbours have one cause, and their inputs are alike.
    let mut first = at.to_vec();
    first.dedup_by(|next, before| *next - *before <= REACH);
    inputs.iter().find(|(_, input)| go_with(&first, input, inputs.len()))
}

/// Whether an input is distributed otherwise at the outliers than elsewhere (Kolmogorov and Smirnov).
fn go_with(at: &[usize], input: &[f64], inputs: usize) -> bool {
    let mut all: Vec<f64> = input.to_vec();
    let mut mine: Vec<f64> = at.iter().map(|&i| input[i]).collect();
    all.sort_by(f64::total_cmp);
    mine.sort_by(f64::total_cmp);
    let (n, m) = (all.len() as f64, mine.len() as f64);
    let share = |sorted: &[f64], value: f64| {
        sorted.partition_point(|one| *one <= value) as f64 / sorted.len() as f64
    };
    let below = |sorted: &[f64], value: f64| {
        sorted.partition_point(|one| *one < value) as f64 / sorted.len() as f64
    };
    let largest = mine
        .iter()
        .flat_map(|&value| {
            [share(&mine, value) - share(&all, value), below(&all, value) - below(&mine, value)]
        })
        .fold(0.0_f64, f64::max);
    let root = (n * m / (n + m)).sqrt();
    let by = (root + 0.12 + 0.11 / root) * largest;
    // Of a few, it tells more that all of them lie at one end.
    let ends = [share(&all, mine[mine.len() - 1]), 1.0 - below(&all, mine[0])];
    let at_one_end = 2.0 * ends[0].min(ends[1]).powf(m);
    (2.0 * (-2.0 * by * by).exp()).min(at_one_end) < GOES_WITH / inputs as f64
}

#[cfg(test)]
mod tests {
    use super::{Apart, apart};
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal, StudentT};

    const N: usize = 3000;

    fn noise(seed: u64, mut of: impl FnMut(&mut chacha20::ChaCha8Rng) -> f64) -> Vec<f64> {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        (0..N).map(|_| of(&mut random)).collect()
    }

    fn found(errors: &[f64], inputs: &[Vec<f64>]) -> Vec<usize> {
        let inputs =
            |_: &[usize]| inputs.iter().map(|one| ("any".to_owned(), one.clone())).collect();
        let n = errors.len();
        let found = apart(errors, &vec![0; n], (0.0, &vec![0.0; n]), inputs);
        found.filter(|found| found.goes_with.is_none()).map_or_else(Vec::new, |found| found.at)
    }

    #[test]
    fn spikes_are_apart_and_tails_are_not() {
        let normal = |seed| noise(seed, |random| StandardNormal.sample(random));
        for seed in 1..20 {
            assert_eq!(found(&normal(seed), &[]), [0; 0]);
            let tail = StudentT::new(3.0).expect("degrees of freedom");
            let heavy = noise(seed, |random| tail.sample(random));
            assert!(found(&heavy, &[]).len() <= 1, "{:?}", found(&heavy, &[]));
            let mut wild = normal(seed);
            let at: Vec<usize> = (0..N).filter(|i| i % 97 == 5).collect();
            at.iter().for_each(|&i| wild[i] += if i % 2 == 0 { 25.0 } else { -40.0 });
            assert_eq!(found(&wild, &[]), at);
            // A drift and a start of the run change nothing.
            wild[0] += 30.0;
            let drifts: Vec<f64> =
                wild.iter().enumerate().map(|(i, one)| one + 0.5 * i as f64).collect();
            assert_eq!(found(&drifts, &[]).len(), at.len() + 1);
            // Neither do steps.
            let steps: Vec<f64> = normal(seed)
                .iter()
                .enumerate()
                .map(|(i, one)| one + 40.0 * (i / 90) as f64)
                .collect();
            assert_eq!(found(&steps, &[]), [0; 0]);
        }
    }

    #[test]
    fn what_goes_with_an_input_is_structure() {
        let input = noise(3, |random| random.random_range(-1.0..1.0));
        let mut errors = noise(4, |random| StandardNormal.sample(random));
        for (error, input) in errors.iter_mut().zip(&input) {
            *error += if *input > 0.98 { 30.0 } else { 0.0 };
        }
        assert!(found(&errors, &[]).len() > 20);
        assert!(found(&errors, std::slice::from_ref(&input)).is_empty());
    }

    #[test]
    fn a_step_of_the_readings_and_a_frequent_error_are_no_outliers() {
        let rare: Vec<f64> = (0..N).map(|i| if i % 83 == 0 { 0.1 } else { 0.0 }).collect();
        assert_eq!(apart(&rare, &vec![0; N], (0.1, &[0.0; N]), |_| Vec::new()), None);
        let mut often = noise(5, |random| StandardNormal.sample(random));
        (0..N).step_by(12).for_each(|i| often[i] += 50.0);
        assert_eq!(found(&often, &[]), [0; 0]);
        let mut wild = noise(6, |random| StandardNormal.sample(random));
        (0..N).step_by(100).for_each(|i| wild[i] += 20.0);
        let Apart { limit, largest, .. } =
            apart(&wild, &vec![0; N], (0.0, &[0.0; N]), |_| Vec::new()).expect("outliers");
        assert!(limit > 5.0 && limit < 8.0 && largest > 20.0, "{limit} {largest}");
    }
}
