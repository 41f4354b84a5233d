//! Least squares on whitened columns, one column at a time.

/// Orthonormal columns that span what a model can explain.
#[derive(Debug, Clone, Default)]
pub struct Basis {
    columns: Vec<Vec<f64>>,
}

/// A column with less than this share of its length outside the basis counts as inside.
const INDEPENDENT: f64 = 1e-6;

/// Sum of products.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Several sums let the processor work in parallel; the order is always the same.
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let (a8, b8) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for k in 0..SUMS {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn subtract(from: &mut [f64], factor: f64, column: &[f64]) {
    for (value, other) in from.iter_mut().zip(column) {
        *value -= factor * other;
    }
}

/// Rows processed at a time, so that those of all columns stay in the cache.
const ROWS: usize = 512;

/// Removes the components along orthonormal `directions` from `columns`.
fn take_out(directions: &[Vec<f64>], columns: &mut [Vec<f64>]) {
    let rows = columns.first().map_or(0, Vec::len);
    let chunks = || (0..rows).step_by(ROWS).map(|from| from..(from + ROWS).min(rows));
    let mut shares = vec![0.0; directions.len() * columns.len()];
    for chunk in chunks() {
        let mut share = shares.iter_mut();
        for column in &*columns {
            for (q, share) in directions.iter().zip(&mut share) {
                *share += dot(&q[chunk.clone()], &column[chunk.clone()]);
            }
        }
    }
    for chunk in chunks() {
        let mut share = shares.iter();
        for column in &mut *columns {
            for (q, share) in directions.iter().zip(&mut share) {
                subtract(&mut column[chunk.clone()], *share, &q[chunk.clone()]);
            }
        }
    }
}

impl Basis {
    /// Number of directions.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Its directions.
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Returns its directions.
    pub fn into_columns(self) -> Vec<Vec<f64>> {
        self.columns
    }

    /// Removes from `column` what the basis explains.
    pub fn project(&self, column: &mut Vec<f64>) {
        take_out(&self.columns, std::slice::from_mut(column));
    }

    /// Adds the new part of `column`; returns false if `column` has no new part.
    pub fn push(&mut self, column: Vec<f64>) -> bool {
        let before = self.len();
        self.extend(vec![column]);
        self.len() > before
    }

    /// Adds the new parts of `columns`.
    pub fn extend(&mut self, columns: Vec<Vec<f64>>) {
        let new = self.beyond(columns);
        self.columns.extend(new.columns);
    }

    /// The new parts of `columns`, orthonormal.
    pub fn beyond(&self, mut columns: Vec<Vec<f64>>) -> Self {
        let length = |column: &[f64]| dot(column, column).sqrt();
        columns.retain(|column| length(column) > 0.0 && length(column).is_finite());
        let before: Vec<f64> = columns.iter().map(|column| length(column)).collect();
        // Two passes suffice (Giraud, Langou and Rozloznik 2005).
        for _ in 0..2 {
            take_out(&self.columns, &mut columns);
        }
        let mut new = Self::default();
        for (mut column, before) in columns.into_iter().zip(before) {
            for _ in 0..2 {
                new.project(&mut column);
            }
            let after = length(&column);
            if after > INDEPENDENT * before {
                column.iter_mut().for_each(|value| *value /= after);
                new.columns.push(column);
            }
        }
        new
    }

    /// How much of `column` the basis explains: the sum of squares of its parts along it.
    pub fn explained(&self, column: &[f64]) -> f64 {
        self.columns.iter().map(|q| dot(q, column).powi(2)).sum()
    }
}

/// A least-squares solution.
#[derive(Debug, Clone)]
pub struct Solution {
    /// One per column; 0 for a column that depends on those before it.
    pub coefficients: Vec<f64>,
    /// Inverse of the normal matrix; rows and columns of dependent ones are zero.
    pub inverse: Vec<Vec<f64>>,
}

/// Solves `columns x coefficients = target` in the least-squares sense.
pub fn solve(columns: &[Vec<f64>], target: &[f64]) -> Solution {
    let k = columns.len();
    // QR by modified Gram-Schmidt, applied twice; R upper triangular.
    let mut q: Vec<Vec<f64>> = Vec::with_capacity(k);
    let mut r: Vec<Vec<f64>> = vec![vec![0.0; k]; k];
    let mut kept: Vec<usize> = Vec::new();
    for (j, column) in columns.iter().enumerate() {
        let mut v = column.clone();
        let before = dot(&v, &v).sqrt();
        for _ in 0..2 {
            for (i, &at) in kept.iter().enumerate() {
                let share = dot(&q[i], &v);
                r[at][j] += share;
                subtract(&mut v, share, &q[i]);
            }
        }
        let after = dot(&v, &v).sqrt();
        if before > 0.0 && after > INDEPENDENT * before {
            v.iter_mut().for_each(|value| *value /= after);
            r[j][j] = after;
            q.push(v);
            kept.push(j);
        }
    }
    let mut coefficients = vec![0.0; k];
    let rhs: Vec<f64> = q.iter().map(|q| dot(q, target)).collect();
    for i in (0..kept.len()).rev() {
        let at = kept[i];
        let sum: f64 = kept[i + 1..].iter().map(|&later| r[at][later] * coefficients[later]).sum();
        coefficients[at] = (rhs[i] - sum) / r[at][at];
    }
    // Inverse of R, column by column, then R^-1 R^-T.
    let m = kept.len();
    let mut inverse_r: Vec<Vec<f64>> = vec![vec![0.0; m]; m];
    for c in 0..m {
        inverse_r[c][c] = 1.0 / r[kept[c]][kept[c]];
        for i in (0..c).rev() {
            let sum: f64 = (i + 1..=c).map(|l| r[kept[i]][kept[l]] * inverse_r[l][c]).sum();
            inverse_r[i][c] = -sum / r[kept[i]][kept[i]];
        }
    }
    let mut inverse: Vec<Vec<f64>> = vec![vec![0.0; k]; k];
    for a in 0..m {
        for b in 0..m {
            inverse[kept[a]][kept[b]] =
                (a.max(b)..m).map(|l| inverse_r[a][l] * inverse_r[b][l]).sum();
        }
    }
    Solution { coefficients, inverse }
}

/// Normal equations of a least-squares fit, which can be summed over stretches of the data.
#[derive(Debug, Clone)]
pub struct Normal {
    /// Products of columns: the triangle below the diagonal.
    products: Vec<Vec<f64>>,
    /// Products of columns with the target.
    target: Vec<f64>,
}

/// Cholesky factor of the products, and the part of the target along each of its rows.
struct Factors {
    lower: Vec<Vec<f64>>,
    half: Vec<f64>,
}

/// A column with less than this share of its square left beyond the columns before it depends on them.
const DEPENDENT: f64 = 1e-11;

impl Normal {
    /// Equations of `width` columns and no rows.
    pub fn new(width: usize) -> Self {
        Self { products: (0..width).map(|i| vec![0.0; i + 1]).collect(), target: vec![0.0; width] }
    }

    /// Equations of all rows.
    pub fn of(columns: &[Vec<f64>], target: &[f64]) -> Self {
        let mut found = Self::new(columns.len());
        for from in (0..target.len()).step_by(ROWS) {
            found.add(columns, target, from..(from + ROWS).min(target.len()));
        }
        found
    }

    /// Adds the rows of `range`.
    pub fn add(&mut self, columns: &[Vec<f64>], target: &[f64], range: std::ops::Range<usize>) {
        for (i, column) in columns.iter().enumerate() {
            let column = &column[range.clone()];
            for (product, other) in self.products[i].iter_mut().zip(columns) {
                *product += dot(column, &other[range.clone()]);
            }
            self.target[i] += dot(column, &target[range.clone()]);
        }
    }

    /// Adds the rows of `other`.
    pub fn join(&mut self, other: &Self) {
        for (mine, its) in self.products.iter_mut().zip(&other.products) {
            mine.iter_mut().zip(its).for_each(|(mine, its)| *mine += its);
        }
        self.target.iter_mut().zip(&other.target).for_each(|(mine, its)| *mine += its);
    }

    /// Sum of squares that the columns leave of a target with this sum of squares. `None` if the products do not determine it
    /// to ten digits: a column nearly depends on others, or hardly anything is left.
    pub fn left(&self, square: f64) -> Option<f64> {
        /// Share of a column's square beyond the columns before it: below the range it counts as zero, above it as
        /// certain.
        const DOUBTFUL: std::ops::Range<f64> = 1e-14..1e-5;
        /// Smallest share of the target's square that a difference of sums resolves.
        const LEFT_MIN: f64 = 1e-5;
        let Factors { lower, half } = self.factors(DOUBTFUL.start);
        let explained: f64 = half.iter().map(|value| value * value).sum();
        let left = square - explained;
        let share = |(i, row): (usize, &Vec<f64>)| row[i] * row[i] / self.products[i][i];
        let is_sure = !lower.iter().enumerate().map(share).any(|share| DOUBTFUL.contains(&share));
        (is_sure && left > LEFT_MIN * square).then_some(left)
    }

    /// Cholesky factors; zeros for a column with less than this share of its square left beyond those before it.
    fn factors(&self, dependent: f64) -> Factors {
        let k = self.target.len();
        let mut lower: Vec<Vec<f64>> = Vec::with_capacity(k);
        let mut half = vec![0.0; k];
        for i in 0..k {
            let mut row = vec![0.0; i + 1];
            for j in 0..i {
                let sum: f64 = (0..j).map(|l| row[l] * lower[j][l]).sum();
                row[j] =
                    if lower[j][j] > 0.0 { (self.products[i][j] - sum) / lower[j][j] } else { 0.0 };
            }
            let own = self.products[i][i];
            let left = own - row[..i].iter().map(|value| value * value).sum::<f64>();
            row[i] = if left > dependent * own { left.sqrt() } else { 0.0 };
            if row[i] > 0.0 {
                let sum: f64 = (0..i).map(|l| row[l] * half[l]).sum();
                half[i] = (self.target[i] - sum) / row[i];
            }
            lower.push(row);
        }
        Factors { lower, half }
    }

    /// Coefficients, one per column; 0 for a column that depends on those before it.
    pub fn solve(&self) -> Vec<f64> {
        let Factors { lower, half } = self.factors(DEPENDENT);
        let k = self.target.len();
        let mut found = vec![0.0; k];
        for i in (0..k).rev() {
            if lower[i][i] > 0.0 {
                let sum: f64 = (i + 1..k).map(|l| lower[l][i] * found[l]).sum();
                found[i] = (half[i] - sum) / lower[i][i];
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::{Basis, Normal, dot, solve};

    #[test]
    fn normal_equations_add_up_to_the_fit_of_all_rows() {
        let x: Vec<f64> = (0..9).map(|i| f64::from(i * i % 7)).collect();
        let columns = vec![vec![1.0; 9], x.clone(), x.iter().map(|x| 3.0 * x).collect()];
        let y: Vec<f64> =
            x.iter().enumerate().map(|(i, x)| 2.0 - 0.3 * x + (i as f64).sin()).collect();
        let whole = solve(&columns, &y).coefficients;
        let mut normal = Normal::new(3);
        normal.add(&columns, &y, 0..4);
        let mut rest = Normal::new(3);
        rest.add(&columns, &y, 4..9);
        normal.join(&rest);
        for (a, b) in normal.solve().iter().zip(&whole) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    #[test]
    fn what_is_left_is_told_or_left_to_others() {
        let x: Vec<f64> = (0..40).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| 3.0 * x.sin()).collect();
        let double = x.iter().map(|x| 2.0 * x).collect();
        let left = |columns: &[Vec<f64>]| Normal::of(columns, &y).left(dot(&y, &y));
        let columns = vec![vec![1.0; 40], x.clone(), double];
        let mut basis = Basis::default();
        basis.extend(columns.clone());
        let mut rest = y.clone();
        basis.project(&mut rest);
        let sum = left(&columns).unwrap();
        assert!((sum - dot(&rest, &rest)).abs() < 1e-10, "{sum}");
        let near = x.iter().map(|x| x + 1e-4 * (7.0 * x).sin()).collect();
        assert_eq!(left(&[x, near]), None);
        assert_eq!(left(std::slice::from_ref(&y)), None);
    }

    #[test]
    fn a_line_is_solved_and_a_dependent_column_gets_nothing() {
        let ones = vec![1.0; 5];
        let x: Vec<f64> = (0..5).map(f64::from).collect();
        let double: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        let y: Vec<f64> = x.iter().map(|x| 3.0 + 0.5 * x).collect();
        let found = solve(&[ones.clone(), x.clone(), double], &y);
        assert!((found.coefficients[0] - 3.0).abs() < 1e-12);
        assert!((found.coefficients[1] - 0.5).abs() < 1e-12);
        assert_eq!(found.coefficients[2], 0.0);
        // Variance of a slope: 1 / sum (x - mean)^2.
        assert!((found.inverse[1][1] - 0.1).abs() < 1e-12);
        let mut basis = Basis::default();
        assert!(basis.push(ones) && basis.push(x.clone()) && !basis.push(y));
    }
}
