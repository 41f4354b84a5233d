//! Running estimate of the rate of change of a temperature.

use heapless::Deque;
use wire::time::{Span, Timestamp};

/// The slope covers the readings of this window. Assumption: a coil's time constant is half an hour (see the emulated
/// gyro), so that a slope that is half a window old is off by 2 %; a sensor noise of 0.05 K per second leaves 4e-4
/// K/s.
pub const SLOPE_WINDOW: Span = Span::from_secs(60);
/// Minimum number of readings for a slope: with fewer, noise dominates. Assumption.
pub const SLOPE_POINTS_MIN: usize = 10;
/// One reading a second, plus one at each end.
const SLOPE_POINTS_MAX: usize = 62;

/// Least-squares slope over a sliding window.
#[derive(Debug, Clone, Default)]
pub(super) struct Slope {
    points: Deque<(Timestamp, f64), SLOPE_POINTS_MAX>,
    per_s: Option<f64>,
}

impl Slope {
    /// Units per second; `None` until there are [`SLOPE_POINTS_MIN`] readings.
    pub(super) const fn per_s(&self) -> Option<f64> {
        self.per_s
    }

    /// Takes a reading.
    pub(super) fn add(&mut self, now: Timestamp, value: f64) {
        while self.points.is_full()
            || self.points.front().is_some_and(|(at, _)| now - *at > SLOPE_WINDOW)
        {
            self.points.pop_front();
        }
        // Cannot fail: the oldest reading of a full window was removed above.
        let _ = self.points.push_back((now, value));
        self.per_s = self.fit();
    }

    fn fit(&self) -> Option<f64> {
        let count = self.points.len();
        let (last, newest) = *self.points.back()?;
        if count < SLOPE_POINTS_MIN {
            return None;
        }
        // Times and values relative to the newest, to avoid subtracting large numbers of similar size.
        let near = || self.points.iter().map(|&(at, x)| ((at - last).as_secs_f64(), x - newest));
        let mean_t = near().map(|(t, _)| t).sum::<f64>() / count as f64;
        let (above, below) = near().fold((0.0, 0.0), |(above, below), (t, x)| {
            let off = t - mean_t;
            (above + off * x, below + off * off)
        });
        (below > 0.0).then(|| above / below)
    }
}

#[cfg(test)]
mod tests {
    use super::{SLOPE_POINTS_MIN, Slope};
    use proptest::prelude::*;
    use wire::time::Timestamp;

    proptest! {
        #[test]
        fn a_line_has_its_slope_at_any_pace(
            slope in -1f64..1.0, start in -40f64..85.0, gap_s in 0.5f64..5.0,
        ) {
            let mut estimate = Slope::default();
            for n in 0..200 {
                let t = f64::from(n) * gap_s;
                estimate.add(Timestamp::from_secs_f64(t), start + slope * t);
                let known = n as usize + 1 >= SLOPE_POINTS_MIN;
                prop_assert_eq!(estimate.per_s().is_some(), known);
                if let Some(found) = estimate.per_s() {
                    prop_assert!((found - slope).abs() < 1e-6, "{found} {slope}");
                }
            }
        }
    }

    #[test]
    fn what_is_old_is_forgotten() {
        let mut estimate = Slope::default();
        for second in 0..300 {
            let value = if second < 100 { f64::from(second) } else { 100.0 };
            estimate.add(Timestamp::from_secs_f64(second.into()), value);
        }
        assert_eq!(estimate.per_s(), Some(0.0));
    }
}
