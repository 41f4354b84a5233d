//! Who carries out a case.

use super::case::{Case, CaseResult, Repeated};
use record::outcome::Outcome;
use wire::time::Span;

/// Carries out cases. The same case gives the same result, but on a real bench. One that is interrupted gives a
/// result that ended [`Outcome::Aborted`]: nobody learns from it.
pub trait Executor: Sync {
    /// Carries out `case`.
    fn execute(&self, case: &Case) -> CaseResult;

    /// How long the plan takes where nothing goes wrong, and what one run comes to then. What has no plan takes no time.
    fn without_faults(&self, seed: u64) -> (Span, CaseResult) {
        (Span::ZERO, self.execute(&Case { seed, ..Case::default() }))
    }

    /// What all repetitions of `case` show of `property`, afresh. Where the same case always comes to the same, once is
    /// enough.
    ///
    /// # Errors
    ///
    /// How a run ended that says nothing: [`Outcome::Error`] where the bench broke, [`Outcome::Aborted`] where it was
    /// given up.
    fn confirm(&self, case: &Case, property: &str) -> Result<Repeated, Outcome> {
        let broke = u64::from(self.execute(case).breaks(property));
        Ok(Repeated { broke, of: 1, at_least: broke as f64 })
    }

    /// What came of `case` is kept: this executor need not remember it any longer.
    fn kept(&self, _case: &Case) {}

    /// Can `case` be carried out at all?
    fn takes(&self, _case: &Case) -> bool {
        true
    }
}
