//! The gyro's readings while the base stands: its bias, measured at every standstill.
//!
//! Readings count while the base reports that it stands and no command will move it. Each counts after a delay: if the
//! base starts to move by itself, the readings just before are not taken for rest.

use crate::bias_test::RunningMean;
use wire::time::{Span, Timestamp};
use wire::units::AngularRate;

/// From the base's report to the first reading of rest: a reading spends 8 ms on the line and as long in the gyro's
/// filter. Assumption: twice that.
const LATENCY: Span = Span::from_millis(30);
/// The latest readings, over this span, may be those of a base that has started to move.
const DOUBT: Span = Span::from_millis(100);
/// A standstill is evaluated in pieces no longer than the paper's bias test.
const PIECE: Span = Span::from_secs(20);
/// Minimum number of readings to detect a changed bias. Assumption: half of the 0.3 s in which a base settles.
const READINGS_MIN: u32 = 15;
/// A bias has changed if the mean is off by this many standard errors plus the largest drift.
const STANDARD_ERRORS: f64 = 5.0;

/// The current standstill.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Standstill {
    since: Option<Timestamp>,
    sure: RunningMean,
    doubtful: RunningMean,
    doubtful_since: Timestamp,
}

/// Readings of a standstill or a piece of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rest {
    pub(crate) mean: AngularRate,
    pub(crate) readings: u32,
    /// The newly confirmed ones.
    pub(crate) piece: RunningMean,
}

impl Standstill {
    /// Takes a reading while the base stands. Returns the rest so far when a piece of it is confirmed.
    pub(crate) fn reading(&mut self, now: Timestamp, rate: AngularRate) -> Option<Rest> {
        let since = *self.since.get_or_insert(now);
        if now - since < LATENCY {
            self.doubtful_since = now;
            return None;
        }
        let piece = (now - self.doubtful_since >= DOUBT).then(|| self.settle(now)).flatten();
        if now - since > PIECE {
            *self = Self { since: Some(now - LATENCY), doubtful_since: now, ..Self::default() };
        }
        self.doubtful.add(rate.rad_per_s());
        piece
    }

    /// Ends the standstill just before a commanded motion.
    pub(crate) fn ends(&mut self, now: Timestamp) -> Option<Rest> {
        let rest = self.since.is_some().then(|| self.settle(now)).flatten();
        *self = Self::default();
        rest
    }

    /// Discards the standstill: the base moved at an unknown time, or readings are missing.
    pub(crate) fn is_broken_off(&mut self) {
        *self = Self::default();
    }

    fn settle(&mut self, now: Timestamp) -> Option<Rest> {
        let piece = core::mem::take(&mut self.doubtful);
        self.sure.join(&piece);
        self.doubtful_since = now;
        let (readings, mean) = (self.sure.count(), self.sure.mean());
        let mean = AngularRate::from_rad_per_s(mean);
        (piece.count() > 0).then_some(Rest { mean, readings, piece })
    }
}

impl Rest {
    /// True if the gyro's bias differs from `bias`. `spread` is that of its readings at rest.
    pub(crate) fn moved(
        &self,
        bias: AngularRate,
        spread: AngularRate,
        drift_max: AngularRate,
    ) -> bool {
        if self.readings < READINGS_MIN {
            return false;
        }
        let standard_error = spread / libm::sqrt(f64::from(self.readings));
        (self.mean - bias).abs() > drift_max + standard_error * STANDARD_ERRORS
    }
}

#[cfg(test)]
mod tests {
    use super::{AngularRate, Rest, Standstill, Timestamp};
    use std::vec::Vec;
    use wire::time::Span;

    fn stand(readings: impl Iterator<Item = f64>) -> (Standstill, Vec<Rest>, Timestamp) {
        let (mut standstill, mut rests) = (Standstill::default(), Vec::new());
        let mut now = Timestamp::ZERO;
        for deg_per_s in readings {
            now += Span::from_millis(10);
            rests.extend(standstill.reading(now, AngularRate::from_deg_per_s(deg_per_s)));
        }
        (standstill, rests, now)
    }

    #[test]
    fn a_settling_base_shows_the_bias() {
        let (mut standstill, _, now) = stand((0..30).map(|n| if n < 3 { 9.0 } else { 0.05 }));
        let rest = standstill.ends(now).expect("0.3 s are enough");
        assert!((rest.mean.deg_per_s() - 0.05).abs() < 1e-12 && rest.readings >= 25, "{rest:?}");
        let moved = |bias| {
            let deg = AngularRate::from_deg_per_s;
            rest.moved(deg(bias), deg(0.014), deg(0.02))
        };
        assert!(moved(0.01) && moved(0.09) && !moved(0.03));
    }

    #[test]
    fn what_came_just_before_an_unforeseen_motion_is_not_rest() {
        let (_, rests, _) = stand((0..100).map(|n| if n < 92 { 0.0 } else { 1.0 }));
        assert!(!rests.is_empty() && rests.iter().all(|rest| rest.mean == AngularRate::ZERO));
    }

    #[test]
    fn a_long_rest_is_looked_at_in_pieces() {
        let (_, rests, _) = stand((0..10_000).map(|n| if n < 5_000 { 0.0 } else { 0.1 }));
        let last = rests.last().expect("there was rest");
        assert!((last.mean.deg_per_s() - 0.1).abs() < 1e-12 && last.readings <= 2_000, "{last:?}");
    }
}
