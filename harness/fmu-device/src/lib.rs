//! A described device as a functional mock-up unit for co-simulation, FMI 2.0 and 3.0.
//!
//! Signals that the device sends are outputs: what the last message said. Signals that it receives are inputs: a message is
//! received at the beginning of a step if one of its signals has changed, or each time if the device would notice its absence.
//! Parameters are tunable. The fixed parameter [`SEED`] is the seed of its random numbers.
//!
//! Compiled as a shared library this crate is the library in each such unit. It reads the device's files from the unit's
//! resources, where [`packed`] says they are.

mod c;
mod files;
mod model_description;
mod three;
mod two;
mod unit;
mod variables;

pub use files::{DEVICE, packed};
pub use model_description::{Version, model_description};

/// The name of the parameter with the seed.
pub const SEED: &str = "hil.seed";

/// The name of the library without the end `.so`.
pub const IDENTIFIER: &str = "hil_device";

/// The file that this crate is as a shared library.
pub const LIBRARY: &str = "libfmu_device.so";
