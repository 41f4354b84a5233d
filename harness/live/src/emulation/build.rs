//! Builds the emulated rig and its ports.

use crate::at_ports::{self, port};
use crate::world::{BASE, GYRO as GYRO_ROLE, PortPlans, Traffic};
use emulators::absolute::AbsoluteParameters;
use emulators::base::{BaseParameters, Transport};
use emulators::device_file::{Devices, Mount};
use emulators::gyro::GyroParameters;
use emulators::table::TableParameters;
use plan::Rig as Declared;
use plan::faults::{LineKind, Lines, Target};
use ports::PortSpec;
use record::Device;
use rig::Rig;
use rig::bench::{Bench, Carrier, Turning};
use rig::build::end;
use rig::line::{EndId, Line};
use rig::node::{Node, Part};
use rig::robot::{CARRIER, GYRO, Robot};
use std::path::PathBuf;
use wire::can::BitRates;
use wire::device::PortId;
use wire::gyro::{GyroFormat, GyroStream, OutputMode};

#[derive(Debug, Clone, Default)]
pub struct Parts {
    pub gyro: Option<(GyroStream, GyroParameters)>,
    pub base: Option<(Transport, BaseParameters)>,
    pub table: Option<TableParameters>,
    /// Carrier of the gyro; if this, or the carrier that it names, is absent, a rate turns the gyro.
    pub mount: Option<Mount>,
}

#[derive(Debug, Clone)]
pub enum What {
    /// The paper's devices. Their lines are `gyro`, `base` and `table`.
    Parts(Box<Parts>),
    /// The described devices of a rig; all other nodes are at the ports.
    Rig(Box<Declared>),
}

/// Devices to emulate, and their ports.
#[derive(Debug, Clone)]
pub struct Setup {
    pub what: What,
    /// Ports of lines by name; a line without one has no program from outside on it.
    pub ports: Vec<(String, PortSpec)>,
    /// A socket for requests, besides the standard input.
    pub control: Option<PathBuf>,
    pub seed: u64,
}

pub(super) fn build(setup: &Setup) -> (Rig, PortPlans, Lines) {
    match &setup.what {
        What::Parts(parts) => paper(parts, setup),
        What::Rig(declared) => {
            let (rig, plans) = at_ports::emulated(declared, &setup.ports, setup.seed);
            (rig, plans, declared.struck())
        }
    }
}

fn paper(parts: &Parts, setup: &Setup) -> (Rig, PortPlans, Lines) {
    let mut rig = Rig::default();
    for robot in robots(parts, setup.seed) {
        rig.node(Node::new("robot", Part::Robot(Box::new(robot))));
    }
    let (mut plans, mut lines) = (PortPlans::default(), Lines::default());
    for (name, spec) in &setup.ports {
        let (device, target, at, traffic) = match name.as_str() {
            GYRO_ROLE => {
                let settings = parts.gyro.as_ref().map(|(stream, _)| stream.format.serial());
                let traffic = Traffic::Bytes(settings.unwrap_or(wire::table::SETTINGS));
                (Device::Gyro, Target::Gyro, GYRO, traffic)
            }
            BASE => {
                let traffic = match &parts.base {
                    Some((Transport::Serial, _)) => {
                        Traffic::Bytes(wire::base::serial_link::SETTINGS)
                    }
                    _ => Traffic::Frames(BitRates::USUAL),
                };
                (Device::Base, Target::Base, CARRIER, traffic)
            }
            _ => (Device::Table, Target::Table, CARRIER, Traffic::Bytes(wire::table::SETTINGS)),
        };
        let is_at = |node: &Node| matches!(&node.part, Part::Robot(robot) if robot.has(target));
        let Some(node) = rig.nodes.iter().position(is_at) else { continue };
        let away = rig.node(Node::new("host", Part::Away));
        let ends = vec![end(away, PortId(0), Device::Plan, "host"), end(node, at, device, name)];
        let (kind, line) = match traffic {
            Traffic::Bytes(settings) => (LineKind::Serial, Line::serial(settings, ends)),
            Traffic::Frames(rates) => (LineKind::Can, Line::can(rates, ends)),
        };
        let line = rig.line(name, line);
        lines.nodes.push((target, kind));
        plans.ports.push(port(name, spec, traffic, (line, EndId(0)), device));
    }
    (rig, plans, lines)
}

/// The gyro with its carrier, then carriers without a gyro.
fn robots(parts: &Parts, seed: u64) -> Vec<Robot> {
    let ideal =
        GyroStream { format: GyroFormat::Navigator, mode: OutputMode::default(), reversed: false };
    let devices = |mount| Devices {
        mount,
        gyro: parts.gyro.clone().unwrap_or((ideal, GyroParameters::default())),
        base: parts.base.clone(),
        table: parts.table.clone(),
        absolute: AbsoluteParameters::default(),
    };
    let there =
        [parts.base.as_ref().map(|_| Mount::Base), parts.table.as_ref().map(|_| Mount::Table)];
    let there = there.into_iter().flatten();
    let carries = parts.mount.filter(|mount| there.clone().any(|one| one == *mount));
    let mut robots = Vec::new();
    if parts.gyro.is_some() {
        let mut bench = Bench::new(devices(carries.unwrap_or(Mount::Table)), seed);
        if carries.is_none() {
            bench.carrier = Carrier::Turning(Turning::default());
        }
        robots.push(Robot::new(bench));
    }
    let others = there.filter(|mount| parts.gyro.is_none() || Some(*mount) != carries);
    robots.extend(others.map(|mount| {
        let mut robot = Robot::new(Bench::new(devices(mount), seed));
        robot.gyro_is_real = true;
        robot
    }));
    robots
}
