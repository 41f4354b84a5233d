//! Reduces many points to few that look the same: each point if there are few, else the spread of each column. Each
//! column keeps its lowest and highest point.

use super::super::download::{Table, number, place};
use super::super::thin::Point;
use super::ruler::{Ruler, ends, placed};

/// Maximum number of points drawn individually.
const MARKS_MAX: usize = 400;

/// Points per column, and minimum and maximum number of columns.
const POINTS_PER_COLUMN: usize = 25;
const COLUMNS_MIN: usize = 16;
const COLUMNS_MAX: usize = 120;

/// A median of fewer points shows no more than the points.
const MEDIAN_OF_MIN: usize = 3;
const MEDIANS_MIN: usize = 4;
const MEDIANS_MAX: usize = 30;

/// Width of a level's column as a share of the distance to the next level.
const LEVEL_SHARE: f64 = 0.7;

/// Points with x in the same part of the axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    /// Index of the part, from the left.
    pub index: usize,
    /// Its begin and end.
    pub x: (f64, f64),
    pub count: usize,
    pub lowest: f64,
    /// 5th percentile of the points.
    pub low: f64,
    pub median: f64,
    /// 95th percentile of the points.
    pub high: f64,
    pub highest: f64,
}

impl Column {
    pub(super) fn middle(&self) -> f64 {
        f64::midpoint(self.x.0, self.x.1)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cloud {
    Marks(Vec<Point>),
    Columns(Vec<Column>),
}

impl Cloud {
    pub(super) fn of(points: &[Point]) -> Self {
        if !is_thinned(points.len()) {
            return Self::Marks(points.to_vec());
        }
        let count = (points.len() / POINTS_PER_COLUMN).clamp(COLUMNS_MIN, COLUMNS_MAX);
        Self::Columns(columns(points, count))
    }

    /// Converts the cloud with rulers, which preserve the order of values.
    pub(super) fn placed(&self, x: &Ruler, y: &Ruler) -> Self {
        match self {
            Self::Marks(points) => Self::Marks(placed(points, x, y)),
            Self::Columns(columns) => Self::Columns(
                columns
                    .iter()
                    .map(|column| Column {
                        x: (x.place(column.x.0), x.place(column.x.1)),
                        lowest: y.place(column.lowest),
                        low: y.place(column.low),
                        median: y.place(column.median),
                        high: y.place(column.high),
                        highest: y.place(column.highest),
                        ..*column
                    })
                    .collect(),
            ),
        }
    }

    /// Returns the drawn data as a table.
    pub(super) fn table(&self, x: &str, y: &str) -> Table {
        match self {
            Self::Marks(points) => Table::of_points(x, y, points),
            Self::Columns(columns) => {
                let of = |what: &str| format!("{what} of {y}");
                let mut table = Table::new([
                    format!("{x} from"),
                    format!("{x} to"),
                    "points".to_owned(),
                    of("lowest"),
                    of("5 %"),
                    of("median"),
                    of("95 %"),
                    of("highest"),
                ]);
                for c in columns {
                    let (from, to) = c.x;
                    let [lowest, low, median, high, highest] =
                        [c.lowest, c.low, c.median, c.high, c.highest].map(number);
                    let (from, to, count) = (place(from), place(to), c.count.to_string());
                    table.row([from, to, count, lowest, low, median, high, highest]);
                }
                table
            }
        }
    }
}

/// Whether this many points are drawn as columns.
pub(super) const fn is_thinned(count: usize) -> bool {
    count > MARKS_MAX
}

/// Returns medians of columns wide enough for the noise in them to average out.
pub(super) fn medians(points: &[Point]) -> Vec<Point> {
    let count = (0.7 * (points.len() as f64).sqrt()) as usize;
    columns(points, count.clamp(MEDIANS_MIN, MEDIANS_MAX))
        .into_iter()
        .filter(|column| column.count >= MEDIAN_OF_MIN)
        .map(|column| (column.middle(), column.median))
        .collect()
}

/// Divides the points into columns of equal width, without empty ones. A channel with few distinct values has a
/// separate column for each.
pub(super) fn columns(points: &[Point], count: usize) -> Vec<Column> {
    if let Some(levels) = levels(points, count) {
        return of_levels(points, &levels);
    }
    let (first, last) = ends(points.iter().map(|point| point.0));
    let width = (last - first) / count.max(1) as f64;
    let mut held: Vec<Vec<f64>> = vec![Vec::new(); count.max(1)];
    for (x, y) in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
        let index = if width > 0.0 { ((x - first) / width) as usize } else { 0 };
        held[index.min(count.saturating_sub(1))].push(*y);
    }
    let begin = |index: usize| first + width * index as f64;
    let all = held.into_iter().enumerate();
    all.filter_map(|(i, values)| column(i, (begin(i), begin(i) + width), values)).collect()
}

fn column(index: usize, x: (f64, f64), mut values: Vec<f64>) -> Option<Column> {
    values.sort_by(f64::total_cmp);
    Some(Column {
        index,
        x,
        count: values.len(),
        lowest: *values.first()?,
        low: quantile(&values, 0.05)?,
        median: quantile(&values, 0.5)?,
        high: quantile(&values, 0.95)?,
        highest: *values.last()?,
    })
}

/// Returns the distinct values of x, ascending, if they are at most `most` and each is frequent.
fn levels(points: &[Point], most: usize) -> Option<Vec<f64>> {
    let mut levels: Vec<f64> = Vec::new();
    for (x, _) in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
        if let Err(at) = levels.binary_search_by(|level| level.total_cmp(&unsigned_zero(*x))) {
            levels.insert(at, unsigned_zero(*x));
        }
        if levels.len() > most || levels.len() * MEDIAN_OF_MIN > points.len() {
            return None;
        }
    }
    (levels.len() > 1).then_some(levels)
}

/// Converts minus zero to zero.
fn unsigned_zero(x: f64) -> f64 {
    x + 0.0
}

fn of_levels(points: &[Point], levels: &[f64]) -> Vec<Column> {
    let nearest = levels.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let half = LEVEL_SHARE / 2.0 * nearest;
    let mut held: Vec<Vec<f64>> = vec![Vec::new(); levels.len()];
    for (x, y) in points.iter().filter(|(_, y)| y.is_finite()) {
        if let Ok(at) = levels.binary_search_by(|level| level.total_cmp(&unsigned_zero(*x))) {
            held[at].push(*y);
        }
    }
    // Every other index, so that neighbours are not joined.
    let all = levels.iter().zip(held).enumerate();
    all.filter_map(|(i, (level, values))| column(2 * i, (level - half, level + half), values))
        .collect()
}

/// Returns the quantile of `sorted` at this share, interpolated linearly.
pub(super) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().checked_sub(1)? as f64;
    let (below, above) = (*sorted.get(place as usize)?, *sorted.get(place.ceil() as usize)?);
    Some(below + (above - below) * place.fract())
}

#[cfg(test)]
mod tests {
    use super::{Cloud, columns, ends, medians};
    use proptest::prelude::*;

    #[test]
    fn an_outlier_among_many_sticks_out_of_its_column() {
        let mut points: Vec<_> =
            (0..576_000).map(|i| (f64::from(i), f64::from(i % 7) - 3.0)).collect();
        points[123_456].1 = 99.0;
        let Cloud::Columns(columns) = Cloud::of(&points) else { panic!("too many for marks") };
        assert_eq!(columns.len(), super::COLUMNS_MAX);
        let outside: Vec<_> = columns.iter().filter(|column| column.highest > 3.0).collect();
        assert_eq!(outside.len(), 1);
        assert_eq!((outside[0].highest, outside[0].median), (99.0, 0.0));
        assert!(outside[0].x.0 <= 123_456.0 && outside[0].x.1 >= 123_456.0);
    }

    #[test]
    fn medians_find_a_step_in_noise() {
        let noise = |i: i32| f64::from((i * 7_919) % 101 - 50) / 10.0;
        let points: Vec<_> = (0..2_000)
            .map(|i| (f64::from(i), noise(i) + if i < 1_000 { 0.0 } else { 2.0 }))
            .collect();
        let medians = medians(&points);
        assert!(medians.len() > 20);
        for (x, y) in medians {
            assert!((y - if x < 1_000.0 { 0.0 } else { 2.0 }).abs() < 1.0, "{x} {y}");
        }
    }

    #[test]
    fn nothing_and_nonsense_are_no_columns() {
        assert!(columns(&[], 5).is_empty());
        assert!(columns(&[(f64::NAN, 1.0), (1.0, f64::INFINITY)], 5).is_empty());
        assert_eq!(columns(&[(2.0, 1.0), (2.0, 3.0)], 5).len(), 1, "a constant is one column");
    }

    #[test]
    fn each_of_a_few_values_has_its_column() {
        let mut points: Vec<_> =
            (0..900).map(|i| (f64::from(i % 3), f64::from(i % 3) * 2.0)).collect();
        points[0].0 = -0.0;
        let columns = columns(&points, 40);
        let seen: Vec<_> = columns.iter().map(|c| (c.index, c.middle(), c.median)).collect();
        assert_eq!(seen, [(0, 0.0, 0.0), (2, 1.0, 2.0), (4, 2.0, 4.0)]);
        assert!((columns[0].x.1 - 0.35).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn every_point_is_in_a_column(
            points in prop::collection::vec((-1e9..1e9f64, -1e3..1e3f64), 1..300),
            count in 1usize..40,
        ) {
            let columns = columns(&points, count);
            prop_assert_eq!(columns.iter().map(|c| c.count).sum::<usize>(), points.len());
            let span = ends(columns.iter().flat_map(|c| [c.lowest, c.highest]));
            prop_assert_eq!(span, ends(points.iter().map(|p| p.1)));
            for c in &columns {
                prop_assert!(c.lowest <= c.low && c.low <= c.median);
                prop_assert!(c.median <= c.high && c.high <= c.highest);
            }
        }
    }
}
