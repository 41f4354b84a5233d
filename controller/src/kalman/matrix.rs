//! A covariance matrix: symmetric, of fixed size.

/// States of the filter.
pub(super) const STATES: usize = 12;

/// One number for each state.
pub(super) type Vector = [f64; STATES];

/// Rounding may leave a variance below zero by this share of the largest product.
const ROUNDING: f64 = 1e-18;

/// Stores both halves and keeps them equal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Symmetric {
    rows: [Vector; STATES],
}

impl Symmetric {
    pub(super) const fn variance(&self, state: usize) -> f64 {
        self.rows[state][state]
    }

    pub(super) const fn set_variance(&mut self, state: usize, variance: f64) {
        self.rows[state][state] = variance;
    }

    pub(super) fn add_variance(&mut self, state: usize, variance: f64) {
        self.rows[state][state] += variance;
    }

    pub(super) fn add_covariance(&mut self, one: usize, other: usize, covariance: f64) {
        self.rows[one][other] += covariance;
        self.rows[other][one] += covariance;
    }

    /// Replaces a state by one with `variance` that is uncorrelated with the others.
    pub(super) fn forget(&mut self, state: usize, variance: f64) {
        self.scale(state, 0.0);
        self.rows[state][state] = variance;
    }

    /// Multiplies a state by `factor`.
    pub(super) fn scale(&mut self, state: usize, factor: f64) {
        for other in 0..STATES {
            self.rows[state][other] *= factor;
            self.rows[other][state] *= factor;
        }
    }

    /// Adds multiples of other states to a state.
    pub(super) fn add_to(&mut self, state: usize, others: &[(usize, f64)]) {
        for &(other, factor) in others {
            for column in 0..STATES {
                self.rows[state][column] += factor * self.rows[other][column];
            }
        }
        for row in 0..STATES {
            for &(other, factor) in others {
                self.rows[row][state] += factor * self.rows[row][other];
            }
        }
    }

    pub(super) fn times(&self, vector: &Vector) -> Vector {
        self.rows.map(|row| dot(&row, vector))
    }

    /// Subtracts the reduction by a measurement of `variance` whose covariance with the states is `with`.
    pub(super) fn take_off(&mut self, with: &Vector, variance: f64) {
        for row in 0..STATES {
            for column in 0..=row {
                let left = self.rows[row][column] - with[row] * with[column] / variance;
                self.rows[row][column] = left;
                self.rows[column][row] = left;
            }
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.rows.iter().flatten().all(|x| x.is_finite())
    }

    /// True if no variance is below zero and no covariance exceeds the limit set by its variances.
    pub(super) fn is_positive(&self) -> bool {
        (0..STATES).all(|row| {
            self.variance(row) >= -ROUNDING
                && (0..row).all(|column| {
                    let both = self.variance(row).max(0.0) * self.variance(column).max(0.0);
                    let square = self.rows[row][column] * self.rows[row][column];
                    square <= both * (1.0 + 1e-6) + ROUNDING * ROUNDING
                })
        })
    }
}

pub(super) fn dot(a: &Vector, b: &Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
