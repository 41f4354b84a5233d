//! Medians: of all observations, and along an axis.

use super::observed::Sample;
use super::thin::Point;
use statrs::statistics::{Data, OrderStatistics};

/// Columns of a running median, and minimum observations per column.
const MEDIAN_COLUMNS: usize = 24;
const MEDIAN_OF_MIN: usize = 3;

pub(super) fn median(samples: &[Sample]) -> Option<f64> {
    median_of(samples.iter().map(|sample| sample.value))
}

pub(super) fn median_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| Data::new(values).median())
}

/// Returns the median of each column with enough points, at the middle of these points.
pub(super) fn running(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let size = points.len().div_ceil(MEDIAN_COLUMNS).max(MEDIAN_OF_MIN);
    let columns = sorted.chunks(size).filter(|column| column.len() >= MEDIAN_OF_MIN);
    columns
        .filter_map(|column| {
            let x = median_of(column.iter().map(|point| point.0))?;
            Some((x, median_of(column.iter().map(|point| point.1))?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{median_of, running};

    #[test]
    fn a_running_median_hears_no_outlier() {
        let mut points: Vec<_> = (0..240).map(|n| (f64::from(n), f64::from(n))).collect();
        points[100].1 = 1e6;
        let line = running(&points);
        assert_eq!(line.len(), 24);
        assert!(line.iter().all(|(x, y)| (x - y).abs() <= 1.0), "{line:?}");
        assert!(running(&points[..2]).is_empty());
        assert_eq!(median_of([3.0, 1.0, 2.0].into_iter()), Some(2.0));
        assert_eq!(median_of(std::iter::empty()), None);
    }
}
