//! Sums over the rows of columns.

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

pub(super) fn subtract(from: &mut [f64], factor: f64, column: &[f64]) {
    for (value, other) in from.iter_mut().zip(column) {
        *value -= factor * other;
    }
}

/// Rows processed at a time, so that those of all columns stay in the cache.
pub(super) const ROWS: usize = 512;
