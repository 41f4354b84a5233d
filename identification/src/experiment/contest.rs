//! Distance between two causes on given and on planned rows.
//!
//! With A true, B in its place leaves `lambda = min |x_A th_A - [J, x_B] th|^2 / sigma^2` unexplained: the
//! non-centrality of the test that then refuses B. J is the rest of the model with the derivatives of its numbers. All
//! columns are whitened with the noise that was found. QR reduces a thousand rows to a triangle with the same sums of
//! products, so that stacking triangles joins given and planned rows.

use crate::fit::{Data, Found, combine};
use crate::model::{Acts, Shape};
use crate::noise::Whitener;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

/// Multiples of the best value at which a rival's number (a time constant, say) is tried.
const MULTIPLES: [f64; 9] = [0.125, 0.25, 0.5, 0.71, 1.0, 1.41, 2.0, 4.0, 8.0];
/// Relative step of a numerical derivative.
const NUDGE: f64 = 0.01;

/// Columns of a term; zero if the data do not show it.
fn columns(term: &Shape, data: Data<'_>) -> Vec<Vec<f64>> {
    let found = data.columns(term);
    match found.is_empty() {
        true => vec![vec![0.0; data.block.rows.len()]; term.width()],
        false => found,
    }
}

/// Columns of a term, and the derivatives of their sum by each of its numbers.
fn tangent(term: &Found, data: Data<'_>) -> Vec<Vec<f64>> {
    let mut found = columns(&term.shape, data);
    for name in term.shape.nonlinear() {
        let Some(value) = term.shape.number(name) else { continue };
        let step = (NUDGE * value.abs()).max(f64::MIN_POSITIVE);
        let side = |sign: f64| {
            let moved = term.shape.clone().with(name, value + sign * step);
            combine(&columns(&moved, data), &term.values())
        };
        let (high, low) = (side(1.0), side(-1.0));
        found.push(high.iter().zip(&low).map(|(high, low)| (high - low) / (2.0 * NUDGE)).collect());
    }
    found
}

/// Copies of a term with its one number at several values.
fn variants(term: &Shape) -> Vec<Shape> {
    let name = if let [name] = term.nonlinear()[..] { Some(name) } else { None };
    let Some((name, value)) = name.and_then(|name| Some((name, term.number(name)?))) else {
        return vec![term.clone()];
    };
    MULTIPLES.iter().map(|multiple| term.clone().with(name, multiple * value)).collect()
}

/// One cause true, another fitted in its place.
#[derive(Debug, Clone)]
pub(super) struct Contest {
    /// The rest of the model.
    pub rest: Vec<Found>,
    /// The true cause.
    pub truth: Found,
    /// The cause fitted in its place.
    pub instead: Found,
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
        let mut seen: Vec<Vec<f64>> =
            self.rest.iter().flat_map(|term| tangent(term, data)).collect();
        seen.extend(if planned {
            columns(&Shape::constant("bias", Acts::Bias), data)
        } else {
            vec![vec![0.0; data.block.rows.len()]]
        });
        let rest = seen.len();
        let mut variants = Vec::new();
        for variant in self::variants(&self.instead.shape) {
            let mine = columns(&variant, data);
            variants.push(mine.len());
            seen.extend(mine);
        }
        seen.push(combine(&columns(&self.truth.shape, data), &self.truth.values()));
        let mut whitened = DMatrix::zeros(seen[0].len().max(seen.len()), seen.len());
        for (index, column) in seen.iter().enumerate() {
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
