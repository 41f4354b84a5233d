//! Where and how a plan runs in real time, what that bench shows, and which faults it allows.

use super::bench_work::{BenchWork, NoCommand};
use super::device_under_test::DeviceUnderTest;
use super::placement::{Placement, Player};
use super::programs::Program;
use super::realtime::Scheduling;
use judge::properties::{Sight, View};
use plan::faults::{Fault, FaultKind, Reach, Schedule, Target};
use plan::{DEVICE, Plan};
use ports::PortSpec;
use std::fmt;
use wire::time::Span;

/// A fault that this bench does not allow, detected before the run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("failed to inject fault {index}, {name}: {why}")]
#[diagnostic(help("{help}"))]
pub struct OutOfReach {
    /// Index in the schedule.
    pub index: usize,
    /// Kind and target: `burst_loss of gyro`.
    pub name: String,
    /// Why it cannot be injected here.
    pub why: String,
    pub help: String,
}

/// What of a plan this bench cannot do: bad input, as it is known before the run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum Unfit {
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] OutOfReach),
    #[error(transparent)]
    #[diagnostic(transparent)]
    Command(#[from] NoCommand),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    pub device_under_test: DeviceUnderTest,
    /// Nodes under test, with or without it.
    pub programs: Vec<Program>,
    pub site: Site,
    pub work: BenchWork,
    /// Time limit for the first report of an attached device under test.
    pub attach_max: Span,
    pub late_max: Span,
    pub scheduling: Scheduling,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Site {
    /// Gyro, base and table, and lines of other nodes.
    Robot(Placement, Vec<LineSite>),
    Device(Player),
    /// Lines of a rig with nodes outside this process.
    Lines(Vec<LineSite>),
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineSite {
    pub line: usize,
    /// Port of the nodes that are emulated here.
    pub spec: PortSpec,
    /// The line and its nodes outside this process, if there are several and the port is one of a bus: what one of them sends
    /// reaches the others without the harness.
    pub beyond: Vec<String>,
}

impl Site {
    /// Kinds of the ports, in a word for the summary.
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

    /// Player of a role; `None` if no device plays it.
    pub fn player(&self, role: &str) -> Option<&Player> {
        match self {
            Self::Robot(placement, _) => placement.player(role),
            Self::Device(player) => (role == DEVICE).then_some(player),
            Self::Lines(_) => None,
        }
    }
}

impl Setting {
    pub fn under_test(&self) -> String {
        let controller = Some(self.device_under_test.to_string()).filter(|name| !name.is_empty());
        let programs = self.programs.iter().map(Program::to_string);
        controller.into_iter().chain(programs).collect::<Vec<_>>().join(", ")
    }

    /// Whether only the controller talks to this real device. The harness also listens on a bus of the kernel.
    pub(super) fn is_unheard(&self, role: &str) -> bool {
        let player = self.site.player(role);
        matches!(player, Some(Player::Real(spec)) if !matches!(spec, PortSpec::Can { .. }))
    }

    pub(super) fn base_port(&self) -> Option<&PortSpec> {
        self.site.player("base").map(Player::spec)
    }

    /// Can everything that `plan` asks for be done here?
    ///
    /// # Errors
    /// The first thing that cannot.
    pub fn fits(&self, plan: &Plan) -> Result<(), Unfit> {
        self.reaches(&plan.faults)?;
        Ok(self.work.check(plan)?)
    }

    /// Checks that every fault of `schedule` can be injected here.
    ///
    /// # Errors
    /// The first fault that cannot.
    pub fn reaches(&self, schedule: &Schedule) -> Result<(), OutOfReach> {
        for (index, fault) in schedule.faults.iter().enumerate() {
            let found = self.shelter(fault.target).or_else(|| self.beyond(fault));
            if let Some((why, help)) = found {
                return Err(OutOfReach { index, name: fault.to_string(), why, help });
            }
        }
        Ok(())
    }

    /// Whether a fault of this kind can be injected here.
    pub fn can_suffer(&self, target: Target, what: FaultKind) -> bool {
        self.reaches(&Schedule { faults: vec![Fault::new(target, what)] }).is_ok()
    }

    /// Why this target cannot be struck, and how to change that; `None` if it can. The harness carries lines up to the
    /// port of an emulated device, and controls that device.
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
            // On every bench the harness handles a person's answers and the lines of a rig.
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

    /// Why a fault cannot strike what nodes outside this process send to one another; `None` if it need not.
    fn beyond(&self, fault: &Fault) -> Option<(String, String)> {
        let (Site::Lines(lines) | Site::Robot(_, lines)) = &self.site else { return None };
        let reach = fault.what.info().reach;
        let is_carried = reach.is_line() || matches!(reach, Reach::Message(_));
        if !is_carried || fault.what.makes_frames() {
            return None;
        }
        let is_struck = |site: &&LineSite| site.beyond.iter().any(|one| one == fault.target.node());
        let LineSite { spec, beyond, .. } = lines.iter().find(is_struck)?;
        let nodes: Vec<String> = beyond.iter().skip(1).map(|node| format!("`{node}`")).collect();
        Some((
            format!(
                "{} are on the bus at {spec}, where what one of them sends reaches the others without the harness",
                nodes.join(" and ")
            ),
            "emulate the node that the fault strikes, or leave the fault out of the plan"
                .to_owned(),
        ))
    }

    /// What this bench shows of a run.
    pub fn sight(&self) -> Sight {
        let mut sight = Sight::whole();
        let within = self.device_under_test == DeviceUnderTest::InProcess;
        for role in ["gyro", "base"] {
            let Some(Player::Real(spec)) = self.site.player(role) else { continue };
            sight = sight.without(View::Truth, format!("the {role} is real ({spec})"));
            // The harness also listens on a bus of the kernel.
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

/// Players, ports and device under test: `gyro emulated at pty, base real at can:can0, controller process`.
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
    use super::{BenchWork, DeviceUnderTest, LineSite, Placement, Scheduling, Setting, Site, Span};
    use controller::config::Transport;
    use judge::properties::Property;
    use plan::bench_file::BenchFile;
    use plan::faults::{Fault, FaultKind, Schedule, Target, TargetName};
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

    /// Found by a user: a drive that was "unplugged" by a fault went on talking to the product, which passed.
    #[test]
    fn what_real_nodes_send_one_another_cannot_be_struck() {
        let mut bench = setting("", DeviceUnderTest::Nodes);
        let site = |beyond: &[&str]| {
            let beyond = beyond.iter().map(|one| (*one).to_owned()).collect();
            let spec = PortSpec::Can { interface: "vcan0".to_owned() };
            Site::Lines(vec![LineSite { line: 0, spec, beyond }])
        };
        let node = |name: &str| Target::Node(TargetName::new(name).unwrap());
        bench.site = site(&["can0", "drive", "product"]);
        for (target, kind) in [
            ("drive", "disconnect"),
            ("can0", "drop"),
            ("product.Off", "delay"),
            ("drive.Speed", "signal_value"),
        ] {
            let why = refused(&bench, node(target), kind);
            let expected = "`drive` and `product` are on the bus at can:vcan0, where what one of them sends reaches";
            assert!(why.contains(expected), "{why}");
        }
        for (target, kind) in [("can0", "bus_load"), ("drive", "restart"), ("lamp", "drop")] {
            assert!(refused(&bench, node(target), kind).ends_with("taken"), "{target}");
        }
        bench.site = site(&[]);
        assert!(refused(&bench, node("drive"), "disconnect").ends_with("taken"));
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
