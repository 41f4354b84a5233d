//! Natural cubic splines, defined by their values at the knots.

use nalgebra::{DMatrix, DVector};

/// Columns of a spline through `knots`: column i is the spline that is 1 at knot i and 0 at the others. Beyond the ends
/// it continues straight for a little ([`REACH`]) and is then held: an unexplained shape does not extrapolate.
pub fn cardinal(knots: &[f64], at: &[f64]) -> Vec<Vec<f64>> {
    let k = knots.len();
    let mut columns = vec![vec![1.0; at.len()]; k];
    if k < 2 {
        return columns;
    }
    let second: Vec<Vec<f64>> = (0..k).map(|i| second_derivatives(knots, i)).collect();
    let reach = REACH * (knots[k - 1] - knots[0]);
    for (row, &x) in at.iter().enumerate() {
        let place = Place::of(knots, x.clamp(knots[0] - reach, knots[k - 1] + reach));
        for (which, column) in columns.iter_mut().enumerate() {
            column[row] = place.value(which, &second[which]);
        }
    }
    columns
}

/// The spline through `values` at `knots` as a straight line from the first knot on, with its slope, and a bend at each
/// knot: `bend (x - knot)^3` beyond it.
pub fn pieces(knots: &[f64], values: &[f64]) -> (f64, Vec<f64>) {
    let k = knots.len();
    if k < 2 {
        return (0.0, Vec::new());
    }
    let mut second = vec![0.0; k];
    for (which, value) in values.iter().enumerate().take(k) {
        for (sum, one) in second.iter_mut().zip(second_derivatives(knots, which)) {
            *sum += value * one;
        }
    }
    let first = knots[1] - knots[0];
    let slope = (values[1] - values[0]) / first - first / 6.0 * second[1];
    let third = |i: usize| (second[i + 1] - second[i]) / (knots[i + 1] - knots[i]);
    let bends = (0..k).map(|i| {
        let before = if i == 0 { 0.0 } else { third(i - 1) };
        let after = if i + 1 == k { 0.0 } else { third(i) };
        (after - before) / 6.0
    });
    (slope, bends.collect())
}

/// How far a spline continues beyond its ends, as a share of its length.
pub const REACH: f64 = 0.1;

/// Second derivatives at the knots of the natural spline that is 1 at knot `which`.
fn second_derivatives(knots: &[f64], which: usize) -> Vec<f64> {
    let k = knots.len();
    if k < 3 {
        return vec![0.0; k];
    }
    let y = |i: usize| if i == which { 1.0 } else { 0.0 };
    let n = k - 2;
    let mut matrix = DMatrix::zeros(n, n);
    let mut right = DVector::zeros(n);
    for row in 0..n {
        let i = row + 1;
        let (before, after) = (knots[i] - knots[i - 1], knots[i + 1] - knots[i]);
        matrix[(row, row)] = (before + after) / 3.0;
        if row > 0 {
            matrix[(row, row - 1)] = before / 6.0;
        }
        if row + 1 < n {
            matrix[(row, row + 1)] = after / 6.0;
        }
        right[row] = (y(i + 1) - y(i)) / after - (y(i) - y(i - 1)) / before;
    }
    let inner = matrix.lu().solve(&right).unwrap_or_else(|| DVector::zeros(n));
    let mut found = vec![0.0; k];
    found[1..=n].copy_from_slice(inner.as_slice());
    found
}

/// Position of a value among the knots, which all splines share.
struct Place {
    /// The knot before.
    knot: usize,
    /// Weights of the values and of the second derivatives, at the knot before and the one after.
    values: [f64; 2],
    seconds: [f64; 2],
}

impl Place {
    /// Position of `x` among at least two `knots`; beyond them, on the straight continuation of the end.
    fn of(knots: &[f64], x: f64) -> Self {
        let last = knots.len() - 1;
        let knot = knots.partition_point(|knot| *knot <= x).clamp(1, last) - 1;
        let h = knots[knot + 1] - knots[knot];
        let (a, b) = ((knots[knot + 1] - x) / h, (x - knots[knot]) / h);
        let seconds = if x < knots[0] {
            // The slope at the first knot, times the distance.
            [h * h / 6.0 * -2.0 * b, h * h / 6.0 * -b]
        } else if x > knots[last] {
            [h * h / 6.0 * -a, h * h / 6.0 * -2.0 * a]
        } else {
            [h * h / 6.0 * (a * a * a - a), h * h / 6.0 * (b * b * b - b)]
        };
        Self { knot, values: [a, b], seconds }
    }

    /// The spline that is 1 at knot `which` and has these `second` derivatives.
    fn value(&self, which: usize, second: &[f64]) -> f64 {
        let [a, b] = self.seconds;
        let curved = a * second[self.knot] + b * second[self.knot + 1];
        if which == self.knot {
            self.values[0] + curved
        } else if which == self.knot + 1 {
            self.values[1] + curved
        } else {
            curved
        }
    }
}

/// Weights of bilinear interpolation: a hat at each knot, held beyond the ends.
pub fn hats(knots: &[f64], at: &[f64]) -> Vec<Vec<f64>> {
    let k = knots.len();
    let mut columns = vec![vec![0.0; at.len()]; k];
    for (row, &x) in at.iter().enumerate() {
        let above = knots.partition_point(|knot| *knot <= x);
        if above == 0 {
            columns[0][row] = 1.0;
        } else if above == k {
            columns[k - 1][row] = 1.0;
        } else {
            let share = (x - knots[above - 1]) / (knots[above] - knots[above - 1]);
            columns[above - 1][row] = 1.0 - share;
            columns[above][row] = share;
        }
    }
    columns
}

/// Knots at the quantiles of `values`, at most `count`, all distinct.
pub fn quantile_knots(values: &[f64], count: usize) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    if n == 0 {
        return Vec::new();
    }
    let span = sorted[n - 1] - sorted[0];
    let mut knots: Vec<f64> = Vec::with_capacity(count);
    for i in 0..count {
        // Half by rank, half by distance, so that a sparse region gets a knot too.
        let share = i as f64 / (count - 1).max(1) as f64;
        let by_rank = sorted[((n - 1) as f64 * share).round() as usize];
        let knot = (by_rank + sorted[0] + share * span) / 2.0;
        if knots.last().is_none_or(|last| knot - last > 1e-3 * span) {
            knots.push(knot);
        }
    }
    knots
}

#[cfg(test)]
mod tests {
    use super::{cardinal, pieces};

    #[test]
    fn a_straight_line_stays_one_and_knots_are_met() {
        let knots = [0.0, 1.0, 2.5, 4.0, 7.0];
        let at: Vec<f64> = (-7..77).map(|i| f64::from(i) * 0.1).collect();
        let columns = cardinal(&knots, &at);
        for (row, x) in at.iter().enumerate() {
            let line: f64 = knots.iter().zip(&columns).map(|(k, c)| (2.0 + 3.0 * k) * c[row]).sum();
            assert!((line - (2.0 + 3.0 * x)).abs() < 1e-9, "{x}");
        }
        let held = cardinal(&knots, &[7.7, 100.0]);
        assert!(held.iter().all(|column| (column[0] - column[1]).abs() < 1e-12));
        let at_knots = cardinal(&knots, &knots);
        for (i, column) in at_knots.iter().enumerate() {
            for (j, value) in column.iter().enumerate() {
                assert!((value - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn pieces_are_the_same_spline() {
        let knots = [0.0, 1.0, 2.5, 4.0, 7.0];
        let values = [0.3, -1.0, 2.0, 0.5, 4.0];
        let (slope, bends) = pieces(&knots, &values);
        let at: Vec<f64> = (-7..77).map(|i| f64::from(i) * 0.1).collect();
        let columns = cardinal(&knots, &at);
        for (row, x) in at.iter().enumerate() {
            let whole: f64 = values.iter().zip(&columns).map(|(v, c)| v * c[row]).sum();
            let bent = bends.iter().zip(&knots).map(|(b, k)| b * (x - k).max(0.0).powi(3));
            let found = values[0] + slope * (x - knots[0]) + bent.sum::<f64>();
            assert!((found - whole).abs() < 1e-9, "{x}: {found} {whole}");
        }
    }
}
