//! How uncertain a figure of several values is, where they may depend on one another.
//!
//! A drift is slow: what it does to one value it does to the next as well, and values that were taken for independent would
//! state an interval that is too narrow by far. So the values are cut into blocks in the order of time, and the figure is
//! formed again without each block (H. R. Künsch, "The jackknife and the bootstrap for general stationary observations", Ann.
//! Statist. 17, 1989). What lasts longer than a block is not seen.
//!
//! The scatter of a few blocks is itself uncertain. The standard uncertainty is widened by Student's t over that of the normal
//! distribution, so that the expanded one covers 95 % (JCGM 100:2008, G.3).

use std::ops::Range;

/// Assumption: few enough that a block is longer than most of what drifts, enough that their scatter is a measure.
const BLOCKS: usize = 8;

/// How many values go together: alone where nobody knows in which order they were.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Together {
    Alone,
    InTime,
}

/// The standard uncertainty of a figure of `count` values. `without` forms it from all but these; `None` of a part of which it
/// cannot be formed. Nothing for a single value.
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

/// The values but those in `left_out`.
pub(super) fn rest<T>(values: &[T], left_out: Range<usize>) -> impl Iterator<Item = &T> + Clone {
    values[..left_out.start].iter().chain(&values[left_out.end..])
}

/// Of the normal distribution, two-sided 95 %.
const NORMAL: f64 = 1.959_964;

/// Student's t of 95 % for this many degrees of freedom, over that of the normal distribution. One and two have closed forms;
/// from three on R. A. Fisher and E. A. Cornish's expansion of 1960 is within 0.7 %.
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
        /// Of a mean of values by themselves it is the textbook's.
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
