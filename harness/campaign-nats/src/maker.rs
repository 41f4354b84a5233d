//! Who makes what carries out the cases of a package.

use super::message::Place;
use super::package::Package;
use campaign::Executor;
use std::sync::Arc;
use tokio::sync::watch;

/// Makes who carries out the cases of a package at a place, and names its plan; or says why that cannot be. A case that
/// is broken off (see [`CaseResult::is_given_up`](campaign::CaseResult::is_given_up)) is handed back, and the worker ends.
pub type Maker = Arc<
    dyn Fn(&Package, &Place, Stopping) -> Result<(String, Arc<dyn Executor + Send + Sync>), String>
        + Send
        + Sync,
>;

/// Tells whether the worker is to end: it was asked to, or the bench is another's. What is quick is finished all the same; what
/// takes minutes is broken off.
#[derive(Debug, Clone)]
pub struct Stopping(pub(super) watch::Receiver<bool>);

impl Stopping {
    /// Is it?
    pub fn is_so(&self) -> bool {
        *self.0.borrow()
    }
}
