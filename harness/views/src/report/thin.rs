//! Reduces points to fewer that look the same: extremes are kept.

pub(super) type Point = (f64, f64);

/// Points simplified at a time: bounds the work, which in the worst case grows with their square.
const CHUNK: usize = 1_024;

/// Returns the lowest and the highest point of each of `columns` columns of equal width, in their original order. If
/// there are no more points than that, all are returned.
pub(super) fn extremes(points: &[Point], columns: usize) -> Vec<Point> {
    extreme_indices(points, columns).into_iter().map(|index| points[index]).collect()
}

/// Returns the indices of those points, ascending.
pub(super) fn extreme_indices(points: &[Point], columns: usize) -> Vec<usize> {
    if points.len() <= 2 * columns {
        return (0..points.len()).collect();
    }
    let (first, last) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (x, _)| (a.min(*x), b.max(*x)));
    let width = (last - first).max(f64::MIN_POSITIVE);
    let mut found: Vec<Option<(usize, usize)>> = vec![None; columns];
    for (index, (x, y)) in points.iter().enumerate() {
        let column = ((x - first) / width * columns as f64) as usize;
        let Some(slot) = found.get_mut(column.min(columns.saturating_sub(1))) else {
            continue;
        };
        let (low, high) = slot.get_or_insert((index, index));
        if *y < points[*low].1 {
            *low = index;
        }
        if *y > points[*high].1 {
            *high = index;
        }
    }
    let mut kept: Vec<usize> = found.into_iter().flatten().flat_map(|(a, b)| [a, b]).collect();
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Returns a line from which no dropped point is further than `tolerance` (Ramer-Douglas-Peucker).
pub(super) fn simplified(line: &[Point], tolerance: f64) -> Vec<Point> {
    let Some(last) = line.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut kept = vec![0];
    let mut start = 0;
    while start < last {
        let end = (start + CHUNK).min(last);
        simplify_chunk(line, start, end, tolerance, &mut kept);
        start = end;
    }
    kept.into_iter().map(|index| line[index]).collect()
}

/// Appends the indices kept of `start..=end`, without `start`.
fn simplify_chunk(line: &[Point], start: usize, end: usize, tolerance: f64, kept: &mut Vec<usize>) {
    let mut open = vec![(start, end)];
    while let Some((a, b)) = open.pop() {
        let furthest = (a + 1..b)
            .map(|index| (index, distance(line[index], line[a], line[b])))
            .max_by(|one, other| one.1.total_cmp(&other.1));
        match furthest {
            Some((index, far)) if far > tolerance => {
                // The first half is on top of the stack, so that indices come in order.
                open.push((index, b));
                open.push((a, index));
            }
            _ => kept.push(b),
        }
    }
}

/// Distance from `point` to the segment from `a` to `b`.
fn distance(point: Point, a: Point, b: Point) -> f64 {
    let (along_x, along_y) = (b.0 - a.0, b.1 - a.1);
    let (to_x, to_y) = (point.0 - a.0, point.1 - a.1);
    let length_squared = along_x * along_x + along_y * along_y;
    let share = if length_squared > 0.0 {
        ((to_x * along_x + to_y * along_y) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (to_x - share * along_x).hypot(to_y - share * along_y)
}

#[cfg(test)]
mod tests {
    use super::{Point, distance, extremes, simplified};
    use proptest::prelude::*;

    fn any_points(most: usize) -> impl Strategy<Value = Vec<Point>> {
        prop::collection::vec((-100.0..100.0f64, -100.0..100.0f64), 1..most)
    }

    #[test]
    fn a_spike_among_thousands_is_kept() {
        let mut points: Vec<Point> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 9.0;
        let thin = extremes(&points, 500);
        assert!(thin.len() <= 1_000);
        assert!(thin.contains(&(54_321.0, 9.0)));
    }

    #[test]
    fn a_square_driven_in_small_steps_is_four_corners() {
        let side = |n: i32| f64::from(n) * 0.01;
        let mut line: Vec<Point> = (0..400).map(|n| (side(n), 0.0)).collect();
        line.extend((0..400).map(|n| (4.0, side(n))));
        line.extend((0..=400).map(|n| (4.0 - side(n), 4.0)));
        assert_eq!(simplified(&line, 0.001).len(), 4 + 1, "corners, and the end of a chunk");
        assert!(simplified(&[], 1.0).is_empty());
        assert_eq!(simplified(&[(1.0, 2.0)], 1.0), [(1.0, 2.0)]);
    }

    proptest! {
        #[test]
        fn highest_and_lowest_survive(points in any_points(400), columns in 1usize..50) {
            let thin = extremes(&points, columns);
            let span = |points: &[Point]| {
                points.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)))
            };
            prop_assert_eq!(span(&thin), span(&points));
            prop_assert!(thin.len() <= 2 * columns);
        }

        #[test]
        fn no_dropped_point_is_far_from_the_line(line in any_points(3_000), tolerance in 0.0..50.0f64) {
            let simple = simplified(&line, tolerance);
            prop_assert_eq!(simple.first(), line.first());
            prop_assert_eq!(simple.last(), line.last());
            for point in &line {
                let near = simple.windows(2).any(|ends| distance(*point, ends[0], ends[1]) <= tolerance + 1e-9);
                prop_assert!(near || simple.contains(point));
            }
        }
    }
}
