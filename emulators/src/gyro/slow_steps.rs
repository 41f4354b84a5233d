//! When what is slow is worked out: once a second, by the gyro's clock.

use super::clock::OutputClock;
use super::noise::Steps;
use wire::time::Span;

/// Gyro time between two evaluations of what is slow.
const SLOW_STEP: Span = Span::from_secs(1);

/// Seconds, counted in outputs. A second may be cut: it then goes on in a step of its own, so that
/// changed parameters take effect at once and the seconds stay where they are.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowSteps {
    outputs_per_second: u32,
    /// Outputs of this step: a second, or what was left of one.
    outputs: u32,
    /// Those of them still to come.
    left: u32,
    /// Outputs still to come of a second that was cut.
    rest: u32,
}

impl SlowSteps {
    /// Nothing has begun, for outputs every `period` (nominal).
    pub(super) fn new(period: Span) -> Self {
        let outputs_per_second = (SLOW_STEP.as_nanos() / period.as_nanos()) as u32;
        Self { outputs_per_second, outputs: outputs_per_second, left: 0, rest: 0 }
    }

    /// Lengths of the steps, while `clock` runs as it does.
    pub(super) fn steps(&self, clock: &OutputClock) -> Steps {
        let output_s = clock.period_s();
        Steps { output_s, slow_s: output_s * f64::from(self.outputs_per_second) }
    }

    /// The step is over.
    #[inline]
    pub(super) const fn is_over(&self) -> bool {
        self.left == 0
    }

    /// One output of the step, which is not over.
    #[inline]
    pub(super) const fn output(&mut self) {
        self.left -= 1;
    }

    /// Begins a step; whether it begins a second. The step's outputs are what comes back with it.
    pub(super) fn start(&mut self) -> (u32, bool) {
        let whole = self.rest == 0;
        self.outputs = if whole { self.outputs_per_second } else { self.rest };
        self.left = self.outputs;
        self.rest = 0;
        (self.outputs, whole)
    }

    /// The step is over here.
    pub(super) const fn cut(&mut self) {
        self.rest += self.left;
        self.left = 0;
    }

    /// How much of the step is over.
    pub(super) fn share(&self) -> f64 {
        1.0 - f64::from(self.left) / f64::from(self.outputs)
    }

    /// How much of the second is over.
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
        /// Wherever they are cut, seconds begin every 100 outputs of a 100 Hz stream.
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
