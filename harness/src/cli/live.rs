//! Where the command line meets the live world: this function, and nothing else, is to be connected.

use super::failure::Failure;
use super::setup::LiveSetup;
use crate::run::{Completed, Options, Prepared};
use crate::world::simulated::Progress;

/// Runs a prepared plan in real time and writes its run folder, as
/// [`run_to_folder`](crate::run::run_to_folder) does in virtual time.
///
/// # Errors
///
/// Always: this build has no live world.
pub(super) fn run(
    _prepared: &Prepared,
    _options: &Options<'_>,
    _setup: &LiveSetup,
    _pulse: &mut impl FnMut(Progress) -> bool,
    _wall_s: &impl Fn() -> f64,
) -> Result<Completed, Failure> {
    Err(Failure::arguments(
        "the live world is not available in this build",
        "leave out --clock, --bus, --controller and --bench to run in virtual time",
    ))
}
