//! Runs in virtual time across the kernel's buses.

use super::failure::Failure;
use harness::run::{Completed, Options, Prepared};
use record::Progress;
use rig::crossing::KernelBus;
use views::watch::Feed;

/// Opens and closes the buses that each plan crosses, so that a missing bus does not cost the hours of the plans before
/// it.
///
/// # Errors
///
/// When this machine lacks the bus, or a bench does not fit it.
pub(super) fn check(bus: KernelBus, plans: &[Prepared]) -> Result<(), Failure> {
    for prepared in plans {
        opened(bus, prepared)?;
    }
    Ok(())
}

/// Runs a prepared plan in virtual time across the kernel and writes its run folder, as
/// [`run_to_folder`](harness::run::run_to_folder) does in memory.
///
/// # Errors
///
/// When the bus cannot be opened, or the run folder cannot be made.
pub(super) fn run(
    bus: KernelBus,
    prepared: &Prepared,
    options: &Options<'_>,
    feed: Option<&Feed>,
    pulse: &mut impl FnMut(Progress) -> bool,
    wall_s: &impl Fn() -> f64,
) -> Result<Completed, Failure> {
    let kernel = opened(bus, prepared)?;
    Ok(harness::run::run_to_folder_watched(kernel, prepared, options, feed, pulse, wall_s)?)
}

fn opened(bus: KernelBus, prepared: &Prepared) -> Result<live::crossing::Kernel, Failure> {
    use live::crossing::Kernel;
    Ok(Kernel::open(bus, &prepared.crossed_lines())?)
}
