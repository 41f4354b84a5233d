//! The interface that carries out cases.

use super::case::{Case, CaseResult, Repeated};
use super::course::Course;
use record::outcome::Outcome;

/// Carries out cases. The same case gives the same result, except on a real bench. An interrupted case ends as
/// [`Outcome::Aborted`]; its result is not used.
pub trait Executor: Sync {
    /// Carries out `case`.
    fn execute(&self, case: &Case) -> CaseResult;

    /// Executes `case` to find out whether it breaks `property`. The run may [stop](CaseResult::stopped) as soon as it does.
    fn execute_until(&self, case: &Case, _property: &str) -> CaseResult {
        self.execute(case)
    }

    /// Whether the campaign is to stop: no further case is worth its time.
    fn is_stopped(&self) -> bool {
        false
    }

    /// How a run without faults goes by, and its result. It takes no time for an executor without a plan.
    fn without_faults(&self, seed: u64) -> (Course, CaseResult) {
        (Course::default(), self.execute(&Case { seed, ..Case::default() }))
    }

    /// The result of repeating `case` afresh, for `property`. If a case always gives the same result, one run suffices.
    ///
    /// # Errors
    ///
    /// The outcome of a run that says nothing: [`Outcome::Error`] if the bench failed, [`Outcome::Aborted`] if it was
    /// interrupted.
    fn confirm(&self, case: &Case, property: &str) -> Result<Repeated, Outcome> {
        let broke = u64::from(self.execute(case).breaks(property));
        Ok(Repeated { broke, of: 1, at_least: broke as f64 })
    }

    /// The result of `case` has been stored: the executor need not keep it any longer.
    fn kept(&self, _case: &Case) {}

    /// Whether `case` can be carried out at all.
    fn takes(&self, _case: &Case) -> bool {
        true
    }
}
