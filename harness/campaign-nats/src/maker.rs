//! Makes executors for packages.

use super::message::Place;
use super::package::Package;
use campaign::Executor;
use std::sync::Arc;
use tokio::sync::watch;

/// Makes the executor for the cases of a package at a place, and returns it with the name of its plan, or the reason
/// why that is impossible. An interrupted case (see [`CaseResult::is_given_up`](campaign::CaseResult::is_given_up)) is
/// handed back, and the worker ends.
pub type Maker = Arc<
    dyn Fn(&Package, &Place, Stopping) -> Result<(String, Arc<dyn Executor + Send + Sync>), String>
        + Send
        + Sync,
>;

/// Tells whether the worker is to end, on request or because it lost the bench. Short work is still finished; work of
/// minutes is interrupted.
#[derive(Debug, Clone)]
pub struct Stopping(pub(super) watch::Receiver<bool>);

impl Stopping {
    pub fn is_so(&self) -> bool {
        *self.0.borrow()
    }
}
