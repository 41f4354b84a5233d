//! Losses in bursts: the Gilbert-Elliott model, with netem's order of parameters.

use plan::faults::Chance;

/// A channel with a good and a bad state, each with its own probability of loss.
///
/// As in netem (`loss gemodel p r 1-h 1-k`) the state at arrival decides the loss and changes afterwards. The
/// share of time in the bad state is p / (p + r).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GilbertElliott {
    /// Probability of going from good to bad, p.
    pub to_bad: f64,
    /// Probability of going from bad to good, r.
    pub to_good: f64,
    /// Probability of a loss in the bad state, 1-h.
    pub loss_bad: f64,
    /// Probability of a loss in the good state, 1-k.
    pub loss_good: f64,
    /// Whether the channel is in the bad state.
    pub bad: bool,
}

impl GilbertElliott {
    /// Starts in the good state; parameters in per cent, in netem's order.
    pub fn from_percent(p: f64, r: f64, one_minus_h: f64, one_minus_k: f64) -> Self {
        Self {
            to_bad: p / 100.0,
            to_good: r / 100.0,
            loss_bad: one_minus_h / 100.0,
            loss_good: one_minus_k / 100.0,
            bad: false,
        }
    }

    /// Whether the next item is lost.
    pub fn loses(&mut self, chance: &mut Chance) -> bool {
        let (loss, change) =
            if self.bad { (self.loss_bad, self.to_good) } else { (self.loss_good, self.to_bad) };
        let lost = chance.happens(loss);
        self.bad ^= chance.happens(change);
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::{Chance, GilbertElliott};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The mean is p/(p+r) (1-h) + r/(p+r) (1-k); its standard error over n steps of a chain with
        /// correlation c = 1 - p - r is at most sqrt(q (1-q) / n (1+c)/(1-c)).
        #[test]
        fn the_mean_loss_is_that_of_the_chain(
            p in 1f64..50.0, r in 5f64..100.0, bad in 50f64..=100.0, good in 0f64..10.0, seed: u64,
        ) {
            const STEPS: u32 = 50_000;
            let mut channel = GilbertElliott::from_percent(p, r, bad, good);
            let mut chance = Chance::new(seed, "0");
            let lost = (0..STEPS).filter(|_| channel.loses(&mut chance)).count();
            let share_bad = p / (p + r);
            let expected = share_bad * bad / 100.0 + (1.0 - share_bad) * good / 100.0;
            let correlation = (1.0 - (p + r) / 100.0).max(0.0);
            let u = (expected * (1.0 - expected) / f64::from(STEPS) * (1.0 + correlation)
                / (1.0 - correlation))
                .sqrt();
            let mean = lost as f64 / f64::from(STEPS);
            prop_assert!((mean - expected).abs() < 6.0 * u + 1e-3, "{mean} is not {expected} +- {u}");
        }
    }

    #[test]
    fn bursts_are_as_long_as_one_over_r() {
        let mut channel = GilbertElliott::from_percent(1.0, 10.0, 100.0, 0.0);
        let mut chance = Chance::new(1, "0");
        let (mut bursts, mut lost, mut before) = (0u32, 0u32, false);
        for _ in 0..1_000_000 {
            let now = channel.loses(&mut chance);
            bursts += u32::from(now && !before);
            lost += u32::from(now);
            before = now;
        }
        let length = f64::from(lost) / f64::from(bursts);
        assert!((length - 10.0).abs() < 0.5, "{length}");
    }
}
