//! Programs of nodes under test in virtual time: anybody's, unmodified. `docs/virtual-time.md` says what that guarantees.

#[cfg(feature = "programs")]
mod in_step;

use crate::hosted::NodeDevice;
use crate::plan::Rig;
use std::path::PathBuf;

/// Name of the file that keeps what the device under test printed, or its stderr where its stdout is for reports.
pub const DEVICE_LOG: &str = "device-under-test.log";

/// The programs of one run.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// Where what they print is kept; nowhere without.
    log: Option<PathBuf>,
}

impl Programs {
    /// What they print is kept in this file; with several programs in one beside it each.
    pub(crate) const fn logging(log: PathBuf) -> Self {
        Self { log: Some(log) }
    }

    /// Starts the program of a node by its place; none where nothing is to be started.
    #[cfg(feature = "programs")]
    pub(crate) fn start(
        &self,
        rig: &Rig,
        place: usize,
    ) -> Option<Result<Box<dyn NodeDevice>, String>> {
        in_step::start(self.log.as_deref(), rig, place)
    }

    /// Starts nothing: nobody can.
    #[cfg(not(feature = "programs"))]
    pub(crate) fn start(&self, _: &Rig, _: usize) -> Option<Result<Box<dyn NodeDevice>, String>> {
        let _ = &self.log;
        None
    }
}
