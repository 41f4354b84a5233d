//! Compares the gyro's clock with the host's: samples counted against elapsed time.

use wire::time::{Span, Timestamp};

/// Minimum duration of a comparison. Assumption: a host that delivers a sample 10 ms late then causes an error of 0.05
/// %, a tenth of the mismatch that is reported.
const WINDOW_MIN: Span = Span::from_secs(20);

/// Clock comparison. Silence restarts it, because the number of samples lost in it is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClockWatch {
    period: Span,
    window: Option<(Timestamp, i64)>,
    ratio: Option<f64>,
}

impl ClockWatch {
    pub(crate) const fn new(period: Span) -> Self {
        Self { period, window: None, ratio: None }
    }

    /// Restarts the comparison and keeps the last ratio.
    pub(crate) const fn restart(&mut self) {
        self.window = None;
    }

    /// Takes a sample that arrived after `lost` missing ones. Returns a new ratio when a window is full.
    pub(crate) fn sample(&mut self, now: Timestamp, lost: u16) -> Option<f64> {
        let Some((since, count)) = &mut self.window else {
            self.window = Some((now, 0));
            return None;
        };
        *count += 1 + i64::from(lost);
        let passed = now - *since;
        if passed < WINDOW_MIN {
            return None;
        }
        let ratio = (self.period * *count).as_secs_f64() / passed.as_secs_f64();
        self.window = Some((now, 0));
        self.ratio = Some(ratio);
        self.ratio
    }

    /// Gyro time over host time in the last full window.
    pub(crate) const fn ratio(&self) -> Option<f64> {
        self.ratio
    }
}

#[cfg(test)]
mod tests {
    use super::{ClockWatch, Span, Timestamp};

    fn ratio_of(true_period_ns: i64, lose_every: i64, sequence: bool) -> f64 {
        let mut watch = ClockWatch::new(Span::from_millis(10));
        let mut lost = 0;
        for n in 0..5_000 {
            if lose_every > 0 && n % lose_every == 0 {
                lost += 1;
                continue;
            }
            let at = Timestamp::from_nanos(n * true_period_ns);
            watch.sample(at, if sequence { lost } else { 0 });
            lost = 0;
        }
        watch.ratio().unwrap()
    }

    #[test]
    fn a_slow_gyro_and_lost_samples_show() {
        assert!((ratio_of(10_000_000, 0, false) - 1.0).abs() < 1e-9);
        assert!((ratio_of(10_300_000, 0, false) - 1.0 / 1.03).abs() < 1e-3, "3 % slow");
        assert!((ratio_of(10_000_000, 50, false) - 0.98).abs() < 1e-3, "2 % lost, unseen");
        assert!((ratio_of(10_000_000, 50, true) - 1.0).abs() < 1e-3, "2 % lost, counted");
    }
}
