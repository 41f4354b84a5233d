//! The end of a run because a device under test is gone.

use super::Engine;
use wire::time::Timestamp;

/// What the reason says of the controller of a robot.
pub(super) const CONTROLLER_LOST: &str = "the device under test ";
/// The same of another node, behind its name.
const NODE_LOST: &str = "`, which is under test, ";

/// Whether a note of the plan says that a device under test is gone.
pub(crate) fn is_of_lost(note: &str) -> bool {
    note.starts_with(CONTROLLER_LOST) || (note.starts_with('`') && note.contains(NODE_LOST))
}

impl Engine {
    /// Ends the run as failed: a node under test is gone, and nothing else broke. `how` says what it did.
    pub fn lost_node(&mut self, now: Timestamp, node: &str, how: &str) {
        self.lost(now, &format!("`{node}{NODE_LOST}{how}"));
    }

    pub(super) fn lost(&mut self, now: Timestamp, what: &str) {
        let is_first = self.ending.is_none();
        self.failed(now, what);
        if let Some(ending) = &mut self.ending {
            ending.lost |= is_first;
        }
    }
}
