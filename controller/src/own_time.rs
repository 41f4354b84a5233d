//! The controller's time, which never runs back.
//!
//! The host's clock may be set back. Pending deadlines would then move away and a time-out would not expire, so that
//! the base would move unsupervised. Therefore the controller's own time continues from its last value.

use crate::mutant::{Mutant, Planted};
use wire::time::{Span, Timestamp};

/// Converts the host's clock to a time that never runs back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct OwnTime {
    last: Option<Timestamp>,
    /// Own time minus the host's: the sum of all steps back of its clock.
    ahead: Span,
    planted: Planted,
}

impl OwnTime {
    pub(crate) fn new(planted: Planted) -> Self {
        Self { planted, ..Self::default() }
    }

    /// Converts the reading `told` of the host's clock and remembers it.
    pub(crate) fn hear(&mut self, told: Timestamp) -> Timestamp {
        let own = self.at(told);
        self.ahead = own - told;
        self.last = Some(own);
        own
    }

    /// The own time that was last remembered.
    pub(crate) fn last(&self) -> Timestamp {
        self.last.unwrap_or(Timestamp::ZERO)
    }

    /// Converts `told` without remembering it.
    pub(crate) fn at(&self, told: Timestamp) -> Timestamp {
        if self.planted.is(Mutant::HostClockBelieved) {
            return told;
        }
        let own = told + self.ahead;
        self.last.map_or(own, |last| own.max(last))
    }

    /// The reading of the host's clock at the time `own`.
    pub(crate) fn told(&self, own: Timestamp) -> Timestamp {
        if own == Timestamp::MAX { own } else { own - self.ahead }
    }
}

#[cfg(test)]
mod tests {
    use super::OwnTime;
    use proptest::prelude::*;
    use wire::time::{Span, Timestamp};

    #[cfg(feature = "mutants")]
    #[test]
    fn one_that_believes_the_host_runs_back() {
        let runs_back = |mutant| {
            let mut time = OwnTime::new(crate::mutant::Planted::new(mutant));
            let before = time.hear(Timestamp::from_nanos(700));
            time.hear(Timestamp::from_nanos(10)) < before
        };
        assert!(runs_back(Some(crate::mutant::Mutant::HostClockBelieved)));
        assert!(!runs_back(None));
    }

    proptest! {
        #[test]
        fn it_goes_on_by_what_passes_wherever_the_hosts_clock_is_set(
            steps in prop::collection::vec((0i64..1_000, -5_000i64..0), 1..50)
        ) {
            let mut time = OwnTime::default();
            let mut told = Timestamp::from_nanos(10);
            let mut passed = time.hear(told);
            for (after_ms, set_ms) in steps {
                told += Span::from_millis(after_ms);
                passed += Span::from_millis(after_ms);
                prop_assert_eq!(time.at(told), passed);
                prop_assert_eq!(time.hear(told), passed);
                prop_assert_eq!(time.told(passed), told);
                // A step back: no time has passed.
                told += Span::from_millis(set_ms);
                prop_assert_eq!(time.at(told), passed);
                prop_assert_eq!(time.hear(told), passed);
            }
            prop_assert_eq!(time.told(Timestamp::MAX), Timestamp::MAX);
        }
    }
}
