//! Where the command line meets the live world.

use super::failure::Failure;
use super::setup::{Controller, LiveSetup};
use crate::operator::Person;
use crate::record::Progress;
use crate::run::{Completed, Options, Prepared};
use crate::watch::Feed;

/// The interface that `--bus vcan` means.
#[cfg(feature = "live")]
const VCAN: &str = "vcan0";

/// Runs a prepared plan in real time and writes its run folder, as
/// [`run_to_folder`](crate::run::run_to_folder) does in virtual time.
///
/// # Errors
///
/// When the bench file cannot be used, the bench does not come up, or the run folder cannot be made.
#[cfg(feature = "live")]
pub(super) fn run(
    prepared: &Prepared,
    options: &Options<'_>,
    setup: &LiveSetup,
    person: Option<Box<dyn Person>>,
    feed: Option<&Feed>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, Failure> {
    use crate::run_live::run_live_to_folder_watched;
    Ok(run_live_to_folder_watched(prepared, options, &asked(setup), person, feed, pulse)?)
}

/// The bench that a prepared plan would be run on.
///
/// # Errors
///
/// When it does not fit the plan.
#[cfg(feature = "live")]
pub(super) fn setting(
    prepared: &Prepared,
    setup: &LiveSetup,
) -> Result<crate::world::live::Setting, Failure> {
    let devices = prepared.subject.robot().ok_or_else(|| {
        Failure::arguments(
            format!("{} is of a device of your own, and campaigns in real time are of robots and tables", prepared.plan.name),
            "leave out --clock: the device is emulated in virtual time",
        )
    })?;
    Ok(asked(setup).resolve(crate::world::bench::base_transport(devices))?)
}

/// What the command line asks for.
#[cfg(feature = "live")]
fn asked(setup: &LiveSetup) -> crate::run_live::LiveSetting<'_> {
    use super::setup::BusChoice;
    use crate::port::PortSpec;
    use crate::run_live::LiveSetting;
    use crate::world::live::{DeviceUnderTest, Scheduling};
    let device_under_test = match &setup.controller {
        Controller::InProcess => DeviceUnderTest::InProcess,
        Controller::Process => DeviceUnderTest::OurProcess,
        Controller::Command(line) => {
            DeviceUnderTest::Command(line.split_whitespace().map(str::to_owned).collect())
        }
    };
    let can = match setup.bus {
        BusChoice::Vcan => PortSpec::Can { interface: VCAN.to_owned() },
        BusChoice::Memory | BusChoice::Pty | BusChoice::Slcan => PortSpec::SlcanPty { link: None },
    };
    let scheduling = if setup.realtime { Scheduling::RealTime } else { Scheduling::Normal };
    LiveSetting { device_under_test, bench: &setup.bench, can, scheduling }
}

/// This build has no live world.
#[cfg(not(feature = "live"))]
pub(super) fn run(
    _: &Prepared,
    _: &Options<'_>,
    setup: &LiveSetup,
    _: Option<Box<dyn Person>>,
    _: Option<&Feed>,
    _: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, Failure> {
    let wanted = match &setup.controller {
        Controller::Command(line) => line,
        Controller::InProcess | Controller::Process => "our controller",
    };
    Err(Failure::arguments(
        format!("this build has no live world for {wanted}"),
        "build with the feature `live`, or run in virtual time",
    ))
}
