//! Builds working rigs from the rigs that plans declare.

use super::Rig;
use super::line::{End, EndId, Line};
use super::node::{BASE, GYRO, Machine, Node, Part};
use super::own::Own;
use super::replayed::Replaying;
use super::robot::{CARRIER, Robot};
use super::tester::Tester;
use crate::bench::Bench;
use crate::hosted::{Hosted, NodeDevice};
use controller::config::Transport;
use described::Medium;
use plan::Rig as Declared;
use plan::rig::{NodePart, RigLine};
use record::Device;
use std::sync::Arc;
use wire::can::BitRates;
use wire::device::PortId;

/// The other end of a serial line that has one node.
pub const NOBODY: &str = "nobody";

pub fn end(node: usize, port: PortId, who: Device, name: &str) -> End {
    End { node, port, who, name: name.into() }
}

/// The paper's robot or table with its controller; without `controller`, that node is away.
pub fn paper(bench: Bench, controller: Option<Hosted>) -> Rig {
    let (stream, transport) = (bench.gyro_stream(), bench.base_transport());
    let mut rig = Rig::default();
    let robot = rig.node(Node::new("robot", Part::Robot(Box::new(Robot::new(bench)))));
    let part = match controller {
        Some(controller) => Part::Controller(Box::new(Machine::new(controller))),
        None => Part::Away,
    };
    let controller = rig.node(Node::new("controller", part));
    let device = end(robot, super::robot::GYRO, Device::Gyro, "gyro");
    let host = end(controller, GYRO, Device::Controller, "controller");
    rig.line("gyro", Line::serial(stream.format.serial(), vec![device, host]));
    let device = end(robot, CARRIER, Device::Base, "base");
    let host = end(controller, BASE, Device::Controller, "controller");
    match transport {
        Some(Transport::Can) => rig.line("base", Line::can(BitRates::USUAL, vec![host, device])),
        Some(Transport::Serial) => {
            let settings = wire::base::serial_link::SETTINGS;
            rig.line("base", Line::serial(settings, vec![host, device]))
        }
        None => {
            let plan = rig.node(Node::new("plan", Part::Plan));
            let host = end(plan, PortId(0), Device::Plan, "plan");
            let device = end(robot, CARRIER, Device::Table, "table");
            rig.line("table", Line::serial(wire::table::SETTINGS, vec![host, device]))
        }
    };
    rig
}

/// Starts the device that plays a node under test, by the node's place; `None` if the node is away.
pub type Start<'a> = &'a dyn Fn(usize) -> Option<Result<Box<dyn NodeDevice>, String>>;

/// Adds the declared nodes and lines to the rig. `start` starts the devices under test. Returns a reason for each node
/// that is away because nothing plays it.
pub fn add(rig: &mut Rig, declared: &Declared, start: Start<'_>, seed: u64) -> Vec<String> {
    let of_robot = rig.lines.len();
    let mut ends: Vec<Vec<End>> = vec![Vec::new(); of_robot + declared.lines.len()];
    let mut away = Vec::new();
    for (place, node) in declared.nodes.iter().enumerate() {
        let part = match &node.part {
            NodePart::Described(description) => Node::described(&node.name, description, seed).part,
            NodePart::Tester(layout, sender) => {
                let tester = Tester::new(layout.clone(), *sender);
                Part::Tester(Box::new(tester.asking(declared.channels(place))))
            }
            NodePart::Replayed(said) => {
                let others = declared.channels(place).filter(|(other, _)| *other != node.name);
                Part::Replayed(Replaying::new(Arc::clone(said)).asking(others))
            }
            NodePart::UnderTest(_) => match start(place) {
                Some(Ok(device)) => Part::Own(Own::new(device)),
                Some(Err(why)) => {
                    away.push(why);
                    Part::Away
                }
                None => {
                    away.push(format!(
                        "`{}` is under test, and nothing plays it in virtual time: add `--clock real`, or bring it as \
                         Rust code",
                        node.name
                    ));
                    Part::Away
                }
            },
        };
        let at = rig.node(Node::new(&node.name, part));
        for (port, line) in node.lines.iter().enumerate() {
            let port = PortId(u8::try_from(port).unwrap_or(u8::MAX));
            ends[*line].push(end(at, port, Device::of_node(declared, place, *line), &node.name));
        }
    }
    let mut buses = 0;
    for (line, mut ends) in ends.into_iter().enumerate() {
        let of_rig = line.checked_sub(of_robot).and_then(|line| declared.lines.get(line));
        if of_rig.is_some_and(|line| line.medium != Medium::Can) && ends.len() == 1 {
            let nobody = rig.node(Node::new(NOBODY, Part::Away));
            ends.push(end(nobody, PortId(0), Device::Plan, NOBODY));
        }
        match line.checked_sub(of_robot).and_then(|line| declared.lines.get(line)) {
            Some(of_log) if declared.logged.is_some() => {
                _ = rig.line(&of_log.name, Line::direct(ends))
            }
            None => ends.into_iter().for_each(|end| rig.join(line, end)),
            Some(of_rig) => {
                let line = line_of(of_rig, ends);
                let line = match of_rig.medium == Medium::Can && !declared.is_short {
                    true => line.with_stranger(Device::stranger(buses)),
                    false => line,
                };
                buses += usize::from(of_rig.medium == Medium::Can);
                rig.line(&of_rig.name, line);
            }
        }
    }
    away
}

fn line_of(declared: &RigLine, ends: Vec<End>) -> Line {
    match declared.medium {
        Medium::Can => Line::can(declared.rates(), ends),
        Medium::Serial(settings) => Line::serial(settings, ends),
    }
}

pub fn listen(rig: &mut Rig, declared: &Declared) {
    for (index, speaker) in declared.speakers.iter().enumerate() {
        let Some(line) = rig.lines.get(speaker.line) else { continue };
        let at = |end: &End| *rig.nodes[end.node].name == *speaker.node;
        let Some(place) = line.ends().iter().position(at) else { continue };
        let decoder = speaker.layout.decoder_for(speaker.sender);
        rig.listen((speaker.line, EndId::of(place)), index, decoder, true);
    }
}

/// Builds a rig in virtual time; `paper` is the paper's robot or table with its controller, if the rig has one.
pub fn simulated(
    declared: &Declared,
    paper: Option<(Bench, Hosted)>,
    start: Start<'_>,
    seed: u64,
) -> (Rig, Vec<String>) {
    let mut rig = match paper {
        Some((bench, controller)) => self::paper(bench, Some(controller)),
        None => Rig::default(),
    };
    let away = add(&mut rig, declared, start, seed);
    listen(&mut rig, declared);
    (rig, away)
}
