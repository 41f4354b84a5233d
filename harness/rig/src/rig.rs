//! Nodes and the lines between them.

use crate::crossing::CrossedLine;
use crate::engine::Engine;
use crate::line::{End, EndId, Line};
use crate::link::Struck;
use crate::node::{Node, Part, Route};
use crate::robot::{self, Robot};
use described::{Decoded, Decoder};
use std::collections::BTreeMap;
use std::sync::Arc;
use wire::device::{PortId, Transmit};
use wire::time::{Span, Timestamp};

/// Nodes and the lines between them.
#[derive(Debug, Default)]
pub struct Rig {
    pub nodes: Vec<Node>,
    pub lines: Vec<Line>,
    /// Names of the lines.
    pub line_names: Vec<Arc<str>>,
    pub(crate) ears: Vec<Ear>,
}

/// Reads what one end of a line says.
#[derive(Debug, Clone)]
pub(crate) struct Ear {
    pub(crate) line: usize,
    pub(crate) end: EndId,
    /// By its place among the speakers of the rig.
    pub(crate) speaker: usize,
    pub(crate) decoder: Decoder,
    /// What came and could not be read counts: somebody's own device has to be understood.
    pub(crate) judged: bool,
    /// How often each signal was out of its range, by its place behind that of its message.
    pub(crate) out_of_range: BTreeMap<(usize, usize), u64>,
}

impl Rig {
    /// Adds a node; its place.
    pub fn node(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Adds a line between nodes that are there.
    pub fn line(&mut self, name: &str, line: Line) -> usize {
        let index = self.lines.len();
        for (place, End { node, port, .. }) in line.ends().iter().enumerate() {
            let routes = &mut self.nodes[*node].routes;
            let port = usize::from(port.0);
            if routes.len() <= port {
                routes.resize(port + 1, None);
            }
            routes[port] = Some(Route { line: index, end: EndId::of(place) });
        }
        self.lines.push(line);
        self.line_names.push(name.into());
        index
    }

    /// One more end of a line that is there.
    pub fn join(&mut self, line: usize, end: End) {
        let (node, port) = (end.node, usize::from(end.port.0));
        let place = EndId::of(self.lines[line].add(end));
        let routes = &mut self.nodes[node].routes;
        if routes.len() <= port {
            routes.resize(port + 1, None);
        }
        routes[port] = Some(Route { line, end: place });
    }

    /// What comes from that end of a line is read as messages.
    pub fn listen(
        &mut self,
        (line, end): (usize, EndId),
        speaker: usize,
        decoder: Decoder,
        judged: bool,
    ) {
        let out_of_range = BTreeMap::new();
        self.ears.push(Ear { line, end, speaker, decoder, judged, out_of_range });
    }

    /// Somebody reads what crosses that line.
    pub(crate) fn is_read(&self, line: usize) -> bool {
        self.ears.iter().any(|ear| ear.line == line)
    }

    /// When something is through next, on any line.
    #[inline]
    pub fn next_arrival(&self) -> Timestamp {
        self.lines.iter().map(Line::next_arrival).min().unwrap_or(Timestamp::MAX)
    }

    /// When a node wants to be woken next.
    #[inline]
    pub fn next_wakeup(&self) -> Timestamp {
        self.nodes.iter().map(Node::next_wakeup).min().unwrap_or(Timestamp::MAX)
    }

    /// What found no room, in lines and nodes.
    pub fn dropped(&self) -> u64 {
        self.lines.iter().map(Line::dropped).sum::<u64>()
            + self.nodes.iter().map(Node::dropped).sum::<u64>()
    }

    /// Puts what a node sends on the line at that port; what leads nowhere is lost.
    #[inline]
    pub fn send(&mut self, now: Timestamp, node: usize, port: PortId, what: Transmit) {
        if let Some(Route { line, end }) = self.nodes[node].route(port) {
            self.lines[line].send(now, end, what);
        }
    }

    /// Everybody at the line but the sender takes what has come through; `reached` hears who.
    #[inline]
    pub fn hand_over(
        &mut self,
        now: Timestamp,
        line: usize,
        from: EndId,
        what: &Transmit,
        mut reached: impl FnMut(usize),
    ) {
        for (place, end) in self.lines[line].ends().iter().enumerate() {
            if EndId::of(place) != from {
                self.nodes[end.node].receive(now, end.port, what);
                reached(end.node);
            }
        }
    }

    /// A message of a node, or one of its signals, and the end of the line that the node sends it from.
    pub fn said(&self, node: &str, part: &str) -> Option<(usize, EndId, Struck)> {
        self.ears.iter().find_map(|ear| {
            let (layout, sender) = (ear.decoder.layout(), ear.decoder.sender()?);
            if self.lines[ear.line].name(ear.end) != node {
                return None;
            }
            let (message, signal) = match layout.find(part) {
                Some(message) => (message, None),
                None => {
                    let found = layout.sent_signal(sender, part);
                    found.map(|(message, signal)| (message, Some(signal)))?
                }
            };
            let is_its = layout.messages()[message].sender == sender;
            let struck = Struck { layout: layout.clone(), sender, message, signal };
            is_its.then_some((ear.line, ear.end, struck))
        })
    }

    /// Reads what an end of a line said; `take` gets each message with its speaker.
    #[inline]
    pub fn read(
        &mut self,
        (line, from): (usize, EndId),
        what: &Transmit,
        mut take: impl FnMut(usize, Decoded<'_>),
    ) {
        for ear in &mut self.ears {
            // A stranger's frames are taken for those of the one whose messages they are.
            let strange = from == EndId::STRANGER && ear.judged;
            if ear.line != line || (ear.end != from && !strange) {
                continue;
            }
            let Ear { speaker, decoder, out_of_range, .. } = ear;
            let mut take = |decoded: Decoded<'_>| {
                for signal in decoded.out_of_range() {
                    *out_of_range.entry((decoded.message, signal)).or_default() += 1;
                }
                take(*speaker, decoded);
            };
            match what {
                Transmit::Frame(frame) => decoder.frame(frame).into_iter().for_each(take),
                Transmit::Bytes(packet) => decoder.bytes(packet.as_slice(), &mut take),
            }
        }
    }

    /// Whoever is at that end is at a port of the system.
    pub fn is_away(&self, line: usize, end: EndId) -> bool {
        let end = self.lines[line].ends().get(end.place());
        end.is_some_and(|end| matches!(self.nodes[end.node].part, Part::Away))
    }

    /// Which end said what came from a port: the one away whose message it is, else `at`, where the port is.
    pub fn speaker_of(&self, line: usize, at: EndId, what: &Transmit) -> EndId {
        let Transmit::Frame(frame) = what else { return at };
        let of = |ear: &&Ear| {
            ear.line == line && self.is_away(line, ear.end) && ear.decoder.takes(frame.id())
        };
        self.ears.iter().find(of).map_or(at, |ear| ear.end)
    }

    /// The gyro's outputs up to `now`, each at its own instant, onto its line.
    #[inline]
    pub fn wake_gyro(&mut self, now: Timestamp, place: usize) {
        let route = self.nodes[place].route(robot::GYRO);
        let Part::Robot(robot) = &mut self.nodes[place].part else { return };
        while let Some((at, what)) = robot.gyro_output(now) {
            if let Some(Route { line, end }) = route {
                self.lines[line].send(at, end, what);
            }
        }
    }

    /// From now on an output of a gyro needs no event at its own instant: nobody notices it before its bytes are through the
    /// line, as long as it is asked for [before](Self::wake_gyros_before) anything else happens. It halves the events of a
    /// robot that stands. Not where a fault could let bytes through sooner.
    pub(crate) fn wake_gyros_late(&mut self) {
        for node in &mut self.nodes {
            let route = node.route(robot::GYRO);
            if let (Part::Robot(robot), Some(Route { line, .. })) = (&mut node.part, route) {
                let bytes = robot.bench.gyro_stream().format.frame_bytes();
                robot.gyro_late = self.lines[line].time_for(bytes);
            }
        }
    }

    /// The gyros' outputs before `now`, each at its own instant: they must not feel what happens now.
    #[inline]
    pub(crate) fn wake_gyros_before(&mut self, now: Timestamp) {
        for place in 0..self.nodes.len() {
            self.wake_gyro(now - Span::from_nanos(1), place);
        }
    }

    /// Wakes the emulated devices that are due; `reached` hears who, `answered` that one has been switched on again.
    #[inline]
    pub fn wake_emulated(
        &mut self,
        now: Timestamp,
        mut reached: impl FnMut(usize),
        mut answered: impl FnMut(),
    ) {
        for place in 0..self.nodes.len() {
            match &mut self.nodes[place].part {
                Part::Robot(robot) => {
                    if robot.wake(now) {
                        reached(place);
                    }
                    self.wake_gyro(now, place);
                }
                Part::Described(described) if described.next_wakeup() <= now => {
                    if described.wake(now) {
                        answered();
                    }
                    reached(place);
                }
                _ => {}
            }
        }
    }

    /// Wakes those that devices are emulated for, where they are due.
    #[inline]
    pub fn wake_others(
        &mut self,
        now: Timestamp,
        engine: &mut Engine,
        mut reached: impl FnMut(usize),
    ) {
        for (place, node) in self.nodes.iter_mut().enumerate() {
            match &mut node.part {
                Part::Controller(machine) if machine.is_due(now) => {
                    machine.wake(now);
                    reached(place);
                }
                Part::Replayed(replaying) if replaying.next_wakeup() <= now => reached(place),
                Part::Own(device) if device.next_wakeup() <= now => {
                    device.wake(now);
                    if let Some(how) = device.ended() {
                        engine.lost_node(now, &node.name, &how);
                    }
                    reached(place);
                }
                Part::Tester(tester) if tester.next_wakeup() <= now => {
                    if let Err(why) = tester.wake(now) {
                        engine.broke(now, &why);
                    }
                    reached(place);
                }
                _ => {}
            }
        }
    }

    /// What a node has to say goes onto its lines. Controllers are asked by their owner, who hears their reports, too.
    #[inline]
    pub fn empty(&mut self, now: Timestamp, place: usize) {
        loop {
            let sent = match &mut self.nodes[place].part {
                Part::Robot(robot) => robot.transmit().map(|what| (robot::CARRIER, what)),
                Part::Described(described) => described.device.transmit().map(at_only_port),
                Part::Own(device) => device.transmit(now),
                Part::Replayed(replaying) => replaying.transmit(now),
                Part::Tester(tester) => tester.transmit().map(at_only_port),
                Part::Controller(_) | Part::Plan | Part::Away => None,
            };
            let Some((port, what)) = sent else { return };
            self.send(now, place, port, what);
        }
    }

    /// The gyro and what turns it.
    pub fn robot(&self) -> Option<&Robot> {
        self.robots().next()
    }

    /// See [`Self::robot`].
    pub fn robot_mut(&mut self) -> Option<&mut Robot> {
        self.robots_mut().next()
    }

    /// The gyro and what turns it, and what turns nothing.
    pub fn robots(&self) -> impl Iterator<Item = &Robot> {
        self.nodes.iter().filter_map(|node| match &node.part {
            Part::Robot(robot) => Some(&**robot),
            _ => None,
        })
    }

    /// See [`Self::robots`].
    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut Robot> {
        self.nodes.iter_mut().filter_map(|node| match &mut node.part {
            Part::Robot(robot) => Some(&mut **robot),
            _ => None,
        })
    }

    /// What its lines cross where they go through the kernel. The device of a line is its last emulated end.
    pub fn crossed_lines(&self) -> Vec<CrossedLine> {
        let of = |(line, name): (&Line, &Arc<str>)| CrossedLine {
            name: Arc::clone(name),
            is_can: line.is_can(),
            device_end: line
                .ends()
                .iter()
                .rposition(|end| self.nodes[end.node].is_emulated())
                .unwrap_or_default(),
        };
        self.lines.iter().zip(&self.line_names).map(of).collect()
    }

    /// The place of the node of this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| &*node.name == name)
    }
}

const fn at_only_port(what: Transmit) -> (PortId, Transmit) {
    (PortId(0), what)
}
