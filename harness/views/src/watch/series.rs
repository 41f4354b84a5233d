//! Values over time in bounded memory: the latest in full, the whole run thinned.

use std::collections::VecDeque;

/// Maximum points of the latest values, and of the whole run.
pub const POINTS_MAX: usize = 1_200;

/// Values over bench time.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    latest: VecDeque<(f64, f64)>,
    /// The whole run. When full, every other point is dropped, and from then on the stride is doubled.
    whole: Vec<(f64, f64)>,
    stride: u64,
    count: u64,
}

/// Drops every other point.
pub(super) fn halve(points: &mut Vec<(f64, f64)>) {
    let mut index = 0;
    points.retain(|_| {
        index += 1;
        index % 2 == 1
    });
}

impl Default for Series {
    fn default() -> Self {
        Self { latest: VecDeque::new(), whole: Vec::new(), stride: 1, count: 0 }
    }
}

impl Series {
    /// Adds a value at `at_s`, unless it is not finite.
    pub fn push(&mut self, at_s: f64, value: f64) {
        if !value.is_finite() {
            return;
        }
        if self.latest.len() == POINTS_MAX {
            self.latest.pop_front();
        }
        self.latest.push_back((at_s, value));
        if self.count.is_multiple_of(self.stride) {
            if self.whole.len() == POINTS_MAX {
                halve(&mut self.whole);
                self.stride *= 2;
            }
            self.whole.push((at_s, value));
        }
        self.count += 1;
    }

    /// Returns the last value, with its time in seconds.
    pub fn last(&self) -> Option<(f64, f64)> {
        self.latest.back().copied()
    }

    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Returns the points from `from_s` on, in the finest resolution kept.
    pub fn since(&self, from_s: f64) -> Vec<(f64, f64)> {
        let covered = self.count as usize <= POINTS_MAX
            || self.latest.front().is_some_and(|(at_s, _)| *at_s <= from_s);
        if covered {
            return self.latest.iter().copied().filter(|(at_s, _)| *at_s >= from_s).collect();
        }
        let begins = self.latest.front().map_or(f64::INFINITY, |(at_s, _)| *at_s);
        let before = self.whole.iter().copied().filter(|(at_s, _)| *at_s < begins);
        before.chain(self.latest.iter().copied()).filter(|(at_s, _)| *at_s >= from_s).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{POINTS_MAX, Series};

    #[test]
    fn a_long_run_is_thinned_and_its_end_is_not() {
        let mut series = Series::default();
        for second in 0..100_000 {
            series.push(f64::from(second), f64::from(second));
        }
        assert_eq!(series.count(), 100_000);
        assert_eq!(series.last(), Some((99_999.0, 99_999.0)));
        let all = series.since(0.0);
        assert!(all.len() <= 2 * POINTS_MAX, "{}", all.len());
        assert_eq!(all[0].0, 0.0);
        assert!(all.is_sorted_by(|one, next| one.0 < next.0), "time goes on");
        let late = series.since(99_990.0);
        assert_eq!(late.len(), 10);
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let mut series = Series::default();
        series.push(1.0, f64::NAN);
        series.push(2.0, f64::INFINITY);
        assert_eq!((series.count(), series.last()), (0, None));
    }
}
