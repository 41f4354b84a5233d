//! Lateness of frames.

use hdrhistogram::Histogram;
use serde::Serialize;
use wire::time::Span;

/// Maximum lateness that is resolved; longer ones count as this.
const LONGEST_NS: u64 = 60_000_000_000;
const DIGITS: u8 = 3;
const NS_PER_US: f64 = 1e3;

/// Histogram of the times from when a frame was due to when it was handed to the port. No frame is early.
#[derive(Debug)]
pub(super) struct LateTimes(Option<Histogram<u64>>);

/// Distribution of lateness, to three digits.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Late {
    /// Median, µs.
    pub p50_us: f64,
    /// 99th percentile, µs.
    pub p99_us: f64,
    /// Maximum, µs.
    pub max_us: f64,
}

impl LateTimes {
    pub(super) fn new() -> Self {
        // These bounds are valid: a test checks that.
        Self(Histogram::new_with_bounds(1, LONGEST_NS, DIGITS).ok())
    }

    pub(super) fn add(&mut self, late: Span) {
        if let Some(histogram) = &mut self.0 {
            histogram.saturating_record(u64::try_from(late.as_nanos()).unwrap_or(0));
        }
    }

    pub(super) fn spread(&self) -> Late {
        let Some(histogram) = self.0.as_ref().filter(|histogram| !histogram.is_empty()) else {
            return Late::default();
        };
        let max = histogram.max();
        let us = |quantile| histogram.value_at_quantile(quantile).min(max) as f64 / NS_PER_US;
        Late { p50_us: us(0.5), p99_us: us(0.99), max_us: us(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Late, LateTimes, Span};

    #[test]
    fn quantiles_to_three_digits() {
        let mut times = LateTimes::new();
        assert_eq!(times.spread(), Late::default());
        for us in 1..=1_000 {
            times.add(Span::from_micros(us));
        }
        times.add(Span::from_nanos(-5));
        let Late { p50_us, p99_us, max_us } = times.spread();
        assert!((p50_us - 500.0).abs() < 1.0, "{p50_us}");
        assert!((p99_us - 990.0).abs() < 1.0, "{p99_us}");
        assert!((max_us - 1_000.0).abs() < 1.0, "{max_us}");
        times.add(Span::from_secs(3_600));
        assert!((times.spread().max_us / 60e6 - 1.0).abs() < 1e-3);
    }
}
