//! Programs under test in virtual time: anybody's, unmodified. `docs/virtual-time.md` says what that guarantees.

mod controller;
mod in_step;

pub use controller::start as start_controller;
pub use in_step::start as start_node;
