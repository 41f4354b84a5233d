//! Keeps a campaign running when a controller panics.

use super::case::{Case, CaseResult, PANIC, Violated};
use super::executor::Executor;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Carries out a case and turns a panic of the controller into a broken property.
pub(super) fn guarded(executor: &(impl Executor + ?Sized), case: &Case) -> CaseResult {
    caught(|| executor.execute(case), |panicked| panicked)
}

/// The result of `work`, or, if the controller panicked, the result that `of` makes of such a case.
pub fn caught<T>(work: impl FnOnce() -> T, of: impl FnOnce(CaseResult) -> T) -> T {
    let panic = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(given) => return given,
        Err(panic) => panic,
    };
    of(CaseResult {
        violated: vec![Violated {
            property: PANIC.to_owned(),
            at_s: 0.0,
            what: message(panic.as_ref()),
        }],
        ..CaseResult::ended("panicked")
    })
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "a panic without words".to_owned())
}

/// An executor whose panics do not end the campaign.
pub(super) struct Guarded<'a, E>(pub(super) &'a E);

impl<E: Executor> Executor for Guarded<'_, E> {
    fn execute(&self, case: &Case) -> CaseResult {
        let result = guarded(self.0, case);
        // The result is not requested again: if shrinking is repeated, so is this case.
        self.0.kept(case);
        result
    }

    fn execute_until(&self, case: &Case, property: &str) -> CaseResult {
        let result = caught(|| self.0.execute_until(case, property), |panicked| panicked);
        self.0.kept(case);
        result
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }

    fn takes(&self, case: &Case) -> bool {
        self.0.takes(case)
    }
}
