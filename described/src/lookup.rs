//! Look-up tables: values between points, in one dimension or two.

use described_file::Outside;

/// Points along one axis or two, linear between them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lookup {
    /// Increasing, two or more.
    x: Box<[f64]>,
    /// Likewise for the second axis; empty in one dimension.
    y: Box<[f64]>,
    /// One per point; in two dimensions all of the second axis for the first `x`, then for the next.
    values: Box<[f64]>,
    outside: Outside,
}

impl Lookup {
    /// The caller guarantees that both axes increase, and that there is a value for each point.
    pub(crate) fn new(x: Vec<f64>, y: Vec<f64>, values: Vec<f64>, outside: Outside) -> Self {
        Self { x: x.into(), y: y.into(), values: values.into(), outside }
    }

    pub(crate) const fn dimensions(&self) -> usize {
        if self.y.is_empty() { 1 } else { 2 }
    }

    /// The value at `x`, and at `y` for a second axis; NaN for NaN.
    pub(crate) fn value(&self, x: f64, y: f64) -> f64 {
        let (row, along) = place(&self.x, x, self.outside);
        if self.y.is_empty() {
            return between(self.at(row), self.at(row + 1), along);
        }
        let (column, across) = place(&self.y, y, self.outside);
        let of_row = |row: usize| {
            let first = row * self.y.len() + column;
            between(self.at(first), self.at(first + 1), across)
        };
        between(of_row(row), of_row(row + 1), along)
    }

    fn at(&self, index: usize) -> f64 {
        self.values.get(index).copied().unwrap_or(f64::NAN)
    }
}

/// The interval of an axis used for `x`, and the position in it, from 0 to 1 within the axis.
fn place(axis: &[f64], x: f64, outside: Outside) -> (usize, f64) {
    let behind = axis.partition_point(|at| *at <= x);
    let interval = behind.saturating_sub(1).min(axis.len().saturating_sub(2));
    let (Some(low), Some(high)) = (axis.get(interval), axis.get(interval + 1)) else {
        return (0, f64::NAN);
    };
    let share = (x - low) / (high - low);
    match outside {
        Outside::Clamp => (interval, share.clamp(0.0, 1.0)),
        Outside::Extrapolate => (interval, share),
    }
}

/// Exact at both ends, unlike `a + (b - a) * share`.
fn between(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

#[cfg(test)]
mod tests {
    use super::{Lookup, Outside};
    use proptest::prelude::*;

    /// By the definition: the first interval whose end is not below `x`.
    fn naive(points: &[(f64, f64)], x: f64, outside: Outside) -> f64 {
        let (first, last) = (points[0], points[points.len() - 1]);
        let line = |a: (f64, f64), b: (f64, f64)| a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0);
        match outside {
            Outside::Clamp if x <= first.0 => return first.1,
            Outside::Clamp if x >= last.0 => return last.1,
            _ => {}
        }
        let pair = points.windows(2).find(|pair| x <= pair[1].0);
        let pair = pair.unwrap_or(&points[points.len() - 2..]);
        line(pair[0], pair[1])
    }

    fn points() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((0.01f64..10.0, -100.0f64..100.0), 2..12).prop_map(|steps| {
            let mut x = -20.0;
            let mut point = |(step, y): (f64, f64)| {
                x += step;
                (x, y)
            };
            steps.into_iter().map(&mut point).collect()
        })
    }

    proptest! {
        #[test]
        fn one_dimension_is_the_line_between_two_points(
            points in points(), x in -60.0f64..120.0, clamped: bool
        ) {
            let outside = if clamped { Outside::Clamp } else { Outside::Extrapolate };
            let (xs, ys) = points.iter().copied().unzip();
            let found = Lookup::new(xs, Vec::new(), ys, outside).value(x, f64::NAN);
            let expected = naive(&points, x, outside);
            prop_assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1.0), "{found} {expected}");
        }

        #[test]
        fn two_dimensions_are_one_behind_the_other(
            rows in points(), columns in points(), x in -60.0f64..120.0, y in -60.0f64..120.0, clamped: bool
        ) {
            let outside = if clamped { Outside::Clamp } else { Outside::Extrapolate };
            let value = |row: (f64, f64), column: (f64, f64)| row.1 + column.1 * row.1;
            let values = rows.iter().flat_map(|row| columns.iter().map(|column| value(*row, *column)));
            let axis = |points: &[(f64, f64)]| points.iter().map(|point| point.0).collect();
            let table = Lookup::new(axis(&rows), axis(&columns), values.collect(), outside);
            let line = |row: &(f64, f64)| {
                let along: Vec<_> = columns.iter().map(|column| (column.0, value(*row, *column))).collect();
                (row.0, naive(&along, y, outside))
            };
            let expected = naive(&rows.iter().map(line).collect::<Vec<_>>(), x, outside);
            let found = table.value(x, y);
            // Far beyond both ends the values are differences of large numbers.
            prop_assert!((found - expected).abs() <= 1e-6 * expected.abs().max(1e4), "{found} {expected}");
        }
    }

    #[test]
    fn points_are_met_exactly_and_no_number_has_no_value() {
        let table =
            Lookup::new(vec![0.1, 0.3, 0.7], Vec::new(), vec![3.3, 3.7, 4.1], Outside::Clamp);
        assert_eq!([0.1, 0.3, 0.7, 9.0].map(|x| table.value(x, 0.0)), [3.3, 3.7, 4.1, 4.1]);
        assert!(table.value(f64::NAN, 0.0).is_nan());
    }
}
