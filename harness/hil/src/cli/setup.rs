//! The world that a plan runs in: clock, bus and device under test, and which of them go together.

use super::failure::Failure;
use super::lease;
use super::progress::Screen;
use clap::{Args, ValueEnum};
use harness::hosted::{ControllerProgram, Hosting};
use harness::run::Prepared;
use harness::run_live::LiveSetting;
use live::crossing::VCAN_INTERFACE;
use live::lease::Lease;
use live::world::{DeviceUnderTest, Scheduling};
use plan::Rig;
use plan::bench_file::BenchFile;
use plan::rig::UnderTest;
use ports::PortSpec;
use rig::crossing::KernelBus;
use std::path::PathBuf;
use std::str::FromStr;

/// The clock of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Clock {
    /// Time jumps to the next event: 16 hours take seconds.
    Virtual,
    /// A second is a second.
    Real,
}

/// What carries bytes and frames, where a bench file does not say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BusChoice {
    /// Lines in memory, paced by baud or bit time.
    Memory,
    /// Pseudo-terminals; with the real clock a device on CAN is behind an SLCAN adapter on one.
    Pty,
    /// A device on CAN is on the interface vcan0; serial lines are pseudo-terminals.
    Vcan,
    /// A device on CAN is behind an SLCAN adapter on a pseudo-terminal; serial lines are
    /// pseudo-terminals.
    Slcan,
}

/// The device under test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Controller {
    InProcess,
    /// Our controller, as a separate process.
    Process,
    Command(String),
}

impl Controller {
    /// How it is started in virtual time; our controller in this process by default.
    pub(super) fn hosting(named: Option<&Self>) -> Hosting {
        match named {
            None | Some(Self::InProcess) => Hosting::default(),
            Some(Self::Process) => Hosting::program(ControllerProgram::Ours),
            Some(Self::Command(line)) => Hosting::program(ControllerProgram::Words(words(line))),
        }
    }

    /// The same for a run called `name`, which must have a robot if a controller is named.
    pub(super) fn of_robot(
        named: Option<&Self>,
        rig: &Rig,
        name: &str,
    ) -> Result<Hosting, Failure> {
        if named.is_none() || rig.robot.is_some() {
            return Ok(Self::hosting(named));
        }
        let message =
            format!("--controller has no meaning for {name}: it has no controller of a robot");
        Err(Failure::arguments(message, "leave it out: the rig names what is under test"))
    }
}

/// The words of a command line: there is no shell.
pub(super) fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

impl FromStr for Controller {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "" => Err("expected in-process, process or a command".to_owned()),
            "in-process" => Ok(Self::InProcess),
            "process" => Ok(Self::Process),
            command if command.contains(['\'', '"']) => {
                Err("quotes mean nothing without a shell: put the command into a script".to_owned())
            }
            command => Ok(Self::Command(command.to_owned())),
        }
    }
}

/// Clock, bus, device under test and bench.
#[derive(Debug, Clone, Args)]
pub(super) struct SetupArguments {
    /// The clock of the run.
    #[arg(long, value_enum, default_value_t = Clock::Virtual)]
    pub(super) clock: Clock,
    /// What carries bytes and frames. [default: memory with the virtual clock, pty with the real one]
    #[arg(long, value_enum)]
    pub(super) bus: Option<BusChoice>,
    /// The controller of the paper's robot: in-process, process, or a command line with {gyro} and {base} for the
    /// ports; a rig file names its programs itself. [default: in-process with the virtual clock, process with the real one]
    #[arg(long, value_name = "in-process|process|COMMAND")]
    pub(super) controller: Option<Controller>,
    /// Bench file, which assigns ports to roles: a name (see `hil list benches`) or a path. Without
    /// it every device is emulated.
    #[arg(long, value_name = "FILE")]
    pub(super) bench: Option<String>,
    /// How long to wait for a bench that somebody else uses, s.
    #[arg(long, value_name = "S", requires = "bench", default_value_t = 0)]
    wait: u32,
    /// Ask for real-time priority and locked memory; without the permission the run continues
    /// without them.
    #[arg(long)]
    pub(super) realtime: bool,
}

/// The world that a plan runs in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Setup {
    /// Virtual time, lines in memory, the controller in the process.
    Simulated,
    /// Virtual time, with all traffic sent through the kernel.
    Kernel(KernelBus),
    /// Real time and ports.
    Live(Box<LiveSetting>),
}

impl Setup {
    fn bench(&self) -> Option<&BenchFile> {
        match self {
            Self::Simulated | Self::Kernel(_) => None,
            Self::Live(setup) => Some(&setup.bench),
        }
    }

    pub(super) fn answer_file(&self) -> Option<PathBuf> {
        Some(self.bench()?.answers.as_ref()?.file.clone())
    }

    pub(super) fn real_nodes(&self) -> Vec<String> {
        self.bench().map(BenchFile::real_nodes).unwrap_or_default()
    }
}

impl SetupArguments {
    /// Returns the world that the arguments describe.
    ///
    /// # Errors
    ///
    /// When they do not go together.
    pub(super) fn setup(&self) -> Result<Setup, Failure> {
        let kernel = |bus| self.simulated(Setup::Kernel(bus));
        match (self.clock, self.bus) {
            (Clock::Virtual, None | Some(BusChoice::Memory)) => self.simulated(Setup::Simulated),
            (Clock::Virtual, Some(BusChoice::Pty)) => kernel(KernelBus::Pty),
            (Clock::Virtual, Some(BusChoice::Vcan)) => kernel(KernelBus::Vcan),
            (Clock::Virtual, Some(BusChoice::Slcan)) => kernel(KernelBus::Slcan),
            (Clock::Real, Some(BusChoice::Memory)) => Err(Failure::arguments(
                "the real clock needs the pty bus: nothing waits for real time in memory",
                "leave --clock out, or use --bus pty",
            )),
            (Clock::Real, bus) => Ok(Setup::Live(Box::new(LiveSetting {
                device_under_test: match &self.controller {
                    Some(Controller::InProcess) => DeviceUnderTest::InProcess,
                    None | Some(Controller::Process) => DeviceUnderTest::OurProcess,
                    Some(Controller::Command(line)) => DeviceUnderTest::Command(words(line)),
                },
                bench: self.bench.as_deref().map(BenchFile::load).transpose()?.unwrap_or_default(),
                can: match bus {
                    Some(BusChoice::Vcan) => PortSpec::Can { interface: VCAN_INTERFACE.to_owned() },
                    _ => PortSpec::SlcanPty { link: None },
                },
                scheduling: if self.realtime { Scheduling::RealTime } else { Scheduling::Normal },
                repetition: None,
            }))),
        }
    }

    /// Returns the bench file that alone describes a bench elsewhere: the machine with that bench has the same file.
    ///
    /// # Errors
    ///
    /// When it is missing, or another argument adds to it.
    #[cfg(feature = "nats")]
    pub(super) fn bench_elsewhere(&self) -> Result<&str, Failure> {
        let beside = [
            ("--controller", self.controller.is_some(), "its table [controller]"),
            ("--bus", self.bus.is_some(), "the port of its table [base]"),
            ("--realtime", self.realtime, "`realtime = true` in its table [timing]"),
        ];
        let Some(bench) = &self.bench else {
            return Err(Failure::arguments(
                "which bench carries the cases out? its worker takes those of one bench file alone",
                "add --bench FILE, and start `hil worker --nats URL --bench FILE` on the machine of the bench; or \
                 leave out --clock: workers without a bench keep virtual time",
            ));
        };
        if let Some((argument, _, instead)) = beside.iter().find(|(_, is_given, _)| *is_given) {
            return Err(Failure::arguments(
                format!(
                    "{argument} does not reach a worker: over a server the bench file says all of a bench"
                ),
                format!("write it into {bench}: {instead}"),
            ));
        }
        Ok(bench)
    }

    /// Checks that these plans can be tested with this setup.
    ///
    /// # Errors
    ///
    /// When a plan has no place for the given controller, or a program would have to keep virtual time.
    pub(super) fn fits(&self, plans: &[Prepared]) -> Result<(), Failure> {
        for Prepared { plan, rig, .. } in plans {
            let name = plan.name.as_str();
            if self.controller.is_some() && rig.robot.is_none() {
                let help = match rig.is_short {
                    true => {
                        "describe a rig in which your program is a node: `under_test = { command = [...] }`"
                    }
                    false => {
                        "the rig file names what is under test: `under_test = { command = [...] }`"
                    }
                };
                let what = format!(
                    "--controller has no meaning for {name}: no controller of a robot is in it"
                );
                return Err(Failure::arguments(what, help));
            }
            let mut under_test = rig.under_test();
            let is_absent = |how: &UnderTest| !matches!(how, UnderTest::Command(_));
            let absent = under_test.find(|(_, how)| is_absent(how));
            if let (Clock::Virtual, Some((node, _))) = (self.clock, absent) {
                let what = format!(
                    "node `{}` of {name} is real, and no program that `hil` starts, so it cannot run in virtual time",
                    node.name
                );
                let help = "add --clock real; in a Rust test, `Trial::with_node` puts code of yours in its place";
                return Err(Failure::arguments(what, help));
            }
        }
        Ok(())
    }

    /// Takes the lease on the bench, where there is one.
    ///
    /// # Errors
    ///
    /// If another user holds it.
    pub(super) fn lease(
        &self,
        setup: &Setup,
        stopped: &dyn Fn() -> bool,
        screen: &Screen,
    ) -> Result<Option<Lease>, Failure> {
        match (setup, &self.bench) {
            (Setup::Live(live), Some(name)) => {
                lease::take((name, &live.bench), self.wait, stopped, screen)
            }
            _ => Ok(None),
        }
    }

    pub(super) fn hosting(&self) -> Hosting {
        Controller::hosting(self.controller.as_ref())
    }

    /// Options that a run in virtual time needs to repeat a case of a campaign.
    pub(super) fn replay(&self) -> String {
        match &self.controller {
            None | Some(Controller::InProcess) => String::new(),
            Some(Controller::Process) => "--controller process".to_owned(),
            Some(Controller::Command(line)) => format!("--controller '{line}'"),
        }
    }

    /// Checks that the controller is the one in this process; `what` supports no other.
    ///
    /// # Errors
    ///
    /// When it is a program.
    pub(super) fn in_process(&self, what: &str) -> Result<(), Failure> {
        match self.controller {
            None | Some(Controller::InProcess) => Ok(()),
            Some(Controller::Process | Controller::Command(_)) => Err(Failure::arguments(
                format!("{what} needs the controller in the process"),
                "leave out --controller",
            )),
        }
    }

    fn simulated(&self, setup: Setup) -> Result<Setup, Failure> {
        if self.bench.is_some() {
            return Err(Failure::arguments(
                "a bench file needs the real clock: its ports keep real time",
                "add --clock real, or leave --bench out",
            ));
        }
        if self.realtime {
            return Err(Failure::arguments(
                "the virtual clock has no use for --realtime: nothing in it can be late",
                "add --clock real, or leave --realtime out",
            ));
        }
        Ok(setup)
    }
}

#[cfg(test)]
mod tests;
