//! Where the command line meets the buses of the kernel in virtual time.

use super::failure::Failure;
use crate::record::Progress;
use crate::run::{Completed, Options, Prepared};
use crate::watch::Feed;
use crate::world::crossing::KernelBus;

/// Opens and closes what each of the plans crosses, so that a bus that is missing does not cost the hours
/// of those before it.
///
/// # Errors
///
/// When this machine does not have it, or a bench does not fit it.
#[cfg(feature = "live")]
pub(super) fn check(bus: KernelBus, plans: &[Prepared]) -> Result<(), Failure> {
    for prepared in plans {
        opened(bus, prepared)?;
    }
    Ok(())
}

/// Runs a prepared plan in virtual time across the kernel and writes its run folder, as
/// [`run_to_folder`](crate::run::run_to_folder) does in memory.
///
/// # Errors
///
/// When the bus cannot be opened, or the run folder cannot be made.
#[cfg(feature = "live")]
pub(super) fn run(
    bus: KernelBus,
    prepared: &Prepared,
    options: &Options<'_>,
    feed: Option<&Feed>,
    pulse: &mut impl FnMut(Progress) -> bool,
    wall_s: &impl Fn() -> f64,
) -> Result<Completed, Failure> {
    let kernel = opened(bus, prepared)?;
    Ok(crate::run::run_to_folder_watched(kernel, prepared, options, feed, pulse, wall_s)?)
}

#[cfg(feature = "live")]
fn opened(bus: KernelBus, prepared: &Prepared) -> Result<crate::world::crossing::Kernel, Failure> {
    use crate::world::bench::Bench;
    use crate::world::crossing::Kernel;
    // What it is built with says how its base is connected; no number is drawn.
    let devices = prepared.subject.robot().ok_or_else(|| {
        Failure::arguments(
            format!(
                "{} is of a device of your own, which crosses no kernel in virtual time",
                prepared.plan.name
            ),
            "leave out --bus, or add --clock real",
        )
    })?;
    let bench = Bench::new(devices.clone(), 0);
    Ok(Kernel::open(bus, bench.base_transport())?)
}

/// This build opens no ports.
#[cfg(not(feature = "live"))]
fn refused() -> Failure {
    Failure::arguments(
        "this build opens no ports: its lines are in memory",
        "build with the feature `live`, or leave --bus out",
    )
}

/// This build has no bus of the kernel.
#[cfg(not(feature = "live"))]
pub(super) fn check(_: KernelBus, _: &[Prepared]) -> Result<(), Failure> {
    Err(refused())
}

/// This build has no bus of the kernel.
#[cfg(not(feature = "live"))]
pub(super) fn run(
    _: KernelBus,
    _: &Prepared,
    _: &Options<'_>,
    _: Option<&Feed>,
    _: &mut impl FnMut(Progress) -> bool,
    _: &impl Fn() -> f64,
) -> Result<Completed, Failure> {
    Err(refused())
}
