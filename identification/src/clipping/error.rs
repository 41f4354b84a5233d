//! The standard error of a limit: that of the mean of the readings at it, and that of the line that runs into it. Both hold noise that
//! may come after the limit and be slow: neighbours in time then err alike.

/// Maximum share of the readings over which they are compared with one another.
const LAGS_MAX: f64 = 0.1;

/// Standard error of a sum of readings, in order of time, that have these `weights` in it and are off by `errors`: those of weight
/// zero take no part. `run` is the run of each.
pub(super) fn of_sum(weights: &[f64], errors: &[f64], run: &[usize]) -> f64 {
    let n = errors.len();
    // Means of products of readings that lie so many rows apart.
    let apart = |values: &[f64], lag: usize, counts: bool| -> f64 {
        let pairs = (lag..n).filter(|&row| run[row] == run[row - lag]);
        let pairs = pairs.filter(|&row| weights[row] != 0.0 && weights[row - lag] != 0.0);
        let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), row| {
            (sum + values[row] * values[row - lag], count + 1.0)
        });
        if counts { sum / f64::max(count, 1.0) } else { sum }
    };
    let mut variance = apart(errors, 0, true) * apart(weights, 0, false);
    // As long as neighbours err alike (the initial positive sequence; Geyer 1992).
    for lag in 1..(LAGS_MAX * n as f64) as usize {
        let alike = apart(errors, lag, true);
        if !(alike > 0.0) {
            break;
        }
        variance += 2.0 * alike * apart(weights, lag, false);
    }
    variance.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::of_sum;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Of white noise the variance of a mean is that of a reading over their number; of noise that keeps 0.9 of itself it is
    /// (1 + 0.9) / (1 - 0.9) times as large.
    #[test]
    fn slow_noise_makes_a_mean_less_certain() {
        let mut random = chacha20::ChaCha8Rng::seed_from_u64(2);
        let n = 20_000;
        for (keep, times) in [(0.0, 1.0), (0.9, 19.0)] {
            let mut slow = 0.0;
            let errors: Vec<f64> = (0..n)
                .map(|_| {
                    let drawn: f64 = StandardNormal.sample(&mut random);
                    slow = keep * slow + f64::sqrt(1.0 - keep * keep) * drawn;
                    slow
                })
                .collect();
            let found = of_sum(&vec![1.0 / n as f64; n], &errors, &vec![0; n]);
            let expected = f64::sqrt(times / n as f64);
            assert!((found / expected - 1.0).abs() < 0.2, "{keep}: {found} {expected}");
        }
    }
}
