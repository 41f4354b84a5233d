//! Times of the slow steps: once a second, by the gyro's clock.

use super::clock::OutputClock;
use super::noise::Steps;
use wire::time::Span;

/// Gyro time between two evaluations of slow quantities.
const SLOW_STEP: Span = Span::from_secs(1);

/// Seconds, counted in outputs. A second may be cut: its rest then becomes a step of its own, so that changed
/// parameters take effect at once and the seconds keep their grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowSteps {
    outputs_per_second: u32,
    /// Outputs of this step: a second, or the rest of one.
    outputs: u32,
    left: u32,
    /// Remaining outputs of a second that was cut.
    rest: u32,
}

impl SlowSteps {
    /// The state before the first step, for outputs every `period` (nominal).
    pub(super) fn new(period: Span) -> Self {
        let outputs_per_second = (SLOW_STEP.as_nanos() / period.as_nanos()) as u32;
        Self { outputs_per_second, outputs: outputs_per_second, left: 0, rest: 0 }
    }

    /// Lengths of the steps at the current rate of `clock`.
    pub(super) fn steps(&self, clock: &OutputClock) -> Steps {
        let output_s = clock.period_s();
        Steps { output_s, slow_s: output_s * f64::from(self.outputs_per_second) }
    }

    /// True if the step is over.
    #[inline]
    pub(super) const fn is_over(&self) -> bool {
        self.left == 0
    }

    /// Counts one output of the step, which must not be over.
    #[inline]
    pub(super) const fn output(&mut self) {
        self.left -= 1;
    }

    /// Starts a step; returns its number of outputs and whether it starts a second.
    pub(super) fn start(&mut self) -> (u32, bool) {
        let whole = self.rest == 0;
        self.outputs = if whole { self.outputs_per_second } else { self.rest };
        self.left = self.outputs;
        self.rest = 0;
        (self.outputs, whole)
    }

    /// Ends the step early.
    pub(super) const fn cut(&mut self) {
        self.rest += self.left;
        self.left = 0;
    }

    /// The elapsed share of the step.
    pub(super) fn share(&self) -> f64 {
        1.0 - f64::from(self.left) / f64::from(self.outputs)
    }

    /// The elapsed share of the second.
    pub(super) fn share_of_second(&self) -> f64 {
        1.0 - f64::from(self.left + self.rest) / f64::from(self.outputs_per_second)
    }
}

#[cfg(test)]
mod tests {
    use super::SlowSteps;
    use proptest::prelude::*;
    use wire::time::Span;

    proptest! {
        /// Wherever they are cut, seconds start every 100 outputs of a 100 Hz stream.
        #[test]
        fn cuts_do_not_move_the_seconds(cuts in prop::collection::vec(0u32..1_000, 0..20)) {
            let mut slow = SlowSteps::new(Span::from_millis(10));
            for output in 0..1_000 {
                for _ in cuts.iter().filter(|&&cut| cut == output) {
                    slow.cut();
                    prop_assert_eq!(slow.share(), 1.0);
                }
                if slow.is_over() {
                    let (outputs, second_begins) = slow.start();
                    prop_assert_eq!(second_begins, output % 100 == 0);
                    prop_assert_eq!(outputs, 100 - output % 100);
                }
                let of_second = f64::from(output % 100) / 100.0;
                prop_assert!((slow.share_of_second() - of_second).abs() < 1e-12);
                slow.output();
            }
        }
    }
}
