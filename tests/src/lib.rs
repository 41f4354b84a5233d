//! Shared by the scenarios.
//!
//! * [`rig`]: controller and emulated devices joined by paced lines, stepped by hand, with taps on every direction; for
//!   scenarios about the controller.
//! * [`devices`]: ideal devices, and those that ship.
//! * [`harm`]: damage to a packet in transit.
//! * [`plans`]: plans given as text, run in the simulated world; for scenarios about the engine.
//! * [`project`]: a folder with the files that a plan names, and the plan loaded from it.
//! * [`rooms`]: the sources of the workspace, for checks of the house rules.

pub mod devices;
pub mod harm;
pub mod plans;
pub mod project;
pub mod rig;
pub mod rooms;
