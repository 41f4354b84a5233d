//! Uncertainty of a figure of several values that may depend on one another.
//!
//! A drift is slow and affects neighbouring values alike, so an interval that assumes independent values would be far
//! too narrow. The values are therefore cut into blocks in time order, and the figure is formed again without each
//! block (H. R. Künsch, "The jackknife and the bootstrap for general stationary observations", Ann. Statist. 17, 1989).
//! Dependence over more than a block goes undetected.
//!
//! The scatter of a few blocks is itself uncertain. The standard uncertainty is multiplied by the ratio of Student's t
//! to the quantile of the normal distribution, so that the expanded one covers 95 % (JCGM 100:2008, G.3).

use std::ops::Range;

/// Assumption: few enough that a block is longer than most drifts, enough for a useful scatter.
const BLOCKS: usize = 8;

/// Whether values are grouped into blocks: each stands alone if their order is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Together {
    Alone,
    InTime,
}

/// The standard uncertainty of a figure of `count` values. `without` forms the figure without these values, or returns
/// `None` if the rest does not suffice. Zero for a single value.
pub(super) fn uncertainty(
    count: usize,
    together: Together,
    without: impl Fn(Range<usize>) -> Option<f64>,
) -> Option<f64> {
    let blocks = match together {
        Together::Alone => count,
        Together::InTime => count.min(BLOCKS),
    };
    if blocks < 2 {
        return Some(0.0);
    }
    let cut = |block: usize| block * count / blocks;
    let figures: Option<Vec<f64>> =
        (0..blocks).map(|block| without(cut(block)..cut(block + 1))).collect();
    let figures = figures?;
    let count = blocks as f64;
    let mean = figures.iter().sum::<f64>() / count;
    let squares = figures.iter().map(|figure| (figure - mean).powi(2)).sum::<f64>();
    Some((squares * (count - 1.0) / count).sqrt() * widening(blocks - 1))
}

/// The values except those in `left_out`.
pub(super) fn rest<T>(values: &[T], left_out: Range<usize>) -> impl Iterator<Item = &T> + Clone {
    values[..left_out.start].iter().chain(&values[left_out.end..])
}

/// Quantile of the normal distribution, two-sided 95 %.
const NORMAL: f64 = 1.959_964;

/// Ratio of Student's t at 95 % for this many degrees of freedom to the quantile of the normal distribution. One and
/// two are tabulated; from three on the expansion of R. A. Fisher and E. A. Cornish, 1960, is within 0.7 %.
pub(super) fn widening(freedom: usize) -> f64 {
    let z = NORMAL;
    let t = match freedom {
        0 | 1 => 12.706,
        2 => 4.303,
        _ => {
            let n = freedom as f64;
            let terms = [
                (z.powi(3) + z) / 4.0,
                (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
                (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
            ];
            z + terms[0] / n + terms[1] / n.powi(2) + terms[2] / n.powi(3)
        }
    };
    t / NORMAL
}

#[cfg(test)]
mod tests {
    use super::{NORMAL, Together, rest, uncertainty, widening};
    use proptest::prelude::*;

    fn mean<'a>(values: impl Iterator<Item = &'a f64> + Clone) -> Option<f64> {
        let count = values.clone().count();
        (count > 0).then(|| values.sum::<f64>() / count as f64)
    }

    fn of_mean(values: &[f64], together: Together) -> f64 {
        uncertainty(values.len(), together, |out| mean(rest(values, out))).unwrap()
    }

    #[test]
    fn student_is_that_of_the_tables() {
        // JCGM 100:2008, table G.2, 95 %.
        for (freedom, t) in
            [(1, 12.71), (2, 4.30), (3, 3.18), (4, 2.78), (7, 2.36), (10, 2.23), (40, 2.02)]
        {
            let found = widening(freedom) * NORMAL;
            assert!((found - t).abs() < 0.007 * t, "{freedom}: {found}");
        }
    }

    #[test]
    fn values_that_come_in_pairs_are_half_as_many() {
        let alone: Vec<f64> = (0..40).map(|i| f64::from(i * i % 41)).collect();
        let pairs: Vec<f64> = alone.iter().flat_map(|value| [*value; 10]).collect();
        let one = of_mean(&alone, Together::InTime);
        assert!((of_mean(&pairs, Together::InTime) / one - 1.0).abs() < 1e-9);
        assert!(of_mean(&pairs, Together::Alone) < 0.4 * one);
    }

    #[test]
    fn one_value_says_nothing_of_its_scatter() {
        assert_eq!(of_mean(&[3.0], Together::Alone), 0.0);
        assert_eq!(uncertainty(0, Together::InTime, |_| None), Some(0.0));
        assert_eq!(uncertainty(2, Together::InTime, |_| None), None);
    }

    proptest! {
        /// For the mean of independent values it is the textbook formula.
        #[test]
        fn a_mean_has_its_scatter_over_the_root(values in prop::collection::vec(-1e3f64..1e3, 2..60)) {
            let count = values.len() as f64;
            let centre = mean(values.iter()).unwrap();
            let scatter = values.iter().map(|value| (value - centre).powi(2)).sum::<f64>() / (count - 1.0);
            let expected = (scatter / count).sqrt() * widening(values.len() - 1);
            prop_assert!((of_mean(&values, Together::Alone) - expected).abs() <= 1e-9 * expected.max(1.0));
        }
    }
}
