//! Whether a residual may be called noise. Noise does not depend on the input: it is as large at rest as in motion, and
//! as large in a ramp as on a plateau.

use crate::finding::Left;
use crate::model::{Driver, Wrap};
use crate::robust;

/// Dependence of the residual's size on the size of an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Goes {
    /// Name of the input.
    pub with: String,
    /// Spread at large input over spread at small input.
    pub ratio: f64,
}

/// Noise that is this many times larger at one end of an input than at the other depends on it...
const RATIO_MIN: f64 = 1.5;
/// ...if the ranks of both agree by as many standard errors (one false alarm in ten thousand tests).
const DEVIATIONS_MIN: f64 = 4.0;
/// Maximum number of observations to rank.
const RANKED_MAX: usize = 6000;
/// Minimum number of observations.
const RANKED_MIN: usize = 60;
/// Share of the observations that count as one end of an input.
const END: f64 = 0.25;

/// The input on which the size of `white` depends most, if it depends on any. `white` is the innovation of each
/// observation, zero for one that does not count. Of an input, its magnitude at each.
pub fn goes_with(white: &[f64], inputs: &[(&str, Vec<f64>)]) -> Option<Goes> {
    let stride = white.len().div_ceil(RANKED_MAX).max(1);
    let at: Vec<usize> = (0..white.len()).step_by(stride).filter(|&i| white[i] != 0.0).collect();
    if at.len() < RANKED_MIN {
        return None;
    }
    let sizes = ranks(&at.iter().map(|&i| white[i].abs()).collect::<Vec<f64>>());
    let mut found: Option<Goes> = None;
    for (name, input) in inputs {
        let values: Vec<f64> = at.iter().map(|&i| input[i]).collect();
        let order = ranks(&values);
        let deviations = correlation(&sizes, &order) * (at.len() as f64 - 1.0).sqrt();
        let limit = |share: f64| (share * at.len() as f64) as usize;
        let mut sorted: Vec<usize> = (0..at.len()).collect();
        sorted.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
        let spread = |range: &[usize]| {
            robust::spread(&range.iter().map(|&k| white[at[k]]).collect::<Vec<f64>>())
        };
        let (low, high) = (spread(&sorted[..limit(END)]), spread(&sorted[limit(1.0 - END)..]));
        let ratio = high / low.max(f64::MIN_POSITIVE);
        if deviations > DEVIATIONS_MIN
            && ratio > RATIO_MIN
            && found.as_ref().is_none_or(|found| ratio > found.ratio)
        {
            found = Some(Goes { with: (*name).to_owned(), ratio });
        }
    }
    found
}

impl Goes {
    /// The dependence in the form of the contract.
    pub fn left(&self, label: &str) -> Left {
        let with = match Driver::parse(&self.with) {
            Some(Driver { wrap: Wrap::RateOf, field }) => format!("the rate of change of {field}"),
            _ => self.with.clone(),
        };
        Left {
            drivers: vec![format!("abs({})", self.with)],
            shape: format!(
                "what is left of {label} is {:.1} times as large where {with} is large, either way, as where it is \
                 small: no noise knows that",
                self.ratio
            ),
            share_of_residual_variance: 1.0 - self.ratio.powi(-2),
        }
    }
}

/// Ranks, ties sharing the middle one.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut from = 0;
    while from < order.len() {
        let mut to = from + 1;
        while to < order.len() && values[order[to]] == values[order[from]] {
            to += 1;
        }
        let middle = (from + to - 1) as f64 / 2.0;
        order[from..to].iter().for_each(|&i| ranks[i] = middle);
        from = to;
    }
    ranks
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        ab += (a - ma) * (b - mb);
        aa += (a - ma).powi(2);
        bb += (b - mb).powi(2);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::goes_with;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    #[test]
    fn noise_that_is_louder_in_motion_is_found_with_its_input() {
        let speed: Vec<f64> = (0..2000).map(|i| (f64::from(i) * 0.01).sin().abs()).collect();
        let other: Vec<f64> = (0..2000).map(|i| (f64::from(i) * 0.037).cos().abs()).collect();
        let loud: Vec<f64> =
            noise(2000, 3).iter().zip(&speed).map(|(e, v)| e * (0.3 + v)).collect();
        let inputs = [("other", other), ("speed", speed.clone())];
        let found = goes_with(&loud, &inputs).map(|goes| goes.with);
        assert_eq!(found.as_deref(), Some("speed"));
    }

    #[test]
    fn even_noise_and_heavy_tails_know_no_input() {
        let speed: Vec<f64> = (0..800).map(|i| (f64::from(i) * 0.01).sin().abs()).collect();
        let input = [("speed", speed.clone())];
        for seed in 0..200 {
            let even = noise(800, seed);
            let heavy: Vec<f64> = even.iter().map(|e| e * e * e).collect();
            assert_eq!(goes_with(&even, &input), None, "{seed}");
            assert_eq!(goes_with(&heavy, &input), None, "{seed}");
        }
    }
}
