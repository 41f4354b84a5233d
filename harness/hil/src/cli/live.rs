//! Runs in real time, started from the command line.

use super::failure::Failure;
use super::setup::{Controller, LiveSetup};
use harness::operator::Person;
use harness::run::{Completed, Options, Prepared};
use harness::run_live::LiveRunError;
use record::Progress;
use views::watch::Feed;

/// The interface that `--bus vcan` means.
const VCAN: &str = "vcan0";

#[cfg(feature = "nats")]
impl LiveSetup {
    /// A setup from a bench file that describes a whole bench; defaults for the rest.
    pub(super) const fn of(bench: plan::bench_file::BenchFile) -> Self {
        let bus = super::setup::BusChoice::Pty;
        Self { controller: Controller::Process, bench, bus, realtime: false }
    }
}

/// Runs a prepared plan in real time and writes its run folder, as
/// [`run_to_folder`](harness::run::run_to_folder) does in virtual time.
///
/// # Errors
///
/// When the bench file cannot be used, the bench does not come up, or the run folder cannot be made.
pub(super) fn run(
    prepared: &Prepared,
    options: &Options<'_>,
    setup: &LiveSetup,
    person: Option<Box<dyn Person>>,
    feed: Option<&Feed>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, LiveRunError> {
    use harness::run_live::run_live_to_folder_watched;
    run_live_to_folder_watched(prepared, options, &asked(setup), person, feed, pulse)
}

/// Returns the bench that a prepared plan would run on.
///
/// # Errors
///
/// When it does not fit the plan.
pub(super) fn setting(
    prepared: &Prepared,
    setup: &LiveSetup,
) -> Result<live::world::Setting, Failure> {
    Ok(asked(setup).resolve(&prepared.rig)?)
}

fn asked(setup: &LiveSetup) -> harness::run_live::LiveSetting<'_> {
    use super::setup::BusChoice;
    use harness::run_live::LiveSetting;
    use live::world::{DeviceUnderTest, Scheduling};
    use ports::PortSpec;
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
