//! Probabilities far out in the tails, as natural logarithms.

use statrs::function::gamma::ln_gamma;

/// `-ln P(F > f)` for Fisher's distribution with `k` and `m` degrees of freedom: the surprise, in nats.
pub fn surprise(f: f64, k: f64, m: f64) -> f64 {
    if !(f > 0.0) || m < 1.0 {
        return 0.0;
    }
    // P(F > f) = I_x(m/2, k/2) with x = m / (m + k f).
    let x = m / (m + k * f);
    -ln_incomplete_beta(m / 2.0, k / 2.0, x)
}

/// `ln I_x(a, b)`, the regularised incomplete beta function, by its continued fraction (Lentz).
fn ln_incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if x >= 1.0 {
        return 0.0;
    }
    let front = ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p();
    if x < (a + 1.0) / (a + b + 2.0) {
        front + fraction(a, b, x).ln() - a.ln()
    } else {
        let other = (front + fraction(b, a, 1.0 - x).ln() - b.ln()).exp();
        (-other.min(1.0 - 1e-16)).ln_1p()
    }
}

fn fraction(a: f64, b: f64, x: f64) -> f64 {
    const TERMS: usize = 400;
    const TINY: f64 = 1e-300;
    let keep = |value: f64| if value.abs() < TINY { TINY } else { value };
    let (mut c, mut d) = (1.0, 1.0 / keep(1.0 - (a + b) * x / (a + 1.0)));
    let mut h = d;
    for term in 1..=TERMS {
        let m = term as f64;
        for numerator in [
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        ] {
            d = 1.0 / keep(1.0 + numerator * d);
            c = keep(1.0 + numerator / c);
            h *= d * c;
        }
        if (d * c - 1.0).abs() < 1e-14 {
            break;
        }
    }
    h
}

/// Surprise at a statistic that is chi-squared with `k` degrees of freedom.
pub fn surprise_chi2(statistic: f64, k: f64) -> f64 {
    // Fisher's distribution with many degrees of freedom below.
    surprise(statistic / k, k, 1e7)
}

/// Probability that a standard normal value is above `deviations`.
pub fn normal_above(deviations: f64) -> f64 {
    0.5 * statrs::function::erf::erfc(deviations * std::f64::consts::FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::{surprise, surprise_chi2};
    use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

    #[test]
    fn near_the_middle_it_is_the_usual_probability() {
        for (f, k, m) in [(0.5, 1.0, 20.0), (4.0, 3.0, 50.0), (9.0, 1.0, 300.0), (2.0, 8.0, 5000.0)]
        {
            let exact = -FisherSnedecor::new(k, m).unwrap().sf(f).ln();
            assert!((surprise(f, k, m) - exact).abs() < 1e-6, "{f} {k} {m}");
        }
        let exact = -ChiSquared::new(2.0).unwrap().sf(30.0).ln();
        assert!((surprise_chi2(30.0, 2.0) - exact).abs() < 1e-3);
    }

    #[test]
    fn far_out_it_goes_on() {
        // chi2 with one degree of freedom: about D/2 + ln(D pi / 2) / 2.
        let d: f64 = 4000.0;
        let expected = d / 2.0 + (d * std::f64::consts::PI / 2.0).ln() / 2.0;
        assert!((surprise(d, 1.0, 1e9) - expected).abs() < 0.1);
    }
}
