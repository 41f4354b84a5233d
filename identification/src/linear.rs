//! Least squares on whitened columns, one column at a time.

mod basis;
mod normal;
mod sums;

pub use basis::Basis;
use basis::INDEPENDENT;
pub use normal::{Normal, Solution};
pub use sums::dot;
use sums::subtract;

/// Solves `columns x coefficients = target` in the least-squares sense.
pub fn solve(columns: &[Vec<f64>], target: &[f64]) -> Solution {
    Normal::of(columns, target).solution().unwrap_or_else(|| solve_slowly(columns, target))
}

/// Coefficients alone of the same.
pub fn coefficients(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let sure = Normal::of(columns, target).sure();
    sure.unwrap_or_else(|| solve_slowly(columns, target).coefficients)
}

/// The same where the square of what is left of each row counts that many times.
pub fn weighed(columns: &[Vec<f64>], target: &[f64], weights: &[f64]) -> Vec<f64> {
    Normal::weighed(columns, target, weights).sure().unwrap_or_else(|| {
        let weigh = |column: &[f64]| -> Vec<f64> {
            column.iter().zip(weights).map(|(value, weight)| value * weight.sqrt()).collect()
        };
        let columns: Vec<Vec<f64>> = columns.iter().map(|column| weigh(column)).collect();
        solve_slowly(&columns, &weigh(target)).coefficients
    })
}

/// The same where columns nearly depend on others.
fn solve_slowly(columns: &[Vec<f64>], target: &[f64]) -> Solution {
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
        let independent = solve(&[ones.clone(), x.clone()], &y);
        for (i, (fast, slow)) in independent.inverse.iter().zip(&found.inverse).enumerate() {
            assert!((independent.coefficients[i] - found.coefficients[i]).abs() < 1e-12);
            assert!(fast.iter().zip(slow).all(|(a, b)| (a - b).abs() < 1e-12), "{fast:?}");
        }
        let mut basis = Basis::default();
        assert!(basis.push(ones) && basis.push(x.clone()) && !basis.push(y));
    }
}
