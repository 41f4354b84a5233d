//! The probability that data at a given distance refuse the wrong cause.

use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Chi-squared quantile at which a rival is refused: once in 200 times by chance, as in the search for rivals.
const REFUSED_AT: f64 = 0.995;

/// Probability that a rival at the distance `lambda` is refused by a cause of `width` columns: the non-central
/// chi-squared distribution in Sankaran's normal approximation (Biometrika 50, 1963).
pub(super) fn probability(lambda: f64, width: usize) -> f64 {
    let k = width.max(1) as f64;
    let lambda = lambda.max(0.0);
    let Ok(limit) = ChiSquared::new(k).map(|law| law.inverse_cdf(REFUSED_AT)) else {
        return 0.0;
    };
    let h = 1.0 - 2.0 * (k + lambda) * (k + 3.0 * lambda) / (3.0 * (k + 2.0 * lambda).powi(2));
    let p = (k + 2.0 * lambda) / (k + lambda).powi(2);
    let m = (h - 1.0) * (1.0 - 3.0 * h);
    let above = (limit / (k + lambda)).powf(h) - 1.0 - h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p);
    let score = above / (h * (2.0 * p).sqrt() * (1.0 + 0.5 * m * p));
    1.0 - Normal::standard().cdf(score)
}

#[cfg(test)]
mod tests {
    use super::probability;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn with_one_column_it_is_that_of_a_shifted_normal() {
        let normal = Normal::standard();
        let limit = normal.inverse_cdf(1.0 - 0.0025);
        for lambda in [0.0, 1.0, 5.0, 20.0, 60.0_f64] {
            let shift = lambda.sqrt();
            let exact = normal.cdf(shift - limit) + normal.cdf(-shift - limit);
            assert!((probability(lambda, 1) - exact).abs() < 0.01, "{lambda}: {exact}");
        }
    }

    #[test]
    fn it_grows_with_the_distance_and_falls_with_the_width() {
        assert!(
            (1..200)
                .all(|i| probability(f64::from(i), 2) > probability(f64::from(i - 1), 2) - 1e-9)
        );
        assert!(probability(15.0, 5) < probability(15.0, 1));
    }
}
