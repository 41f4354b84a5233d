//! Which world a plan runs in: clock, bus and device under test, and which of them go together.

use super::failure::Failure;
use crate::bench_file::BenchFile;
use crate::world::crossing::KernelBus;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;

/// What makes time pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Clock {
    /// Time jumps to the next event: 16 hours in seconds.
    Virtual,
    /// A second is a second.
    Real,
}

/// What bytes and frames cross.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BusChoice {
    /// Lines in memory, paced by baud or bit time.
    Memory,
    /// Serial lines on pseudo-terminals of the kernel; with the real clock, or the ports of a bench file.
    Pty,
    /// The same, and CAN frames on the kernel's interface vcan0.
    Vcan,
    /// The same, and CAN frames as the lines of an slcan adapter on a pseudo-terminal.
    Slcan,
}

/// The device under test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Controller {
    /// Our controller, in this process.
    InProcess,
    /// Our controller, as a process of its own.
    Process,
    /// Anybody's program.
    Command(String),
}

impl FromStr for Controller {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "" => Err("expected in-process, process or a command".to_owned()),
            "in-process" => Ok(Self::InProcess),
            "process" => Ok(Self::Process),
            command => Ok(Self::Command(command.to_owned())),
        }
    }
}

/// Clock, bus, device under test and bench.
#[derive(Debug, Clone, Args)]
pub(super) struct SetupArguments {
    /// What makes time pass.
    #[arg(long, value_enum, default_value_t = Clock::Virtual)]
    clock: Clock,
    /// What bytes and frames cross; memory with the virtual clock, pty with the real one.
    #[arg(long, value_enum)]
    bus: Option<BusChoice>,
    /// The device under test: in-process, process, or a command line. In-process with the virtual
    /// clock, process with the real one.
    #[arg(long, value_name = "in-process|process|COMMAND")]
    controller: Option<Controller>,
    /// Bench file: which port plays which role; a name (see `hil list benches`) or a path. Without it
    /// every device is emulated.
    #[arg(long, value_name = "FILE")]
    bench: Option<String>,
}

/// The world that a plan runs in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Setup {
    /// Virtual time, lines in memory, the controller in the process.
    Simulated,
    /// The same, with everything on a line sent through the kernel on its way.
    Kernel(KernelBus),
    /// Real time and ports.
    Live(Box<LiveSetup>),
}

/// What the live world must be told beyond the plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LiveSetup {
    /// The device under test.
    pub(super) controller: Controller,
    /// The bench.
    pub(super) bench: BenchFile,
}

impl Setup {
    /// The file of answers that the bench names.
    pub(super) fn answer_file(&self) -> Option<PathBuf> {
        match self {
            Self::Simulated | Self::Kernel(_) => None,
            Self::Live(setup) => Some(setup.bench.answers.as_ref()?.file.clone()),
        }
    }
}

impl SetupArguments {
    /// The world that they mean.
    ///
    /// # Errors
    ///
    /// When they do not go together.
    pub(super) fn setup(&self) -> Result<Setup, Failure> {
        match (self.clock, self.bus) {
            (Clock::Virtual, None | Some(BusChoice::Memory)) => self.simulated(Setup::Simulated),
            (Clock::Virtual, Some(BusChoice::Pty)) => self.simulated(Setup::Kernel(KernelBus::Pty)),
            (Clock::Virtual, Some(BusChoice::Vcan)) => {
                self.simulated(Setup::Kernel(KernelBus::Vcan))
            }
            (Clock::Virtual, Some(BusChoice::Slcan)) => {
                self.simulated(Setup::Kernel(KernelBus::Slcan))
            }
            (Clock::Real, None | Some(BusChoice::Pty)) => Ok(Setup::Live(Box::new(LiveSetup {
                controller: self.controller.clone().unwrap_or(Controller::Process),
                bench: match &self.bench {
                    Some(name) => BenchFile::load(name)?,
                    None => BenchFile::default(),
                },
            }))),
            (Clock::Real, Some(BusChoice::Memory)) => Err(Failure::arguments(
                "the real clock needs the pty bus: nothing waits for real time in memory",
                "leave --clock out, or use --bus pty",
            )),
            (Clock::Real, Some(BusChoice::Vcan | BusChoice::Slcan)) => Err(Failure::arguments(
                "the real clock needs the pty bus: the live world opens no CAN bus yet",
                "leave --clock out, or use --bus pty",
            )),
        }
    }

    /// A setup in virtual time.
    fn simulated(&self, setup: Setup) -> Result<Setup, Failure> {
        if !matches!(self.controller, None | Some(Controller::InProcess)) {
            return Err(Failure::arguments(
                "the virtual clock needs the controller in the process: another process has its \
                 own time",
                "add --clock real, or leave --controller out",
            ));
        }
        if self.bench.is_some() {
            return Err(Failure::arguments(
                "the virtual clock has no use for a bench file: real ports keep real time",
                "add --clock real, or leave --bench out",
            ));
        }
        Ok(setup)
    }
}

#[cfg(test)]
mod tests {
    use super::{
        BenchFile, BusChoice, Clock, Controller, KernelBus, LiveSetup, Setup, SetupArguments,
    };

    fn setup(
        clock: Clock,
        bus: Option<BusChoice>,
        controller: Option<&str>,
    ) -> Result<Setup, String> {
        let controller = controller.map(|text| text.parse().unwrap());
        let arguments = SetupArguments { clock, bus, controller, bench: None };
        arguments.setup().map_err(|failure| failure.to_string())
    }

    #[test]
    fn what_goes_together() {
        assert_eq!(setup(Clock::Virtual, None, None), Ok(Setup::Simulated));
        assert_eq!(
            setup(Clock::Virtual, Some(BusChoice::Memory), Some("in-process")),
            Ok(Setup::Simulated)
        );
        for (bus, kernel) in [
            (BusChoice::Pty, KernelBus::Pty),
            (BusChoice::Vcan, KernelBus::Vcan),
            (BusChoice::Slcan, KernelBus::Slcan),
        ] {
            assert_eq!(setup(Clock::Virtual, Some(bus), None), Ok(Setup::Kernel(kernel)));
        }
        let live = |controller| {
            Ok(Setup::Live(Box::new(LiveSetup { controller, bench: BenchFile::default() })))
        };
        assert_eq!(setup(Clock::Real, None, None), live(Controller::Process));
        let command = Controller::Command("./mine --fast".to_owned());
        assert_eq!(setup(Clock::Real, Some(BusChoice::Pty), Some("./mine --fast")), live(command));
    }

    #[test]
    fn what_does_not_go_together_says_why() {
        for (clock, bus, controller) in [
            (Clock::Virtual, Some(BusChoice::Vcan), Some("process")),
            (Clock::Real, Some(BusChoice::Memory), None),
            (Clock::Virtual, None, Some("process")),
            (Clock::Virtual, None, Some("./mine")),
        ] {
            let why = setup(clock, bus, controller).unwrap_err();
            assert!(why.contains(" clock needs the "), "{why}");
        }
        let bench = Some("mine.toml".to_owned());
        let arguments =
            SetupArguments { clock: Clock::Virtual, bus: None, controller: None, bench };
        assert!(arguments.setup().is_err());
    }

    #[test]
    fn no_command_is_no_controller() {
        assert!(" ".parse::<Controller>().is_err());
    }
}
