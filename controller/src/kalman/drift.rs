//! A first-order Gauss-Markov process of unit variance, over a step of any length.

/// What is known of the process over one step: at its end, and on the mean over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drift {
    /// The value at the end, as a share of that at the beginning.
    pub(super) left: f64,
    /// The mean over the step, as a share of the value at the beginning.
    pub(super) mean: f64,
    /// Variance of the mean, for a known value at the beginning.
    pub(super) mean_variance: f64,
}

impl Drift {
    /// Over `passed` time constants.
    pub(super) fn over(passed: f64) -> Self {
        if passed <= 0.0 {
            return Self { left: 1.0, mean: 1.0, mean_variance: 0.0 };
        }
        let lost = -libm::expm1(-passed);
        let mean = lost / passed;
        let mean_variance = if passed < 0.01 {
            // The difference below would be lost in rounding.
            passed * (2.0 / 3.0 - passed / 2.0)
        } else {
            2.0 * (1.0 - mean) / passed - mean * mean
        };
        Self { left: 1.0 - lost, mean, mean_variance }
    }

    /// Variance of the value at the end, for a known value at the beginning.
    pub(super) fn variance(&self) -> f64 {
        1.0 - self.left * self.left
    }

    /// Covariance of the mean and the value at the end, for a known value at the beginning.
    pub(super) fn covariance(&self) -> f64 {
        self.mean * (1.0 - self.left)
    }

    /// Variance of the mean minus the value at the end.
    pub(super) fn mean_from_end(&self) -> f64 {
        self.mean_variance + (1.0 - self.mean) * (1.0 - self.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::Drift;

    /// One step is the same as many short ones.
    #[test]
    fn a_long_step_is_many_short_ones() {
        for passed in [1e-4, 0.005, 0.02, 0.3, 3.0] {
            let (n, long) = (1_000, Drift::over(passed));
            let short = Drift::over(passed / f64::from(n));
            // The value, the sum of the means, their variances and their covariance.
            let (mut left, mut mean) = (1.0, 0.0);
            let (mut variance, mut sum_variance, mut covariance) = (0.0, 0.0, 0.0);
            for _ in 0..n {
                mean += left * short.mean;
                sum_variance += 2.0 * short.mean * covariance
                    + short.mean * short.mean * variance
                    + short.mean_variance;
                covariance = short.left * (covariance + short.mean * variance) + short.covariance();
                variance = short.left * short.left * variance + short.variance();
                left *= short.left;
            }
            let n = f64::from(n);
            for (one, other) in [
                (long.left, left),
                (long.mean, mean / n),
                (long.mean_variance, sum_variance / n / n),
                (long.variance(), variance),
                (long.covariance(), covariance / n),
            ] {
                assert!((one / other - 1.0).abs() < 1e-3, "{passed}: {one} {other}");
            }
        }
    }
}
