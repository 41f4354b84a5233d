//! Distribution of times, in logarithmic bins.

use record::outcome::{Bin, Spread};
use wire::time::Span;

/// Bins per decade: each is 1.6 times as wide as the previous one.
const PER_DECADE: usize = 5;
/// Decades from [`SHORTEST_NS`] on, up to 10 s; one more bin holds longer times.
const DECADES: usize = 7;
const BINS: usize = PER_DECADE * DECADES + 1;
/// Upper end of the first bin.
const SHORTEST_NS: f64 = 1_000.0;
const NS_PER_MS: f64 = 1e6;

/// Times, counted by length.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    counts: [u64; BINS],
    max: Span,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: [0; BINS], max: Span::ZERO }
    }
}

impl Histogram {
    pub(super) fn add(&mut self, time: Span) {
        let decades = (time.as_nanos().max(1) as f64 / SHORTEST_NS).log10();
        // The cast saturates: shorter times are in the first bin.
        let bin = (decades * PER_DECADE as f64).ceil() as usize;
        self.counts[bin.min(BINS - 1)] += 1;
        self.max = self.max.max(time);
    }

    pub(super) fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    pub(super) fn spread(&self) -> Spread {
        let bins = self.counts.iter().enumerate().filter(|(_, count)| **count > 0);
        Spread {
            count: self.count(),
            p50_ms: self.quantile_ms(0.5),
            p99_ms: self.quantile_ms(0.99),
            max_ms: self.max_ms(),
            bins: bins.map(|(bin, &count)| Bin { up_to_ms: self.end_ms(bin), count }).collect(),
        }
    }

    fn max_ms(&self) -> f64 {
        self.max.as_nanos() as f64 / NS_PER_MS
    }

    /// Upper end of the bin, at most the longest time.
    fn end_ms(&self, bin: usize) -> f64 {
        let end = SHORTEST_NS * 10f64.powf(bin as f64 / PER_DECADE as f64) / NS_PER_MS;
        if bin == BINS - 1 { self.max_ms() } else { end.min(self.max_ms()) }
    }

    fn quantile_ms(&self, share: f64) -> f64 {
        let wanted = (share * self.count() as f64).ceil();
        let mut below = 0;
        for (bin, count) in self.counts.iter().enumerate() {
            below += count;
            if *count > 0 && below as f64 >= wanted {
                return self.end_ms(bin);
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::{BINS, Histogram, Span};

    #[test]
    fn quantiles_are_the_ends_of_bins_and_never_above_the_longest() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.spread().p99_ms, 0.0);
        for _ in 0..98 {
            histogram.add(Span::from_micros(90));
        }
        histogram.add(Span::from_millis(3));
        histogram.add(Span::from_secs(40));
        let spread = histogram.spread();
        assert_eq!((spread.count, spread.max_ms), (100, 40_000.0));
        assert!((spread.p50_ms - 0.1).abs() < 1e-9, "{spread:?}");
        assert!((3.0..5.0).contains(&spread.p99_ms), "{spread:?}");
        let counts: Vec<u64> = spread.bins.iter().map(|bin| bin.count).collect();
        assert_eq!(counts, [98, 1, 1]);
    }

    #[test]
    fn every_length_has_a_bin() {
        let mut histogram = Histogram::default();
        for nanos in [i64::MIN, 0, 1, 1_000, 1_001, i64::MAX] {
            histogram.add(Span::from_nanos(nanos));
        }
        assert_eq!((histogram.count(), histogram.counts[0], histogram.counts[BINS - 1]), (6, 4, 1));
    }
}
