//! How far apart two causes are on given and on planned rows.
//!
//! With A true, B in its place leaves `lambda = min |x_A th_A - [J, x_B] th|^2 / sigma^2` unexplained: the
//! non-centrality of the test that then refuses B. J is the rest of the model with the derivatives of its numbers.
//! All columns are whitened by the noise that was found. QR keeps of a thousand rows a triangle with the same sums of
//! products, so that given and planned rows are joined by stacking triangles.

use crate::model::{Acts, Shape};
use crate::noise::Whitener;
use crate::select::{Data, combine};
use nalgebra::DMatrix;

/// Numbers of a rival (a time constant, say) are tried at these multiples of the best value.
const MULTIPLES: [f64; 9] = [0.125, 0.25, 0.5, 0.71, 1.0, 1.41, 2.0, 4.0, 8.0];
/// Share of a number by which it is moved for a derivative.
const NUDGE: f64 = 0.01;

/// A shape with its coefficients.
#[derive(Debug, Clone)]
pub(super) struct Valued {
    /// Its numbers at their best.
    pub shape: Shape,
    /// One a column.
    pub coefficients: Vec<f64>,
}

impl Valued {
    /// Its columns; zero where nothing of it is seen.
    fn columns(&self, data: Data<'_>) -> Vec<Vec<f64>> {
        let found = data.columns(&self.shape);
        if found.is_empty() {
            vec![vec![0.0; data.block.rows.len()]; self.shape.width()]
        } else {
            found
        }
    }

    /// Its columns, and how its sum changes with each of its numbers.
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

    /// It, with its one number at several values.
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
    /// What is true.
    pub truth: Valued,
    /// What is fitted instead.
    pub instead: Valued,
}

/// What rows say about a contest: a triangle over its columns.
pub(super) struct Triangle {
    r: DMatrix<f64>,
    /// How many columns are of the rest of the model.
    rest: usize,
    /// Columns of each variant of what is fitted instead, one after the other behind those of the rest; the truth is
    /// last.
    variants: Vec<usize>,
}

impl Contest {
    /// What the rows of `data` say, in units of `sigma`. `planned` rows come after another power-up: their bias is
    /// free.
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

/// The least that stays unexplained on all rows together.
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
