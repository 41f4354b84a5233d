//! Distance between two causes on given and on planned rows.
//!
//! With A true, B in its place leaves `lambda = min |x_A th_A - [J, x_B] th|^2 / sigma^2` unexplained: the
//! non-centrality of the test that then refuses B. J is the rest of the model with the derivatives of its numbers. All
//! columns are whitened with the noise that was found. QR reduces a thousand rows to a triangle with the same sums of
//! products, so that stacking triangles joins given and planned rows.

use crate::fit::{Data, combine};
use crate::model::{Acts, Shape};
use crate::noise::Whitener;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Multiples of the best value at which a rival's number (a time constant, say) is tried.
const MULTIPLES: [f64; 9] = [0.125, 0.25, 0.5, 0.71, 1.0, 1.41, 2.0, 4.0, 8.0];
/// Relative step of a numerical derivative.
const NUDGE: f64 = 0.01;

/// A shape with its coefficients.
#[derive(Debug, Clone)]
pub(super) struct Valued {
    /// The shape, with its numbers at their best.
    pub shape: Shape,
    /// One per column.
    pub coefficients: Vec<f64>,
}

impl Valued {
    /// Its columns; zero if the data do not show it.
    fn columns(&self, data: Data<'_>) -> Vec<Vec<f64>> {
        let found = data.columns(&self.shape);
        if found.is_empty() {
            vec![vec![0.0; data.block.rows.len()]; self.shape.width()]
        } else {
            found
        }
    }

    /// Its columns, and the derivatives of their sum by each of its numbers.
    fn tangent(&self, data: Data<'_>) -> Vec<Vec<f64>> {
        let mut columns = self.columns(data);
        for name in self.shape.nonlinear() {
            let Some(value) = self.shape.number(name) else { continue };
            let step = (NUDGE * value.abs()).max(f64::MIN_POSITIVE);
            let side = |sign: f64| {
                let mut moved = self.clone();
                moved.shape.set(name, value + sign * step);
                combine(&moved.columns(data), &self.coefficients)
            };
            let (high, low) = (side(1.0), side(-1.0));
            let change =
                high.iter().zip(&low).map(|(high, low)| (high - low) / (2.0 * NUDGE)).collect();
            columns.push(change);
        }
        columns
    }

    /// Copies with its one number at several values.
    fn variants(&self) -> Vec<Self> {
        let [name] = self.shape.nonlinear()[..] else {
            return vec![self.clone()];
        };
        let Some(value) = self.shape.number(name) else {
            return vec![self.clone()];
        };
        let at = |multiple: &f64| {
            let mut moved = self.clone();
            moved.shape.set(name, multiple * value);
            moved
        };
        MULTIPLES.iter().map(at).collect()
    }
}

/// One cause true, another fitted in its place.
#[derive(Debug, Clone)]
pub(super) struct Contest {
    /// The rest of the model.
    pub rest: Vec<Valued>,
    /// The true cause.
    pub truth: Valued,
    /// The cause fitted in its place.
    pub instead: Valued,
}

/// What rows say about a contest, as a triangle over its columns.
pub(super) struct Triangle {
    r: DMatrix<f64>,
    /// Number of columns of the rest of the model.
    rest: usize,
    /// Columns of each variant of the cause fitted in its place, one variant after the other behind those of the rest;
    /// the truth is last.
    variants: Vec<usize>,
}

impl Contest {
    /// The information in the rows of `data`, in units of `sigma`. `planned` rows follow another power-up, so their
    /// bias is free.
    pub(super) fn seen(
        &self,
        data: Data<'_>,
        whitener: &Whitener,
        sigma: f64,
        planned: bool,
    ) -> Triangle {
        let mut columns: Vec<Vec<f64>> =
            self.rest.iter().flat_map(|valued| valued.tangent(data)).collect();
        let offset = Valued { shape: Shape::constant("bias", Acts::Bias), coefficients: vec![1.0] };
        columns.extend(if planned {
            offset.columns(data)
        } else {
            vec![vec![0.0; data.block.rows.len()]]
        });
        let rest = columns.len();
        let mut variants = Vec::new();
        for variant in self.instead.variants() {
            let mine = variant.columns(data);
            variants.push(mine.len());
            columns.extend(mine);
        }
        columns.push(combine(&self.truth.columns(data), &self.truth.coefficients));
        let mut whitened = DMatrix::zeros(columns[0].len().max(columns.len()), columns.len());
        for (index, column) in columns.iter().enumerate() {
            for (row, value) in whitener.apply(column).into_iter().enumerate() {
                whitened[(row, index)] = value / sigma;
            }
        }
        Triangle { r: whitened.qr().unpack_r(), rest, variants }
    }
}

/// The smallest unexplained distance on all rows together.
pub(super) fn lambda(seen: &[&Triangle]) -> f64 {
    let Some(first) = seen.first() else {
        return 0.0;
    };
    let mut from = first.rest;
    let mut least = f64::INFINITY;
    for width in &first.variants {
        let chosen: Vec<usize> =
            (0..first.rest).chain(from..from + width).chain([first.r.ncols() - 1]).collect();
        from += width;
        let rows = seen.iter().map(|part| part.r.nrows()).sum();
        let mut stacked = DMatrix::zeros(rows, chosen.len());
        let mut at = 0;
        for part in seen {
            for row in 0..part.r.nrows() {
                for (column, &index) in chosen.iter().enumerate() {
                    stacked[(at + row, column)] = part.r[(row, index)];
                }
            }
            at += part.r.nrows();
        }
        let r = stacked.qr().unpack_r();
        let last = r.ncols() - 1;
        least = least.min(r[(last, last)] * r[(last, last)]);
    }
    if least.is_finite() { least } else { 0.0 }
}

/// Chi-squared quantile at which a rival is refused: once in 200 times by chance, as in the search for rivals.
const REFUSED_AT: f64 = 0.995;

/// Probability that a rival at the distance `lambda` is refused by a cause of `width` columns: the non-central
/// chi-squared distribution in Sankaran's normal approximation (Biometrika 50, 1963).
pub(super) fn probability(lambda: f64, width: usize) -> f64 {
    let k = width.max(1) as f64;
    let lambda = lambda.max(0.0);
    let Ok(limit) = ChiSquared::new(k).map(|law| law.inverse_cdf(REFUSED_AT)) else {
        return 0.0;
    };
    let h = 1.0 - 2.0 * (k + lambda) * (k + 3.0 * lambda) / (3.0 * (k + 2.0 * lambda).powi(2));
    let p = (k + 2.0 * lambda) / (k + lambda).powi(2);
    let m = (h - 1.0) * (1.0 - 3.0 * h);
    let above = (limit / (k + lambda)).powf(h) - 1.0 - h * p * (h - 1.0 - 0.5 * (2.0 - h) * m * p);
    let score = above / (h * (2.0 * p).sqrt() * (1.0 + 0.5 * m * p));
    1.0 - Normal::standard().cdf(score)
}

#[cfg(test)]
mod tests {
    use super::probability;
    use statrs::distribution::{ContinuousCDF, Normal};

    #[test]
    fn with_one_column_it_is_that_of_a_shifted_normal() {
        let normal = Normal::standard();
        let limit = normal.inverse_cdf(1.0 - 0.0025);
        for lambda in [0.0, 1.0, 5.0, 20.0, 60.0_f64] {
            let shift = lambda.sqrt();
            let exact = normal.cdf(shift - limit) + normal.cdf(-shift - limit);
            assert!((probability(lambda, 1) - exact).abs() < 0.01, "{lambda}: {exact}");
        }
    }

    #[test]
    fn it_grows_with_the_distance_and_falls_with_the_width() {
        assert!(
            (1..200)
                .all(|i| probability(f64::from(i), 2) > probability(f64::from(i - 1), 2) - 1e-9)
        );
        assert!(probability(15.0, 5) < probability(15.0, 1));
    }
}
