//! What people and build servers are shown of a run, a campaign or an identification. Nothing here decides.
//!
//! * [`console`]: tables for a terminal.
//! * `report`, `junit` (feature `report`): one page with its figures, and a file for a build server.
//! * `drawing` (feature `report`): a rig as a picture.
//! * [`watch`](mod@watch): a run while it goes on, as a model without a terminal.

pub mod console;
#[cfg(feature = "report")]
pub mod drawing;
#[cfg(feature = "report")]
pub mod junit;
#[cfg(feature = "report")]
pub mod report;
pub mod watch;
