//! Unmodified programs under test in virtual time. `docs/virtual-time.md` states the guarantees.

mod controller;
mod in_step;
mod uarts;

pub use controller::start as start_controller;
pub use in_step::start as start_node;
