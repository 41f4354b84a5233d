//! Rigs in real time: nodes outside this process are at ports of the system.

use crate::world::{
    BASE as BASE_ROLE, GYRO as GYRO_ROLE, LineSite, Placement, Player, PortPlan, PortPlans, TABLE,
    Traffic, base_traffic,
};
use described::{Description, Medium, Sender};
use plan::rig::{NodePart, RigLine, RigNode, UnderTest};
use plan::{DEVICE, Rig as Declared};
use ports::PortSpec;
use record::Device;
use record::outcome::PortSide;
use rig::Rig;
use rig::bench::Bench;
use rig::build::{self, add, end, listen};
use rig::hosted::OwnDevices;
use rig::line::{End, EndId, Line};
use rig::node::{Node, Part};
use rig::robot::CARRIER;
use rig::tester::Tester;
use std::sync::Arc;
use wire::device::PortId;

pub fn port(
    role: &str,
    spec: &PortSpec,
    traffic: Traffic,
    at: (usize, EndId),
    who: Device,
) -> PortPlan {
    PortPlan {
        role: role.into(),
        side: PortSide::Bench,
        spec: spec.clone(),
        traffic,
        line: at.0,
        end: at.1,
        who,
        far_of: None,
        listens: false,
    }
}

/// The paper's robot or table with its devices placed by `placement`, the controller away, and the declared nodes
/// beside it.
pub fn paper(
    bench: Bench,
    placement: &Placement,
    (declared, sites, own): (&Declared, &[LineSite], &OwnDevices),
    seed: u64,
) -> (Rig, PortPlans) {
    let gyro = Traffic::Bytes(bench.gyro_stream().format.serial());
    let transport = bench.base_transport();
    let mut rig = build::paper(bench, None);
    let mut plans = PortPlans::default();
    let is_real = |player: &Player| !player.is_emulated();
    if let Some(robot) = rig.robot_mut() {
        robot.gyro_is_real = is_real(&placement.gyro);
        robot.carrier_is_real = placement.base.as_ref().is_some_and(is_real);
    }
    match &placement.gyro {
        Player::Emulated(spec) => {
            plans.ports.push(port(GYRO_ROLE, spec, gyro, (0, EndId(1)), Device::Gyro));
        }
        Player::Real(spec) => plans.real.push((GYRO_ROLE.into(), spec.clone())),
    }
    if let (Some(player), Some(transport)) = (&placement.base, transport) {
        let traffic = base_traffic(transport);
        let plan = port(BASE_ROLE, player.spec(), traffic, (1, EndId(0)), Device::Base);
        match player {
            Player::Emulated(_) => plans.ports.push(plan),
            Player::Real(spec) => {
                plans.real.push((BASE_ROLE.into(), spec.clone()));
                // The harness also listens on a bus of the kernel.
                if let PortSpec::Can { .. } = spec {
                    plans.ports.push(PortPlan { listens: true, ..plan });
                }
            }
        }
    }
    if let (Some(player), Some(plan)) = (&placement.table, rig.find("plan")) {
        place_table(&mut rig, &mut plans, player, plan);
        return (rig, plans);
    }
    add(&mut rig, declared, &|place| own.start(&declared.nodes[place].name).map(Ok), seed);
    with_programs(&mut rig, declared);
    listen(&mut rig, declared);
    plans.ports.extend(at_ports(&mut rig, declared, sites).ports);
    (rig, plans)
}

/// Lets the plan command the table at a port: the real table, or the emulated one at the port's other side.
fn place_table(rig: &mut Rig, plans: &mut PortPlans, player: &Player, plan: usize) {
    let traffic = Traffic::Bytes(wire::table::SETTINGS);
    let Some(robot) = rig.find("robot") else { return };
    let away = rig.node(Node::new(TABLE, Part::Away));
    rig.lines.pop();
    rig.line_names.pop();
    let of_plan = end(plan, PortId(0), Device::Plan, "plan");
    let far = end(away, PortId(0), Device::Table, TABLE);
    let mut ends = vec![of_plan, far];
    let near = if player.is_emulated() {
        let host = end(away, PortId(1), Device::Plan, "plan");
        let device = end(robot, CARRIER, Device::Table, TABLE);
        let near = Line::serial(wire::table::SETTINGS, vec![host, device]).unrecorded();
        Some(rig.line(TABLE, near))
    } else {
        // The emulated table follows the real one, so that an emulated gyro on it turns.
        ends.push(end(robot, CARRIER, Device::Table, TABLE));
        if let Some(robot) = rig.robot_mut() {
            robot.carrier_is_real = true;
        }
        None
    };
    let far = rig.line(TABLE, Line::direct(ends));
    at_port(plans, player.spec(), traffic, (TABLE, Device::Table), (near, far));
}

/// The plan's side of a port, at the second end of its line. An emulated device has the other side, at the first end of
/// the line that is near it.
fn at_port(
    plans: &mut PortPlans,
    spec: &PortSpec,
    traffic: Traffic,
    (role, who): (&str, Device),
    (near, far): (Option<usize>, usize),
) {
    let far_of = near.map(|near| {
        plans.ports.push(port(role, spec, traffic, (near, EndId(0)), who));
        plans.ports.len() - 1
    });
    let plan = port(role, spec, traffic, (far, EndId(1)), who);
    plans.ports.push(PortPlan { side: PortSide::Plan, far_of, ..plan });
}

fn traffic(line: &RigLine) -> Traffic {
    match line.medium {
        Medium::Can => Traffic::Frames(line.rates()),
        Medium::Serial(settings) => Traffic::Bytes(settings),
    }
}

/// One device, real or emulated, with the plan at the other side of its port.
pub fn device(description: &Arc<Description>, player: &Player, seed: u64) -> (Rig, PortPlans) {
    let layout = description.layout();
    let traffic = traffic(&RigLine::of_device(layout));
    let (mut rig, mut plans) = (Rig::default(), PortPlans::default());
    let channel = description.isotp().map(|isotp| (DEVICE, isotp));
    let tester = Tester::new(layout.clone(), Sender::Host).asking(channel.into_iter());
    let host = rig.node(Node::new("host", Part::Tester(Box::new(tester))));
    let away = rig.node(Node::new("away", Part::Away));
    let ends = vec![
        end(host, PortId(0), Device::Plan, "host"),
        end(away, PortId(0), Device::Device, DEVICE),
    ];
    let near = player.is_emulated().then(|| alone(&mut rig, description, seed));
    let far = rig.line(DEVICE, Line::direct(ends));
    at_port(&mut plans, player.spec(), traffic, (DEVICE, Device::Device), (near, far));
    rig.listen((far, EndId(1)), 0, layout.decoder_for(Sender::Device), true);
    (rig, plans)
}

/// Nodes on lines, some of them at ports: a device under test is at the far side of its line's port.
pub fn rig(
    declared: &Declared,
    sites: &[LineSite],
    own: &OwnDevices,
    seed: u64,
) -> (Rig, PortPlans) {
    let mut rig = Rig::default();
    add(&mut rig, declared, &|place| own.start(&declared.nodes[place].name).map(Ok), seed);
    with_programs(&mut rig, declared);
    listen(&mut rig, declared);
    let plans = at_ports(&mut rig, declared, sites);
    (rig, plans)
}

/// The programs that this run starts: their supply is in our hands.
fn with_programs(rig: &mut Rig, declared: &Declared) {
    let is_program =
        |node: &&RigNode| matches!(node.part, NodePart::UnderTest(UnderTest::Command(_)));
    for program in declared.nodes.iter().filter(is_program) {
        let node = rig.find(&program.name).and_then(|place| rig.nodes.get_mut(place));
        if let Some(node) = node.filter(|node| node.is_away()) {
            node.part = Part::Process(None);
        }
    }
}

/// The described devices of a rig, for nodes at these ports of its lines; no other node runs here.
pub fn emulated(declared: &Declared, ports: &[(String, PortSpec)], seed: u64) -> (Rig, PortPlans) {
    let mut rig = Rig::default();
    add(&mut rig, declared, &|_| None, seed);
    listen(&mut rig, declared);
    for node in rig.nodes.iter_mut().filter(|node| !node.is_emulated()) {
        node.part = Part::Away;
    }
    let site = |(name, spec): &(String, PortSpec)| {
        let line = declared.lines.iter().position(|line| line.name == *name)?;
        Some(LineSite { line, spec: spec.clone(), beyond: Vec::new() })
    };
    let sites: Vec<LineSite> = ports.iter().filter_map(site).collect();
    let plans = at_ports(&mut rig, declared, &sites);
    (rig, plans)
}

fn at_ports(rig: &mut Rig, declared: &Declared, sites: &[LineSite]) -> PortPlans {
    let mut plans = PortPlans::default();
    for LineSite { line: place, spec, .. } in sites {
        let line = &(declared.robot_lines() + place);
        let is_away = |end: &End| rig.nodes[end.node].is_away();
        let end_place = rig.lines[*line].ends().iter().position(is_away);
        let end_place = end_place.unwrap_or_else(|| {
            // No node of the rig is at the port; other programs may listen there.
            let node = rig.node(Node::new("port", Part::Away));
            rig.join(*line, end(node, PortId(0), Device::Plan, "port"));
            rig.lines[*line].ends().len() - 1
        });
        let at = EndId::of(end_place);
        let who = rig.lines[*line].who(at);
        if matches!(spec, PortSpec::Serial(_)) {
            rig.lines[*line].leave_time_to_a_real_line();
        }
        let declared = &declared.lines[*place];
        plans.ports.push(port(&declared.name, spec, traffic(declared), (*line, at), who));
    }
    plans
}

/// An emulated device and its line, with a port at the first end; returns the line.
pub fn alone(rig: &mut Rig, description: &Arc<Description>, seed: u64) -> usize {
    let device = rig.node(Node::described(DEVICE, description, seed));
    let away = rig.node(Node::new("port", Part::Away));
    let ends = vec![
        end(away, PortId(0), Device::Plan, "host"),
        end(device, PortId(0), Device::Device, DEVICE),
    ];
    let layout = description.layout();
    let mut line = match layout.medium() {
        Medium::Can => Line::can(RigLine::of_device(layout).rates(), ends),
        Medium::Serial(settings) => Line::serial(settings, ends),
    };
    line.expect_messages(layout, Some(Sender::Device));
    rig.line(DEVICE, line.unrecorded())
}
