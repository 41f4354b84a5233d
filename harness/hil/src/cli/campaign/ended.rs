//! The outcome of a campaign, for the exit status.

use campaign::Campaign;
use record::outcome::Outcome;

/// A campaign in which no case has a verdict has shown nothing. In virtual time one such case is enough, because the machine
/// has no part in it: what is under test, or a fault, made it end so. One that was stopped is aborted, whatever it found.
pub(super) fn outcome(done: &Campaign, is_virtual: bool) -> Outcome {
    let tally = &done.tally;
    let times = |name| tally.outcomes.get(name).copied().unwrap_or(0);
    let (errors, unjudged) = (times("error"), times("error") + times("worker_lost"));
    let holds = done.found.is_empty() && done.missed.is_empty();
    match (done.stopped, holds) {
        (true, _) => Outcome::Aborted,
        (false, false) => Outcome::Failed,
        (false, true) if unjudged > 0 && unjudged == tally.cases => Outcome::Error,
        (false, true) if is_virtual && errors > 0 => Outcome::Error,
        (false, true) => Outcome::Passed,
    }
}

#[cfg(test)]
mod tests {
    use super::{Campaign, Outcome, outcome};
    use campaign::Tally;

    #[test]
    fn a_campaign_of_cases_without_a_verdict_holds_nothing() {
        let done_in = |is_virtual, outcomes: &[(&str, u64)]| {
            let cases = outcomes.iter().map(|(_, times)| times).sum();
            let outcomes = outcomes.iter().map(|(name, times)| ((*name).to_owned(), *times));
            let tally = Tally { cases, outcomes: outcomes.collect(), ..Tally::default() };
            let (found, never, missed) = <_>::default();
            outcome(&Campaign { tally, found, never, missed, stopped: false }, is_virtual)
        };
        let done = |outcomes: &[(&str, u64)]| done_in(false, outcomes);
        assert_eq!(done(&[("error", 3), ("worker_lost", 2)]), Outcome::Error);
        assert_eq!(done(&[("error", 3), ("passed", 2)]), Outcome::Passed);
        // Found by a user: a program that set a wrong baud rate after a fault, and a campaign that held.
        assert_eq!(done_in(true, &[("error", 3), ("passed", 2)]), Outcome::Error);
        assert_eq!(done_in(true, &[("worker_lost", 3), ("passed", 2)]), Outcome::Passed);
        assert_eq!(done(&[]), Outcome::Passed);
        let (tally, found, never, missed) = <_>::default();
        let stopped = Campaign { tally, found, never, missed, stopped: true };
        assert_eq!(outcome(&stopped, true), Outcome::Aborted);
    }

    #[test]
    fn a_state_that_the_plan_demands_is_reached() {
        let done = |missed: &[&str]| {
            let missed: Vec<String> = missed.iter().map(|&state| state.to_owned()).collect();
            let (tally, found, never) = (Tally::default(), Vec::new(), vec!["bus_off".to_owned()]);
            outcome(&Campaign { tally, found, never, missed, stopped: false }, true)
        };
        assert_eq!(done(&[]), Outcome::Passed);
        assert_eq!(done(&["bus_off"]), Outcome::Failed);
    }
}
