//! Tests whether a residual is white, apart from the memory that the noise model declares.
//!
//! A portmanteau test of the innovations, after Ljung and Box (1978): products of observations a lag apart, summed over
//! the lags of each octave so that a weak memory over a long time shows too. Each sum is scaled by the observed scatter
//! of its own products (as in Lobato, Nankervis and Savin 2001: noise that is louder at times is not memory). Only a
//! positive memory counts: fitting a model to the same data leaves a slightly negative one.

use crate::finding::{Left, p_value};
use crate::fit::Data;
use crate::problem::{Aggregate, runs};
use crate::significance::normal_above;
use std::ops::Range;

/// Probability that white noise fails the test, over all quantities of a data set together.
pub const WHITENESS_LEVEL: f64 = 0.01;
/// The longest lag, as a share of the observations: sums over fewer stretches are not normal (assumption, measured on
/// white noise by the tests of this module).
const LAG_SHARE: f64 = 1.0 / 40.0;
/// Minimum number of observations for the test (assumption).
const OBSERVATIONS_MIN: usize = 20;
/// Words that name a memory.
const CORRELATED: &str = "correlated over";

/// Result of the test on an observed quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Whiteness {
    /// Probability that white noise shows as much memory, corrected for the number of octaves.
    pub p_value: f64,
    /// Longest lag tested, in observations.
    pub lag_max: usize,
    /// Upper end of the octave of lags with the clearest memory, in observations.
    pub lag: usize,
    /// Mean correlation over that octave: the share of the variance with a memory of that length.
    pub correlation: f64,
}

/// Ranges of consecutive observations: within a stretch of time and, for a path, one component.
pub(crate) fn stretches(data: Data<'_>) -> Vec<Range<usize>> {
    let block = data.block;
    let segment_of = data.channels.segment_of_rows();
    let key = |i: usize| {
        let component = block.pose.as_ref().map(|pose| pose.component[i] as usize);
        // A level restarts in each run.
        let run = (block.aggregate != Aggregate::Row).then(|| data.layout.run[i]);
        (segment_of[block.rows[i]], component, run)
    };
    runs(&(0..block.rows.len()).map(key).collect::<Vec<_>>()).collect()
}

pub(crate) fn of_innovations(innovations: &[f64], stretches: &[Range<usize>]) -> Option<Whiteness> {
    let used = innovations.iter().filter(|value| **value != 0.0).count();
    let longest = stretches.iter().map(ExactSizeIterator::len).max().unwrap_or(0);
    let lag_max = ((used as f64 * LAG_SHARE) as usize).max(1).min(longest.saturating_sub(1));
    if used < OBSERVATIONS_MIN || lag_max == 0 {
        return None;
    }
    let square = innovations.iter().map(|value| value * value).sum::<f64>() / used as f64;
    let mut clearest: Option<(f64, Whiteness)> = None;
    let mut octaves = 0.0;
    let (mut above, mut lag) = (0, 1);
    while lag <= lag_max {
        let sums = Sums::of(innovations, stretches, above, lag);
        (above, lag) = (lag, 2 * lag);
        if !(sums.squares > 0.0) {
            continue;
        }
        octaves += 1.0;
        let deviations = sums.products / sums.squares.sqrt();
        if clearest.is_none_or(|(most, _)| deviations > most) {
            let correlation = (sums.products / sums.pairs / square).clamp(0.0, 1.0);
            clearest =
                Some((deviations, Whiteness { p_value: 1.0, lag_max, lag: above, correlation }));
        }
    }
    let (deviations, found) = clearest?;
    Some(Whiteness { p_value: (octaves * normal_above(deviations)).min(1.0), ..found })
}

/// Sums over pairs of observations that are more than `above` and at most `up_to` apart.
struct Sums {
    products: f64,
    /// Sum of squared products: its variance without memory.
    squares: f64,
    pairs: f64,
}

impl Sums {
    fn of(values: &[f64], stretches: &[Range<usize>], above: usize, up_to: usize) -> Self {
        let mut sums = Self { products: 0.0, squares: 0.0, pairs: 0.0 };
        for stretch in stretches {
            let values = &values[stretch.clone()];
            // Sums over the values within reach of the current one, and over their squares.
            let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
            for i in above + 1..values.len() {
                let enters = values[i - above - 1];
                sum += enters;
                square += enters * enters;
                count += f64::from(u8::from(enters != 0.0));
                if i > up_to {
                    let leaves = values[i - up_to - 1];
                    sum -= leaves;
                    square -= leaves * leaves;
                    count -= f64::from(u8::from(leaves != 0.0));
                }
                if values[i] != 0.0 {
                    sums.products += values[i] * sum;
                    sums.squares += values[i] * values[i] * square.max(0.0);
                    sums.pairs += count;
                }
            }
        }
        sums
    }
}

impl Whiteness {
    /// Whether it is white at [`WHITENESS_LEVEL`], as one of that many `quantities`.
    pub fn is_white(&self, quantities: usize) -> bool {
        self.p_value * quantities.max(1) as f64 >= WHITENESS_LEVEL
    }

    /// The memory in the form of the contract; with several `quantities`, it names this one.
    pub(crate) fn left(&self, data: Data<'_>, quantities: usize) -> Left {
        let of = if quantities > 1 { format!(" in {}", data.block.label) } else { String::new() };
        Left {
            drivers: vec![data.channels.time_name.clone()],
            shape: format!("{CORRELATED} {}{of}", self.duration(data, self.lag)),
            share_of_residual_variance: self.correlation,
        }
    }

    /// The result in words.
    pub(crate) fn notice(&self, data: Data<'_>, quantities: usize) -> String {
        // Each quantity has its share of the level.
        let level = (1e5 * WHITENESS_LEVEL / quantities.max(1) as f64).round() / 1e3;
        let label = &data.block.label;
        let is = if self.is_white(quantities) { "is white" } else { "is not white" };
        format!(
            "what is left of `{label}`, less the memory of its noise, {is} at the level of {level} % ({}, \
             lags of up to {})",
            p_value(self.p_value),
            self.duration(data, self.lag_max)
        )
    }

    /// That many observations as a time, with two significant digits.
    fn duration(&self, data: Data<'_>, lag: usize) -> String {
        let time = lag as f64 * data.layout.interval();
        let unit = data.channels.time_unit.text();
        if unit == "1" {
            return format!("{time:.0} rows");
        }
        let digit = 10_f64.powf(time.abs().log10().floor() - 1.0);
        let rounded = (time / digit).round() * digit;
        let places = (-digit.log10()).max(0.0) as usize;
        format!("{rounded:.places$} {unit}")
    }
}

impl Left {
    /// Whether this is a memory of the residual that no noise model declares, and not a cause that was tried.
    pub fn is_memory(&self) -> bool {
        self.shape.starts_with(CORRELATED)
    }
}

#[cfg(test)]
mod tests {
    use super::{WHITENESS_LEVEL, of_innovations};
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use std::slice::from_ref;

    const TRIALS: usize = 1500;

    fn noise(random: &mut chacha20::ChaCha8Rng, n: usize) -> Vec<f64> {
        (0..n).map(|_| StandardNormal.sample(random)).collect()
    }

    /// Number of trials that are taken for a memory.
    fn alarms(n: usize, runs: usize, shape: impl Fn(&mut chacha20::ChaCha8Rng, &mut [f64])) -> f64 {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(7);
        let stretches: Vec<_> = (0..runs).map(|run| run * n / runs..(run + 1) * n / runs).collect();
        let mut found = 0;
        for _ in 0..TRIALS {
            let mut values = noise(&mut random, n);
            shape(&mut random, &mut values);
            let whiteness = of_innovations(&values, &stretches).unwrap();
            found += usize::from(!whiteness.is_white(1));
        }
        found as f64 / TRIALS as f64
    }

    /// At the level of 1 %, 1500 trials give 15 +- 4 alarms: 30 are practically impossible.
    #[test]
    fn white_noise_is_white_at_the_level() {
        let plain = |_: &mut chacha20::ChaCha8Rng, _: &mut [f64]| {};
        let louder = |_: &mut chacha20::ChaCha8Rng, values: &mut [f64]| {
            for (i, value) in values.iter_mut().enumerate() {
                *value *= if i % 97 < 20 { 3.0 } else { 1.0 };
            }
        };
        let outliers = |random: &mut chacha20::ChaCha8Rng, values: &mut [f64]| {
            for value in values.iter_mut() {
                *value *= if random.random_bool(0.02) { 6.0 } else { 1.0 };
            }
        };
        for (n, runs) in [(40, 1), (300, 150), (900, 1), (2000, 4)] {
            for alarms in
                [alarms(n, runs, plain), alarms(n, runs, louder), alarms(n, runs, outliers)]
            {
                assert!(alarms < 2.0 * WHITENESS_LEVEL, "{n} in {runs}: {alarms}");
            }
        }
    }

    /// A memory of a third of the variance over 20 observations, and where it is found.
    #[test]
    fn a_memory_is_found_with_its_length() {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(3);
        let n = 2000;
        let (fresh, driving) = (noise(&mut random, n), noise(&mut random, n));
        let keep = (-1.0_f64 / 20.0).exp();
        let mut slow = 0.0;
        let values: Vec<f64> = fresh
            .iter()
            .zip(&driving)
            .map(|(fresh, driving)| {
                slow = keep * slow + (1.0 - keep * keep).sqrt() * driving;
                fresh + 0.7 * slow
            })
            .collect();
        let found = of_innovations(&values, from_ref(&(0..n))).unwrap();
        assert!(found.p_value < 1e-6, "{found:?}");
        assert!((8..=32).contains(&found.lag), "{found:?}");
        assert!((0.1..0.4).contains(&found.correlation), "{found:?}");
        // There is no memory across a break in time.
        let pairs: Vec<_> = (0..n / 2).map(|pair| 2 * pair..2 * pair + 2).collect();
        assert_eq!(of_innovations(&values, &pairs).unwrap().lag_max, 1);
    }

    #[test]
    fn too_few_observations_say_nothing() {
        assert_eq!(of_innovations(&[1.0, -1.0, 1.0], from_ref(&(0..3))), None);
        assert_eq!(of_innovations(&[0.0; 50], from_ref(&(0..50))), None);
        let alone: Vec<_> = (0..50).map(|i| i..i + 1).collect();
        assert_eq!(of_innovations(&[1.0; 50], &alone), None);
    }
}
