//! What people and build servers are shown of a run, a campaign or an identification. Nothing here decides.
//!
//! * [`console`]: tables. [`junit`]: for a build server.
//! * `report` (feature `report`): one page with its figures.
//! * [`watch`](mod@watch): a run while it goes on, as a model without a terminal.

pub mod console;
pub mod junit;
#[cfg(feature = "report")]
pub mod report;
pub mod watch;
