//! Rigs from the plan's point of view: lines, the nodes on them, and the messages of each.
//!
//! ```toml
//! title = "A battery pack and its manager"
//!
//! [[line]]
//! name = "can0"
//! can = { bit_rate = 250_000, dbc = "pack.dbc" }
//! message.Limits = { counter = { signal = "Alive" }, checksum = { signal = "Crc", crc = "crc8-sae-j1850" } }
//!
//! [[node]]                    # the device under test
//! name = "manager"
//! at = "can0"
//! under_test = { command = ["python3", "manager.py", "{can0}"] }
//!
//! [[node]]
//! name = "cells"
//! at = "can0"
//! emulate = "cells"           # devices/cells.toml
//!
//! [[node]]                    # the plan itself sends what is left of the bus
//! name = "tester"
//! at = "can0"
//! tester = true
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `devices` | the paper's robot or table of this device file, with its controller; its lines are `gyro` and `base` or `table` |
//! | `[[line]]` | `can = { bit_rate, data_bit_rate, dbc }` with one DBC or an array of several, a classic bus without `data_bit_rate`, or `serial = {}`, whose settings are those of the device on it |
//! | `message.NAME` of a line | counter and checksum of a message of its DBC: `counter`, `checksum` or `e2e` as in the description of a device |
//! | `[[node]]` | `at`: a line, or several; one of `emulate` (and `set`: parameters of that one), `under_test` (and `described_by`: its messages), `tester` and `replay = { log, channel }` |
//! | `virtual_time` | of a program under test: `wall_limit_s`, `processes_max`, `spin_questions`, `spin_step_s` |
//! | `dbc_node` | the node's name in the DBC, if it differs |
//!
//! `devices = "paper"` and `device = "oven"` in a plan stand for a rig with only that.

mod file;
mod struck;

pub use file::{CanTable, LineTable, NodeTable, ReplayTable, RigFile, SerialTable};

use crate::faults::{LineKind, Ride};
use crate::speakers::{DEVICE, Speaker};
use described::{Description, IsoTp, Layout, Medium, Sender};
use emulators::base::Transport;
use emulators::device_file::{Devices, Mount};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use wire::can::{BIT_RATE, BitRates};
use wire::device::Transmit;
use wire::time::Span;

/// Most nodes of a rig, including those of the paper's robot: one bit per node, plus one for the plan, in a word.
pub const NODES_MAX: usize = 62;
/// Most lines of a rig.
pub const LINES_MAX: usize = 16;

/// How the device under test is started.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum UnderTest {
    /// A program: its words, with `{line}` for the port of a line.
    Command(Vec<String>),
    /// Rust code of a test, in this process.
    InProcess(bool),
    /// It is there already: a program that runs, or a real device at the port of its line.
    Attached(bool),
}

/// What holds for a program in virtual time: `docs/virtual-time.md`. What is absent is as that says.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VirtualTime {
    /// How long in real time it may run without waiting, s.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 86400.0))]
    pub wall_limit_s: Option<f64>,
    /// How many processes it may have at once.
    #[serde(default)]
    #[schemars(range(min = 1))]
    pub processes_max: Option<u32>,
    /// How often it may ask without waiting before each further question takes a step.
    #[serde(default)]
    pub spin_questions: Option<u32>,
    /// How long that step is, s.
    #[serde(default)]
    #[schemars(range(min = 1e-9, max = 1.0))]
    pub spin_step_s: Option<f64>,
}

impl VirtualTime {
    /// The first limit that is out of its range, as a message.
    pub(crate) fn mistake(&self) -> Option<&'static str> {
        let is_outside = |value: Option<f64>, least: f64, most: f64| {
            value.is_some_and(|value| !(least..=most).contains(&value))
        };
        if is_outside(self.wall_limit_s, 0.1, 86_400.0) {
            Some("`wall_limit_s` is 0.1 s to a day")
        } else if is_outside(self.spin_step_s, 1e-9, 1.0) {
            Some("`spin_step_s` is a nanosecond to a second")
        } else if self.processes_max == Some(0) {
            Some("a program is one process at least")
        } else {
            None
        }
    }
}

/// A line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigLine {
    /// Its name.
    pub name: String,
    /// The medium.
    pub medium: Medium,
    /// Bits per second of a CAN bus, if the file states them.
    pub bit_rate: Option<u32>,
    /// Bits per second of the data of CAN FD frames, if there are any.
    pub data_bit_rate: Option<u32>,
}

impl RigLine {
    /// The line of a plan's only device.
    pub fn of_device(layout: &Layout) -> Self {
        Self {
            name: DEVICE.to_owned(),
            medium: layout.medium(),
            bit_rate: None,
            data_bit_rate: layout.fd_message().map(|_| DATA_BIT_RATE),
        }
    }

    /// The rates of a CAN bus.
    pub fn rates(&self) -> BitRates {
        BitRates { nominal: self.bit_rate.unwrap_or(BIT_RATE), data: self.data_bit_rate }
    }
}

/// `CAN, 250 kbit/s`, `serial, 9600 baud`.
impl fmt::Display for RigLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kilo = |rate: u32| f64::from(rate) / 1e3;
        match (self.medium, self.rates()) {
            (Medium::Serial(settings), _) => write!(f, "serial, {} baud", settings.baud),
            (Medium::Can, BitRates { nominal, data: None }) => {
                write!(f, "CAN, {} kbit/s", kilo(nominal))
            }
            (Medium::Can, BitRates { nominal, data: Some(data) }) => {
                write!(f, "CAN FD, {} and {} kbit/s", kilo(nominal), kilo(data))
            }
        }
    }
}

/// Data bit rate of the bus of a plan's only device if it has CAN FD messages. Assumption: the usual rate of vehicles.
const DATA_BIT_RATE: u32 = 2_000_000;

/// The traffic of a node in a log: time, index of its port, and content.
pub type Replayed = Arc<[(Span, u8, Transmit)]>;

/// The kind of a node.
#[derive(Debug, Clone)]
pub enum NodePart {
    /// Emulated, as described in a file.
    Described(Arc<Description>),
    /// Under test.
    UnderTest(UnderTest),
    /// The plan sends and receives in its place.
    Tester(Layout, Sender),
    /// Replayed from a log.
    Replayed(Replayed),
}

impl NodePart {
    /// Whether its supply can be switched without a person: it is emulated, or a program that `hil` starts.
    pub const fn is_powered(&self) -> bool {
        let started =
            matches!(self, Self::UnderTest(UnderTest::Command(_) | UnderTest::InProcess(_)));
        matches!(self, Self::Described(_)) || started
    }
}

/// A node.
#[derive(Debug, Clone)]
pub struct RigNode {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub part: NodePart,
    /// Its lines, in the order of its ports.
    pub lines: Vec<usize>,
    /// Limits of its program in virtual time.
    pub virtual_time: VirtualTime,
    /// The channel for diagnostic requests to it.
    pub isotp: Option<IsoTp>,
}

impl RigNode {
    /// A node on the line of a plan's only device.
    fn of_device(name: &str, part: NodePart) -> Self {
        let virtual_time = VirtualTime::default();
        let isotp = match &part {
            NodePart::Described(description) => description.isotp().cloned(),
            _ => None,
        };
        Self { name: name.to_owned(), part, lines: vec![0], virtual_time, isotp }
    }
}

/// The rig of a plan, parsed and checked.
#[derive(Debug, Clone, Default)]
pub struct Rig {
    /// All traffic is from a log that lasted so long. It has the times of arrival: nothing takes time on a line or waits.
    pub logged: Option<Span>,
    /// When the log has frames that no node of the rig sends, by line: they are left out.
    pub foreign: BTreeMap<String, Vec<Span>>,
    /// The paper's robot or table; its lines come before the others.
    pub robot: Option<Box<Devices>>,
    /// The lines, except those of the robot.
    pub lines: Vec<RigLine>,
    /// The nodes, except those of the robot.
    pub nodes: Vec<RigNode>,
    /// The senders of messages.
    pub speakers: Vec<Speaker>,
    /// Whether it has only a single device or the paper's robot.
    pub is_short: bool,
    /// What is doubtful in the files that it was built from, one sentence each.
    pub notes: Vec<String>,
}

/// The carrier of the gyro of these devices.
pub fn ride(devices: &Devices) -> Ride {
    match (devices.mount, &devices.base) {
        (Mount::Base, Some((Transport::Can, _))) => Ride::Base(LineKind::Can),
        (Mount::Base, Some((Transport::Serial, _))) => Ride::Base(LineKind::Serial),
        _ => Ride::Table,
    }
}

impl Rig {
    /// Only the paper's robot or table.
    pub fn of_robot(devices: Devices) -> Self {
        Self { robot: Some(Box::new(devices)), is_short: true, ..Self::default() }
    }

    /// A single device, with the plan at the other end of its line.
    pub fn of_device(description: Arc<Description>) -> Self {
        let layout = description.layout().clone();
        let line = RigLine::of_device(&layout);
        let speaker = Speaker {
            node: DEVICE.to_owned(),
            line: 0,
            line_name: line.name.clone(),
            layout: layout.clone(),
            sender: Sender::Device,
        };
        let host = NodePart::Tester(layout.clone(), Sender::Host);
        Self {
            lines: vec![line],
            nodes: vec![
                RigNode::of_device("host", host),
                RigNode::of_device(DEVICE, NodePart::Described(description)),
            ],
            speakers: vec![speaker],
            is_short: true,
            ..Self::default()
        }
    }

    /// The nodes on each of their lines, by index; records identify senders by the position in this list.
    pub fn ends(&self) -> impl Iterator<Item = (usize, usize)> {
        let of = |(place, node): (usize, &RigNode)| {
            node.lines.iter().map(move |line| (place, *line)).collect::<Vec<_>>()
        };
        self.nodes.iter().enumerate().flat_map(of)
    }

    /// The name of a line.
    pub fn line_name(&self, line: usize) -> &str {
        match line.checked_sub(self.robot_lines()) {
            Some(place) => self.lines.get(place).map_or("", |line| &line.name),
            None if line == 0 => "gyro",
            None if matches!(self.ride(), Some(Ride::Table)) => "table",
            None => "base",
        }
    }

    /// Number of lines of the robot: those of `gyro` and of its carrier.
    pub const fn robot_lines(&self) -> usize {
        if self.robot.is_some() { 2 } else { 0 }
    }

    /// The carrier of the robot's gyro.
    pub fn ride(&self) -> Option<Ride> {
        self.robot.as_deref().map(ride)
    }

    /// The only device of a plan without a rig.
    pub fn device(&self) -> Option<&Arc<Description>> {
        self.nodes.iter().filter(|_| self.is_short).find_map(|node| match &node.part {
            NodePart::Described(description) => Some(description),
            _ => None,
        })
    }

    /// The emulated device with this name.
    pub fn described(&self, name: &str) -> Option<&Arc<Description>> {
        self.nodes.iter().filter(|node| node.name == name).find_map(|node| match &node.part {
            NodePart::Described(description) => Some(description),
            _ => None,
        })
    }

    /// Names of the emulated devices that files describe.
    pub fn described_names(&self) -> Vec<&str> {
        let described = |node: &&RigNode| matches!(node.part, NodePart::Described(_));
        self.nodes.iter().filter(described).map(|node| node.name.as_str()).collect()
    }

    /// The nodes whose supply is in our hands.
    pub fn powered_names(&self) -> Vec<&str> {
        let powered = self.nodes.iter().filter(|node| node.part.is_powered());
        powered.map(|node| node.name.as_str()).collect()
    }

    /// The nodes in whose place the plan sends, with their messages.
    pub fn testers(&self) -> impl Iterator<Item = (&str, &Layout, Sender)> {
        self.nodes.iter().filter_map(|node| match &node.part {
            NodePart::Tester(layout, sender) => Some((node.name.as_str(), layout, *sender)),
            _ => None,
        })
    }

    /// The channels on which the tester at this place can ask other nodes: those on its first line, if that is a bus.
    pub fn channels(&self, tester: usize) -> impl Iterator<Item = (&str, &IsoTp)> {
        let line = self.nodes.get(tester).and_then(|node| node.lines.first());
        let is_bus =
            |line: &&usize| self.lines.get(**line).is_some_and(|line| line.medium == Medium::Can);
        let line = line.filter(is_bus);
        let is_there = move |node: &&RigNode| line.is_some_and(|line| node.lines.contains(line));
        let nodes = self.nodes.iter().filter(is_there);
        nodes.filter_map(|node| Some((node.name.as_str(), node.isotp.as_ref()?)))
    }

    /// The nodes that a tester can ask.
    pub fn asked(&self) -> impl Iterator<Item = &str> {
        let testers = self.nodes.iter().enumerate();
        let testers = testers.filter(|(_, node)| matches!(node.part, NodePart::Tester(..)));
        testers.flat_map(|(place, _)| self.channels(place).map(|(node, _)| node))
    }

    /// The bus of a line among those of the rig's own, on which faults send frames.
    pub fn bus_of(&self, line: usize) -> Option<usize> {
        let line = line.checked_sub(self.robot_lines()).filter(|_| !self.is_short)?;
        let is_bus = |line: &&RigLine| line.medium == Medium::Can;
        self.lines.get(line).filter(is_bus)?;
        Some(self.lines[..line].iter().filter(is_bus).count())
    }

    /// Whether a node on this line, an index into the lines that are not the robot's, runs outside this process.
    pub fn is_away(&self, line: usize) -> bool {
        self.away_at(line).next().is_some()
    }

    /// The nodes on this line that run outside this process.
    pub fn away_at(&self, line: usize) -> impl Iterator<Item = &str> {
        let line = self.robot_lines() + line;
        let is_away = move |(node, how): &(&RigNode, &UnderTest)| {
            node.lines.contains(&line) && !matches!(how, UnderTest::InProcess(_))
        };
        self.under_test().filter(is_away).map(|(node, _)| node.name.as_str())
    }

    /// Names of the nodes under test, except the paper's controller.
    pub fn under_test_names(&self) -> Vec<&str> {
        self.under_test().map(|(node, _)| node.name.as_str()).collect()
    }

    /// The nodes under test, except the paper's controller.
    pub fn under_test(&self) -> impl Iterator<Item = (&RigNode, &UnderTest)> {
        self.nodes.iter().filter_map(|node| match &node.part {
            NodePart::UnderTest(how) => Some((node, how)),
            _ => None,
        })
    }
}
