//! Past temperatures. Terms with a memory start from them as if they had been present from the beginning.

use heapless::Vec;
use wire::time::{Span, Timestamp};

/// Maximum number of stored temperatures.
pub(super) const POINTS_MAX: usize = 256;
/// Initial spacing. Assumption: a coil's time constant is half an hour (see the emulated gyro).
const SPACING: Span = Span::from_secs(10);

/// Temperatures since the first one; the spacing grows as they become many.
#[derive(Debug, Clone)]
pub(super) struct History {
    points: Vec<(Timestamp, f64), POINTS_MAX>,
    spacing: Span,
}

impl Default for History {
    fn default() -> Self {
        Self { points: Vec::new(), spacing: SPACING }
    }
}

impl History {
    /// Takes a reading, unless the last stored one is too recent.
    pub(super) fn add(&mut self, now: Timestamp, celsius: f64) {
        if self.points.last().is_some_and(|(at, _)| now - *at < self.spacing) {
            return;
        }
        if self.points.is_full() {
            let mut index = 0;
            self.points.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.spacing = self.spacing + self.spacing;
        }
        // Cannot fail: a full list was halved above.
        let _ = self.points.push((now, celsius));
    }

    /// Each temperature with the time since the previous one, s.
    pub(super) fn steps(&self) -> impl Iterator<Item = (f64, f64)> {
        let before = [None].into_iter().chain(self.points.iter().map(|(at, _)| Some(*at)));
        self.points.iter().zip(before).map(|(&(at, celsius), before)| {
            (celsius, before.map_or(0.0, |before| (at - before).as_secs_f64()))
        })
    }

    /// Time from the last stored temperature until `now`, s.
    pub(super) fn since_last(&self, now: Timestamp) -> f64 {
        self.points.last().map_or(0.0, |(at, _)| (now - *at).as_secs_f64())
    }
}

#[cfg(test)]
mod tests {
    use super::{History, POINTS_MAX};
    use wire::time::Timestamp;

    #[test]
    fn a_day_has_room_and_keeps_its_beginning() {
        let mut history = History::default();
        for second in 0..86_400_u32 {
            history.add(Timestamp::from_secs_f64(second.into()), second.into());
        }
        let steps: std::vec::Vec<_> = history.steps().collect();
        assert!(steps.len() > POINTS_MAX / 2 - 2 && steps.len() <= POINTS_MAX, "{}", steps.len());
        assert_eq!(steps[0], (0.0, 0.0));
        let passed: f64 = steps.iter().map(|(_, passed)| passed).sum();
        let end = Timestamp::from_secs_f64(86_399.0);
        assert!((passed + history.since_last(end) - 86_399.0).abs() < 1e-6);
        assert!(steps.windows(2).all(|pair| (pair[1].0 - pair[0].0 - pair[1].1).abs() < 1e-6));
    }
}
