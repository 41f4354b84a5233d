//! The controller's time, which never runs back.
//!
//! The host's clock may be set back. What waits for a moment of the future would then wait for longer, and a time-out would
//! not run out: the base would go on unheard. So the time of the controller goes on from where it was.

use crate::mutant::{Mutant, Planted};
use wire::time::{Span, Timestamp};

/// From the host's clock to time that never runs back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct OwnTime {
    last: Option<Timestamp>,
    /// Own time less the host's: by how much its clock has been set back in all.
    ahead: Span,
    planted: Planted,
}

impl OwnTime {
    pub(crate) fn new(planted: Planted) -> Self {
        Self { planted, ..Self::default() }
    }

    /// The host's clock says `told`.
    pub(crate) fn hear(&mut self, told: Timestamp) -> Timestamp {
        let own = self.at(told);
        self.ahead = own - told;
        self.last = Some(own);
        own
    }

    /// The same for one who only looks.
    pub(crate) fn at(&self, told: Timestamp) -> Timestamp {
        if self.planted.is(Mutant::HostClockBelieved) {
            return told;
        }
        let own = told + self.ahead;
        self.last.map_or(own, |last| own.max(last))
    }

    /// What the host's clock will say then.
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
                // Set back: nothing has passed.
                told += Span::from_millis(set_ms);
                prop_assert_eq!(time.at(told), passed);
                prop_assert_eq!(time.hear(told), passed);
            }
            prop_assert_eq!(time.told(Timestamp::MAX), Timestamp::MAX);
        }
    }
}
