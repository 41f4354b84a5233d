//! Where and how a plan is run in real time, and what that bench shows and lets be struck.

use super::bench_work::{BenchWork, NoCommand};
use super::device_under_test::{DeviceUnderTest, StartError};
use super::placement::{Placement, Player};
use super::programs::Program;
use super::realtime::Scheduling;
use judge::properties::{Sight, View};
use plan::faults::{Fault, FaultKind, Schedule, Target};
use plan::{DEVICE, Plan};
use ports::{PortError, PortSpec};
use std::fmt;
use std::path::PathBuf;
use wire::time::Span;

/// Why a live run cannot begin.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum LiveError {
    /// A port of the harness cannot be opened.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Port(#[from] PortError),
    /// The device under test does not start.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Start(#[from] StartError),
    /// The bench's own commands did not set it up.
    #[error("failed to set the bench up: {why}")]
    #[diagnostic(help("what its commands wrote is in {}", folder.display()))]
    Setup {
        /// Why.
        why: String,
        /// Where that is kept.
        folder: PathBuf,
    },
    /// Somebody wanted it to end before it began.
    #[error("stopped by request before the run began")]
    Stopped,
    /// No runtime for the select loop.
    #[error("failed to start the event loop")]
    #[diagnostic(help("are there file descriptors left? `ulimit -n` tells how many are allowed"))]
    Runtime(#[from] std::io::Error),
}

/// A fault that this bench cannot suffer: bad input, as it is known before the run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("failed to inject fault {index}, {name}: {why}")]
#[diagnostic(help("{help}"))]
pub struct OutOfReach {
    /// Its place in the schedule.
    pub index: usize,
    /// Its kind and target: `burst_loss of gyro`.
    pub name: String,
    /// Why it cannot be injected here.
    pub why: String,
    /// What to do.
    pub help: String,
}

/// What of a plan this bench cannot do: bad input, as it is known before the run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum Unfit {
    /// A fault cannot be injected.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] OutOfReach),
    /// A command is missing.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Command(#[from] NoCommand),
}

/// Where and how a plan is run in real time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// What is tested.
    pub device_under_test: DeviceUnderTest,
    /// Nodes that are tested, with or without it.
    pub programs: Vec<Program>,
    /// Where its devices are.
    pub site: Site,
    /// What the bench does by commands of its own.
    pub work: BenchWork,
    /// How long an attached device under test may take until it is heard.
    pub attach_max: Span,
    /// How late the harness may be with anything.
    pub late_max: Span,
    /// What the scheduler is asked for.
    pub scheduling: Scheduling,
}

/// Where the devices of a run are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Site {
    /// Gyro, base and table, and lines of other nodes.
    Robot(Placement, Vec<LineSite>),
    /// The only device.
    Device(Player),
    /// Lines of a rig that somebody is at who is not in this process.
    Lines(Vec<LineSite>),
}

/// Where a line of a rig is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineSite {
    /// Which line, by its place in the rig.
    pub line: usize,
    /// The port of the nodes that are emulated here.
    pub spec: PortSpec,
}

impl Site {
    /// What crosses the ports, in a word for the summary: the kinds of port.
    pub fn bus(&self) -> String {
        match self {
            Self::Robot(placement, lines) => {
                let others = lines.iter().map(|line| format!("+{}", line.spec.kind()));
                placement.bus() + &others.collect::<String>()
            }
            Self::Device(player) => player.spec().kind().to_owned(),
            Self::Lines(lines) => {
                let mut kinds: Vec<&str> = lines.iter().map(|line| line.spec.kind()).collect();
                kinds.dedup();
                if kinds.is_empty() { "memory".to_owned() } else { kinds.join("+") }
            }
        }
    }

    /// Who plays a role; none where nobody does.
    pub fn player(&self, role: &str) -> Option<&Player> {
        match self {
            Self::Robot(placement, _) => placement.player(role),
            Self::Device(player) => (role == DEVICE).then_some(player),
            Self::Lines(_) => None,
        }
    }
}

impl Setting {
    /// What is tested, as a summary names it.
    pub fn under_test(&self) -> String {
        let controller = Some(self.device_under_test.to_string()).filter(|name| !name.is_empty());
        let programs = self.programs.iter().map(Program::to_string);
        controller.into_iter().chain(programs).collect::<Vec<_>>().join(", ")
    }

    /// A real device that the controller alone talks to. A bus of the kernel is heard by the harness, too.
    pub(super) fn is_unheard(&self, role: &str) -> bool {
        let player = self.site.player(role);
        matches!(player, Some(Player::Real(spec)) if !matches!(spec, PortSpec::Can { .. }))
    }

    /// Where the base is.
    pub(super) fn base_port(&self) -> Option<&PortSpec> {
        self.site.player("base").map(Player::spec)
    }

    /// Can everything that `plan` asks for be done here?
    ///
    /// # Errors
    ///
    /// The first thing that cannot.
    pub fn fits(&self, plan: &Plan) -> Result<(), Unfit> {
        self.reaches(&plan.faults)?;
        Ok(self.work.check(plan)?)
    }

    /// Can every fault of `schedule` be injected here?
    ///
    /// # Errors
    ///
    /// The first that cannot.
    pub fn reaches(&self, schedule: &Schedule) -> Result<(), OutOfReach> {
        for (index, fault) in schedule.faults.iter().enumerate() {
            if let Some((why, help)) = self.shelter(fault.target) {
                return Err(OutOfReach { index, name: fault.to_string(), why, help });
            }
        }
        Ok(())
    }

    /// Can a fault of this kind be injected here?
    pub fn can_suffer(&self, target: Target, what: FaultKind) -> bool {
        self.reaches(&Schedule { faults: vec![Fault::new(target, what)] }).is_ok()
    }

    /// Why nothing can be done to this target, and what would change that; `None` where it can. Lines are
    /// carried by the harness up to the port of an emulated device, whose switches are its, too.
    fn shelter(&self, target: Target) -> Option<(String, String)> {
        let player = match target {
            Target::Gyro | Target::Base | Target::Table | Target::Device => {
                self.site.player(target.name())
            }
            Target::Host if self.device_under_test == DeviceUnderTest::InProcess => None,
            Target::Host => {
                let why = "the controller is a program of its own, whose machine and clock are not the \
                           harness's";
                let help = "test the controller in the process: `--controller in-process`, or leave the \
                            fault out";
                return Some((why.to_owned(), help.to_owned()));
            }
            // A person's answers go through the harness on every bench, and so do the lines of a rig.
            Target::Operator | Target::Node(_) => None,
        };
        let Some(Player::Real(spec)) = player else { return None };
        let name = target.name();
        Some((
            format!(
                "the {name} is real ({spec}): its line is not carried by the harness, and it has no switches"
            ),
            format!(
                "emulate it: leave [{name}] out of the bench file, or the fault out of the plan"
            ),
        ))
    }

    /// What this bench shows of a run.
    pub fn sight(&self) -> Sight {
        let mut sight = Sight::whole();
        let within = self.device_under_test == DeviceUnderTest::InProcess;
        for role in ["gyro", "base"] {
            let Some(Player::Real(spec)) = self.site.player(role) else { continue };
            sight = sight.without(View::Truth, format!("the {role} is real ({spec})"));
            // A bus of the kernel is heard by the harness, too.
            if within || matches!(spec, PortSpec::Can { .. }) {
                continue;
            }
            let alone = format!(
                "the {role} is real ({spec}), and the controller, a program of its own, has its port alone"
            );
            let lines: &[View] = match role {
                "gyro" => &[View::GyroLine],
                _ => &[View::BaseReplies, View::BaseRequests, View::BusStates],
            };
            for line in lines {
                sight = sight.without(*line, alone.clone());
            }
        }
        if !within {
            let why = "the controller is a program of its own, and a line of JSON has no word for a number that \
                       is none";
            sight = sight.without(View::PlainReports, why);
        }
        sight
    }
}

/// Which player is at which port, and what is tested: `gyro emulated at pty, base real at can:can0, controller process`.
impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for role in ["gyro", "base", "table", DEVICE] {
            let Some(player) = self.site.player(role) else { continue };
            let how = if player.is_emulated() { "emulated" } else { "real" };
            write!(f, "{role} {how} at {}, ", player.spec())?;
        }
        write!(f, "controller {}", self.device_under_test)
    }
}

#[cfg(test)]
mod tests {
    use super::{BenchWork, DeviceUnderTest, Placement, Scheduling, Setting, Site, Span};
    use controller::config::Transport;
    use judge::properties::Property;
    use plan::bench_file::BenchFile;
    use plan::faults::{Fault, FaultKind, Schedule, Target};
    use ports::PortSpec;

    fn setting(bench: &str, device_under_test: DeviceUnderTest) -> Setting {
        let bench: BenchFile = toml::from_str(bench).unwrap();
        let transport = if bench.table.is_some() { None } else { Some(Transport::Can) };
        let can = PortSpec::SlcanPty { link: None };
        Setting {
            device_under_test,
            site: Site::Robot(Placement::new(&bench, transport, &can).unwrap(), Vec::new()),
            programs: Vec::new(),
            work: BenchWork::of(&bench),
            attach_max: Span::ZERO,
            late_max: Span::ZERO,
            scheduling: Scheduling::Normal,
        }
    }

    fn refused(setting: &Setting, target: Target, name: &str) -> String {
        let what = FaultKind::typical(name).unwrap();
        let schedule = Schedule { faults: vec![Fault::new(target, what)] };
        match setting.reaches(&schedule) {
            Ok(()) => format!("{}: taken", schedule.faults[0]),
            Err(refused) => refused.to_string(),
        }
    }

    #[test]
    fn what_is_emulated_can_be_struck_and_what_is_real_cannot() {
        let bench = "[gyro]\nport = \"/dev/ttyUSB0\"";
        let process = setting(bench, DeviceUnderTest::OurProcess);
        let here = setting("", DeviceUnderTest::InProcess);
        let table = setting("[table]\nport = \"/dev/ttyUSB1\"", DeviceUnderTest::InProcess);
        let lines = [
            refused(&process, Target::Gyro, "drop"),
            refused(&process, Target::Base, "wheel_slip"),
            refused(&process, Target::Host, "clock_step"),
            refused(&process, Target::Operator, "wrong_sign"),
            refused(&here, Target::Gyro, "drop"),
            refused(&here, Target::Host, "clock_step"),
            refused(&table, Target::Table, "lost_steps"),
        ];
        insta::assert_snapshot!(lines.join("\n"));
    }

    #[test]
    fn a_bench_is_named_by_its_ports() {
        let bench = setting("[base]\nport = \"can:can0\"", DeviceUnderTest::OurProcess);
        assert_eq!(
            bench.to_string(),
            "gyro emulated at pty, base real at can:can0, controller process"
        );
    }

    #[test]
    fn what_is_judged_depends_on_who_has_the_lines() {
        let cases = [
            ("all emulated, in process", "", DeviceUnderTest::InProcess),
            ("all emulated, a process", "", DeviceUnderTest::OurProcess),
            (
                "a real base on a bus of the kernel, a process",
                "[base]\nport = \"can:can0\"",
                DeviceUnderTest::OurProcess,
            ),
            (
                "all real on serial lines, a process",
                "[gyro]\nport = \"/dev/ttyUSB0\"\n[base]\nport = \"slcan:/dev/ttyACM0\"",
                DeviceUnderTest::OurProcess,
            ),
            (
                "the same, in process",
                "[gyro]\nport = \"/dev/ttyUSB0\"\n[base]\nport = \"slcan:/dev/ttyACM0\"",
                DeviceUnderTest::InProcess,
            ),
        ];
        let shown: Vec<String> = cases
            .into_iter()
            .map(|(title, bench, device)| {
                let (_, unjudged) = setting(bench, device).sight().divide(&Property::all());
                let lines = unjudged.iter().map(|one| format!("\n  {}: {}", one.name, one.why));
                format!("{title}:{}", lines.collect::<String>())
            })
            .collect();
        insta::assert_snapshot!(shown.join("\n"));
    }
}
