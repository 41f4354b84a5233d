//! Who carries out a case.

use super::case::{Case, CaseResult};

/// Carries out cases. The same case gives the same result, but on a real bench.
pub trait Executor: Sync {
    /// Carries out `case`.
    fn execute(&self, case: &Case) -> CaseResult;

    /// Can `case` be carried out at all?
    fn takes(&self, case: &Case) -> bool {
        let _ = case;
        true
    }
}
