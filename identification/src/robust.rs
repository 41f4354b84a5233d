//! A few numbers for many: robust estimates, which a few outliers do not move, and sums over pairs, of which lines are made.

/// Median absolute value of normal noise over its standard deviation.
const MEDIAN_OF_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Share of the root mean square up to which a value is rounding of the arithmetic: 16 digits, less those that sums lose.
const ROUNDING: f64 = 1e-12;

/// Standard deviation of `values` about zero, from their median absolute value; where most of them are zero but for rounding, as
/// those of a reference that repeats what the wheels say, their root mean square.
pub fn spread(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    let found = *median / MEDIAN_OF_NORMAL;
    let all = root_mean_square(values);
    let is_rounding = all.is_finite() && found <= ROUNDING * all;
    if is_rounding { all } else { found }
}

/// The third difference of four readings, one after the other: it holds their noise, and little of any motion.
pub fn third_difference([a, b, c, d]: [f64; 4]) -> f64 {
    d - 3.0 * c + 3.0 * b - a
}

/// Variance of the white noise of a reading, from third differences: each holds 1 + 9 + 9 + 1 times that.
pub fn white_variance(third_differences: &[f64]) -> f64 {
    spread(third_differences).powi(2) / 20.0
}

/// The middle value; 0 without any.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    let upper = *values.select_nth_unstable_by(middle, f64::total_cmp).1;
    if values.len() % 2 == 1 {
        return upper;
    }
    let lower = values[..middle].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    f64::midpoint(lower, upper)
}

/// The least and the greatest value; infinite without any.
pub fn ends(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    values.into_iter().fold(none, |(low, high), value| (low.min(value), high.max(value)))
}

pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Standard deviations beyond which a value is gross: one in 150,000 of a normal distribution.
pub const GROSS: f64 = 4.5;

/// Number of standard deviations beyond which a residual counts no more than one at it (Huber's score). This costs
/// about one per cent of the information in normal noise.
pub const HUBER: f64 = 2.5;

/// Huber's scores of `values` with the spread `scale`.
pub fn scores(values: &[f64], scale: f64) -> Vec<f64> {
    let limit = HUBER * scale;
    values.iter().map(|value| held(*value, limit)).collect()
}

/// `value` within `limit` of zero. Values so large that their spread is no number have no limit.
pub fn held(value: f64, limit: f64) -> f64 {
    if value.abs() > limit { limit.copysign(value) } else { value }
}

/// Means of pairs, and sums of squares and products about them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) xx: f64,
    pub(crate) xy: f64,
    pub(crate) yy: f64,
}

impl Moments {
    pub(crate) fn of(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let n = pairs.clone().count().max(1) as f64;
        let (x, y) = pairs.clone().fold((0.0, 0.0), |(x, y), (a, b)| (x + a / n, y + b / n));
        let sums = Self { x, y, xx: 0.0, xy: 0.0, yy: 0.0 };
        pairs.fold(sums, |sums, (a, b)| Self {
            xx: sums.xx + (a - x).powi(2),
            xy: sums.xy + (a - x) * (b - y),
            yy: sums.yy + (b - y).powi(2),
            ..sums
        })
    }
}

/// Squared correlation of the rows in which both are known.
pub fn squared_correlation(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().copied().zip(b.iter().copied());
    let Moments { xx, xy, yy, .. } = Moments::of(pairs.filter(|(a, b)| (a + b).is_finite()));
    if xx > 0.0 && yy > 0.0 { xy * xy / (xx * yy) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{Moments, held, scores, spread};

    /// Found by the fuzzer: a bag with readings whose squares are beyond every number.
    #[test]
    fn what_is_beyond_the_limit_is_held_and_without_a_limit_nothing_is() {
        let values = [-9.0, -2.5, 0.5, 7.0];
        assert_eq!(scores(&values, 1.0), [-2.5, -2.5, 0.5, 2.5]);
        assert_eq!(scores(&values, f64::NAN), values);
        assert!(held(f64::NAN, 1.0).is_nan());
    }

    #[test]
    fn zeros_are_no_noise_even_if_they_are_rounded() {
        let values: Vec<f64> = (0..100).map(|i| if i % 5 < 3 { 1e-17 } else { 1e-3 }).collect();
        assert!((spread(&values) - 1e-3 * 0.4_f64.sqrt()).abs() < 1e-9);
        assert!((spread(&[1.0, -1.0, 1.0, -1.0, 1e6]) - 1.482_6).abs() < 1e-4);
    }

    #[test]
    fn a_line_is_made_of_them() {
        let pairs = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)];
        let Moments { x, y, xx, xy, yy } = Moments::of(pairs.into_iter());
        assert_eq!((x, y), (1.0, 3.0));
        assert_eq!((xy / xx, yy - xy * xy / xx), (2.0, 0.0));
        assert_eq!(Moments::of(std::iter::empty()).xx, 0.0);
    }
}
