//! Normal equations.

use super::basis::Basis;
use super::sums::{ROWS, dot};

/// A least-squares solution.
#[derive(Debug, Clone)]
pub struct Solution {
    /// One per column; 0 for a column that depends on those before it.
    pub coefficients: Vec<f64>,
    /// Inverse of the normal matrix; rows and columns of dependent ones are zero.
    pub inverse: Vec<Vec<f64>>,
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

    /// Equations of all rows, each of which counts that many times.
    pub fn weighed(columns: &[Vec<f64>], target: &[f64], weights: &[f64]) -> Self {
        let mut found = Self::new(columns.len());
        let mut weighed = vec![0.0; ROWS];
        for from in (0..target.len()).step_by(ROWS) {
            let rows = from..(from + ROWS).min(target.len());
            let weighed = &mut weighed[..rows.len()];
            for (i, column) in columns.iter().enumerate() {
                let both = column[rows.clone()].iter().zip(&weights[rows.clone()]);
                weighed.iter_mut().zip(both).for_each(|(to, (value, weight))| *to = value * weight);
                for (product, other) in found.products[i].iter_mut().zip(columns) {
                    *product += dot(weighed, &other[rows.clone()]);
                }
                found.target[i] += dot(weighed, &target[rows.clone()]);
            }
        }
        found
    }

    /// Adds the rows of `range`.
    pub fn add(&mut self, columns: &[Vec<f64>], target: &[f64], range: std::ops::Range<usize>) {
        self.add_from(0, columns, target, range);
    }

    /// Adds the rows of `range` to the equations of the columns from `first` on.
    fn add_from<C: AsRef<[f64]>>(
        &mut self,
        first: usize,
        columns: &[C],
        target: &[f64],
        range: std::ops::Range<usize>,
    ) {
        for (i, column) in columns.iter().enumerate().skip(first) {
            let column = &column.as_ref()[range.clone()];
            for (product, other) in self.products[i].iter_mut().zip(columns) {
                *product += dot(column, &other.as_ref()[range.clone()]);
            }
            self.target[i] += dot(column, &target[range.clone()]);
        }
    }

    /// The same equations, which are those of `columns`, with `more` of them.
    #[must_use]
    pub fn with(&self, columns: &[Vec<f64>], more: &[Vec<f64>], target: &[f64]) -> Self {
        let mut found = self.clone();
        let first = columns.len();
        found.products.extend((0..more.len()).map(|i| vec![0.0; first + i + 1]));
        found.target.resize(first + more.len(), 0.0);
        let all: Vec<&[f64]> = columns.iter().chain(more).map(Vec::as_slice).collect();
        for from in (0..target.len()).step_by(ROWS) {
            found.add_from(first, &all, target, from..(from + ROWS).min(target.len()));
        }
        found
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

    /// Sum of squares that the columns of these equations leave of their `target`: of the `columns` themselves where the products do
    /// not determine it.
    pub fn left_of(&self, target: &[f64], columns: impl FnOnce() -> Vec<Vec<f64>>) -> f64 {
        self.left(dot(target, target)).unwrap_or_else(|| {
            let mut basis = Basis::default();
            basis.extend(columns());
            let mut target = target.to_vec();
            basis.project(&mut target);
            dot(&target, &target)
        })
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
        self.factors(DEPENDENT).coefficients()
    }

    /// Coefficients, if the products determine them to ten digits.
    pub fn sure(&self) -> Option<Vec<f64>> {
        self.sure_factors().map(|factors| factors.coefficients())
    }

    /// The factors, if they determine the coefficients to ten digits.
    fn sure_factors(&self) -> Option<Factors> {
        /// Share of a column's square beyond the columns before it from which its coefficient is certain.
        const SURE: f64 = 1e-6;
        let factors = self.factors(DEPENDENT);
        let share = |(i, row): (usize, &Vec<f64>)| row[i] * row[i] / self.products[i][i];
        factors.lower.iter().enumerate().map(share).all(|share| share > SURE).then_some(factors)
    }

    /// The solution, if the products determine it to ten digits.
    pub(super) fn solution(&self) -> Option<Solution> {
        let factors = self.sure_factors()?;
        Some(Solution { coefficients: factors.coefficients(), inverse: factors.inverse() })
    }
}

impl Factors {
    fn coefficients(&self) -> Vec<f64> {
        let Self { lower, half } = self;
        let k = half.len();
        let mut found = vec![0.0; k];
        for i in (0..k).rev() {
            if lower[i][i] > 0.0 {
                let sum: f64 = (i + 1..k).map(|l| lower[l][i] * found[l]).sum();
                found[i] = (half[i] - sum) / lower[i][i];
            }
        }
        found
    }

    /// Inverse of the products.
    fn inverse(&self) -> Vec<Vec<f64>> {
        let (lower, k) = (&self.lower, self.half.len());
        // Columns of the inverse of the factor.
        let mut inner = vec![vec![0.0; k]; k];
        for c in 0..k {
            inner[c][c] = 1.0 / lower[c][c];
            for i in c + 1..k {
                let sum: f64 = (c..i).map(|l| lower[i][l] * inner[c][l]).sum();
                inner[c][i] = -sum / lower[i][i];
            }
        }
        let product = |a: usize, b: usize| (a.max(b)..k).map(|l| inner[a][l] * inner[b][l]).sum();
        (0..k).map(|a| (0..k).map(|b| product(a, b)).collect()).collect()
    }
}
