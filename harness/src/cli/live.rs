//! Where the command line meets the live world.

use super::failure::Failure;
use super::setup::{Controller, LiveSetup};
use super::terminal::Terminal;
use crate::run::{Completed, Options, Prepared};
use crate::world::simulated::Progress;

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
    person: Option<&Terminal>,
    pulse: &mut impl FnMut(Progress) -> bool,
) -> Result<Completed, Failure> {
    use crate::operator::Person;
    use crate::world::live::DeviceUnderTest;
    let device_under_test = match &setup.controller {
        Controller::InProcess => DeviceUnderTest::InProcess,
        Controller::Process => DeviceUnderTest::OurProcess,
        Controller::Command(line) => {
            DeviceUnderTest::Command(line.split_whitespace().map(str::to_owned).collect())
        }
    };
    let person = person.map(|terminal| Box::new(terminal.clone()) as Box<dyn Person>);
    let run = crate::run_live::run_live_to_folder;
    Ok(run(prepared, options, device_under_test, &setup.bench, person, pulse)?)
}

/// This build has no live world.
#[cfg(not(feature = "live"))]
pub(super) fn run(
    _: &Prepared,
    _: &Options<'_>,
    setup: &LiveSetup,
    _: Option<&Terminal>,
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
