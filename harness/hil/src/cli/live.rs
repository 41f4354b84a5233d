//! What the command line asks of a bench, as the bench takes it.

use super::setup::{BusChoice, Controller, LiveSetup};
use harness::run::Prepared;
use harness::run_live::LiveSetting;
use live::world::{DeviceUnderTest, PlacementError, Scheduling, Setting};
use ports::PortSpec;

/// The interface that `--bus vcan` means.
const VCAN: &str = "vcan0";

impl LiveSetup {
    /// A setup from a bench file that describes a whole bench; defaults for the rest.
    #[cfg(feature = "nats")]
    pub(super) const fn of(bench: plan::bench_file::BenchFile) -> Self {
        Self { controller: Controller::Process, bench, bus: BusChoice::Pty, realtime: false }
    }

    /// The bench that a prepared plan would run on.
    ///
    /// # Errors
    ///
    /// When it does not fit the plan.
    pub(super) fn of_plan(&self, prepared: &Prepared) -> Result<Setting, PlacementError> {
        self.asked().resolve(&prepared.rig)
    }

    /// What the command line asks for.
    pub(super) fn asked(&self) -> LiveSetting<'_> {
        let device_under_test = match &self.controller {
            Controller::InProcess => DeviceUnderTest::InProcess,
            Controller::Process => DeviceUnderTest::OurProcess,
            Controller::Command(line) => {
                DeviceUnderTest::Command(line.split_whitespace().map(str::to_owned).collect())
            }
        };
        let can = match self.bus {
            BusChoice::Vcan => PortSpec::Can { interface: VCAN.to_owned() },
            BusChoice::Memory | BusChoice::Pty | BusChoice::Slcan => {
                PortSpec::SlcanPty { link: None }
            }
        };
        let scheduling = if self.realtime { Scheduling::RealTime } else { Scheduling::Normal };
        LiveSetting { device_under_test, bench: &self.bench, can, scheduling }
    }
}
