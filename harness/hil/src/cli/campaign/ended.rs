//! The outcome of a campaign, for the exit status.

use campaign::Campaign;
use record::outcome::Outcome;

/// A campaign in which no case has a verdict has shown nothing. One that was stopped is aborted, whatever it found.
pub(super) fn outcome(done: &Campaign) -> Outcome {
    let tally = &done.tally;
    let unjudged = ["error", "worker_lost"].map(|name| tally.outcomes.get(name).unwrap_or(&0));
    let unjudged: u64 = unjudged.into_iter().sum();
    match (done.stopped, done.found.is_empty()) {
        (true, _) => Outcome::Aborted,
        (false, false) => Outcome::Failed,
        (false, true) if unjudged > 0 && unjudged == tally.cases => Outcome::Error,
        (false, true) => Outcome::Passed,
    }
}

#[cfg(test)]
mod tests {
    use super::{Campaign, Outcome, outcome};
    use campaign::Tally;

    #[test]
    fn a_campaign_of_cases_without_a_verdict_holds_nothing() {
        let done = |outcomes: &[(&str, u64)]| {
            let cases = outcomes.iter().map(|(_, times)| times).sum();
            let outcomes = outcomes.iter().map(|(name, times)| ((*name).to_owned(), *times));
            let tally = Tally { cases, outcomes: outcomes.collect(), ..Tally::default() };
            outcome(&Campaign { tally, found: Vec::new(), never: Vec::new(), stopped: false })
        };
        assert_eq!(done(&[("error", 3), ("worker_lost", 2)]), Outcome::Error);
        assert_eq!(done(&[("error", 3), ("passed", 2)]), Outcome::Passed);
        assert_eq!(done(&[]), Outcome::Passed);
        let (tally, found, never) = <_>::default();
        assert_eq!(outcome(&Campaign { tally, found, never, stopped: true }), Outcome::Aborted);
    }
}
