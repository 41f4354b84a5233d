//! Confidence of a share: what k of n passed seeds say about all seeds.

use statrs::distribution::{Beta, ContinuousCDF as _};

/// Standard normal quantile of a two-sided 95 % interval.
pub const Z_95: f64 = 1.959_963_984_540_054;

/// An interval of shares, within 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
}

impl Interval {
    /// The ends in percent, to the first digit of the width, for instance `0.13 to 0.18 %`.
    pub fn percent(self) -> String {
        let Self { lower, upper } = self;
        let digits = -(100.0 * (upper - lower)).log10().floor();
        let digits = if digits.is_finite() { digits.clamp(0.0, 6.0) as usize } else { 0 };
        let end = |share: f64| match 100.0 * share {
            0.0 => "0".to_owned(),
            percent => format!("{percent:.digits$}"),
        };
        format!("{} to {} %", end(lower), end(upper))
    }
}

/// Wilson's score interval (Wilson 1927) for `successes` of `trials`, without continuity correction; `z` is the
/// standard normal quantile, for instance [`Z_95`]. `None` without trials, or with fewer trials than successes.
pub fn wilson(successes: u64, trials: u64, z: f64) -> Option<Interval> {
    if trials == 0 || successes > trials {
        return None;
    }
    let (n, share) = (trials as f64, successes as f64 / trials as f64);
    let z2 = z * z;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = z / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    // Rounding could put a share of 0 or 1 just outside its own interval.
    let lower = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
    let upper = if successes == trials { 1.0 } else { (centre + half).min(1.0) };
    Some(Interval { lower, upper })
}

/// The smallest number of trials, all successful, for which the interval of [`wilson`] reaches `share`; fewer can never
/// show it.
pub fn trials_min(share: f64, z: f64) -> u64 {
    let shows =
        |trials: &u64| wilson(*trials, *trials, z).is_some_and(|found| found.lower >= share);
    (1..=u64::from(u16::MAX)).find(shows).unwrap_or(u64::MAX)
}

/// Lower bound of a share at one-sided `confidence` (Clopper and Pearson 1934). It is exact: a share below it yields
/// `successes` of `trials` or more in at most 1 - `confidence` of all series. It also holds for a series that ends with
/// its last success. Zero without successes, and for invalid arguments.
pub fn clopper_pearson_lower(successes: u64, trials: u64, confidence: f64) -> f64 {
    if successes == 0 || successes > trials || !(confidence > 0.0 && confidence < 1.0) {
        return 0.0;
    }
    let (k, n) = (successes as f64, trials as f64);
    Beta::new(k, n - k + 1.0).map_or(0.0, |beta| beta.inverse_cdf(1.0 - confidence))
}

#[cfg(test)]
mod tests {
    use super::{Z_95, clopper_pearson_lower, wilson};
    use proptest::prelude::*;

    #[test]
    fn an_interval_of_a_hundred_thousand_trials_has_the_digits_that_it_needs() {
        let percent = |k, n| wilson(k, n, Z_95).unwrap().percent();
        assert_eq!(percent(154, 100_000), "0.13 to 0.18 %");
        assert_eq!(percent(0, 100_000), "0 to 0.004 %");
        assert_eq!(percent(0, 9), "0 to 30 %");
        assert_eq!(percent(100, 100), "96 to 100 %");
        assert_eq!(super::Interval { lower: 0.5, upper: 0.5 }.percent(), "50 to 50 %");
    }

    #[test]
    fn published_values() {
        // Newcombe 1998, table I, method 3: 81/263, 15/148, 0/20, 1/29.
        for (k, n, lower, upper) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let interval = wilson(k, n, Z_95).unwrap();
            assert!((interval.lower - lower).abs() < 5e-5, "{k}/{n}: {interval:?}");
            assert!((interval.upper - upper).abs() < 5e-5, "{k}/{n}: {interval:?}");
        }
    }

    /// The probability of `k` of `n` or more, by summation.
    fn tail(k: u64, n: u64, share: f64) -> f64 {
        let term = |i: u64| {
            let ways: f64 = (0..i).map(|j| (n - j) as f64 / (i - j) as f64).product();
            ways * share.powi(i as i32) * (1.0 - share).powi((n - i) as i32)
        };
        (k..=n).map(term).sum()
    }

    #[test]
    fn the_exact_bound_is_that_at_which_the_tail_is_what_confidence_leaves() {
        for (k, n, confidence) in [(7, 8, 0.95), (8, 8, 0.95), (1, 5, 0.9), (30, 40, 0.99)] {
            let lower = clopper_pearson_lower(k, n, confidence);
            assert!((tail(k, n, lower) - (1.0 - confidence)).abs() < 1e-6, "{k}/{n}: {lower}");
        }
        // For n of n: the n-th root of 1 - confidence.
        assert!((clopper_pearson_lower(5, 5, 0.95) - 0.05f64.powf(0.2)).abs() < 1e-6);
        assert!((clopper_pearson_lower(7, 8, 0.95) - 0.529_321).abs() < 1e-5);
        for (k, n, confidence) in [(0, 8, 0.95), (9, 8, 0.95), (0, 0, 0.95), (8, 8, 1.0)] {
            assert_eq!(clopper_pearson_lower(k, n, confidence), 0.0);
        }
    }

    #[test]
    fn no_trials_say_nothing() {
        assert_eq!(wilson(0, 0, Z_95), None);
        assert_eq!(wilson(2, 1, Z_95), None);
    }

    proptest! {
        #[test]
        fn the_share_is_inside_and_failures_mirror_successes(n in 1u64..10_000, part in 0.0f64..=1.0) {
            let k = (n as f64 * part) as u64;
            let interval = wilson(k, n, Z_95).unwrap();
            let share = k as f64 / n as f64;
            prop_assert!(0.0 <= interval.lower && interval.lower <= share);
            prop_assert!(share <= interval.upper && interval.upper <= 1.0);
            let mirrored = wilson(n - k, n, Z_95).unwrap();
            prop_assert!((interval.lower - (1.0 - mirrored.upper)).abs() < 1e-12);
        }
    }

    #[test]
    fn so_few_can_show_nothing() {
        assert_eq!(super::trials_min(0.9, super::Z_95), 35);
        assert_eq!(super::trials_min(0.95, super::Z_95), 73);
    }
}
