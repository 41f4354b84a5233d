//! Nodes and the lines between them.

use crate::crossing::CrossedLine;
use crate::engine::Engine;
use crate::line::{End, EndId, Line};
use crate::node::{Node, Part, Route, Woken};
use crate::oddities::Oddities;
use crate::robot::{self, Robot};
use described::{Decoded, Decoder};
use std::sync::Arc;
use wire::device::{PortId, Transmit};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};

#[derive(Debug, Default)]
pub struct Rig {
    pub nodes: Vec<Node>,
    pub lines: Vec<Line>,
    pub line_names: Vec<Arc<str>>,
    pub(crate) ears: Vec<Ear>,
}

/// Decodes what one end of a line sends.
#[derive(Debug, Clone)]
pub(crate) struct Ear {
    pub(crate) line: usize,
    pub(crate) end: EndId,
    /// Index among the speakers of the rig.
    pub(crate) speaker: usize,
    pub(crate) decoder: Decoder,
    /// Whether undecodable input counts: the user's own device must be understood.
    pub(crate) judged: bool,
    pub(crate) oddities: Oddities,
}

impl Rig {
    pub fn node(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    pub fn line(&mut self, name: &str, line: Line) -> usize {
        let index = self.lines.len();
        for (place, End { node, port, .. }) in line.ends().iter().enumerate() {
            self.nodes[*node].join(*port, Route { line: index, end: EndId::of(place) });
        }
        self.lines.push(line);
        self.line_names.push(name.into());
        index
    }

    pub fn join(&mut self, line: usize, end: End) {
        let (node, port) = (end.node, end.port);
        let end = EndId::of(self.lines[line].add(end));
        self.nodes[node].join(port, Route { line, end });
    }

    /// Decodes the messages from that end of a line.
    pub fn listen(
        &mut self,
        (line, end): (usize, EndId),
        speaker: usize,
        decoder: Decoder,
        judged: bool,
    ) {
        self.lines[line].expect_messages(decoder.layout(), decoder.sender());
        let oddities = Oddities::default();
        self.ears.push(Ear { line, end, speaker, decoder, judged, oddities });
    }

    pub(crate) fn is_read(&self, line: usize) -> bool {
        self.ears.iter().any(|ear| ear.line == line)
    }

    #[inline]
    pub fn next_arrival(&self) -> Timestamp {
        self.lines.iter().map(Line::next_arrival).min().unwrap_or(Timestamp::MAX)
    }

    #[inline]
    pub fn next_wakeup(&self) -> Timestamp {
        self.nodes.iter().map(Node::next_wakeup).min().unwrap_or(Timestamp::MAX)
    }

    /// Number of items dropped by lines and nodes.
    pub fn dropped(&self) -> u64 {
        self.lines.iter().map(Line::dropped).sum::<u64>()
            + self.nodes.iter().map(Node::dropped).sum::<u64>()
    }

    /// Sends on the line at a node's port; without a line it is lost.
    #[inline]
    pub fn send(&mut self, now: Timestamp, node: usize, port: PortId, what: Transmit) {
        if let Some(Route { line, end }) = self.nodes[node].route(port) {
            self.lines[line].send(now, end, what);
        }
    }

    /// Passes what has arrived to all nodes on the line but the sender; calls `reached` for each.
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
            if EndId::of(place) != from && !self.lines[line].misses(EndId::of(place)) {
                self.nodes[end.node].receive(now, end.port, what);
                reached(end.node);
            }
        }
    }

    /// Decodes what an end of a line sent; calls `take` for each message with its speaker. Returns how many bytes, frames and
    /// messages of it were unexpected or damaged.
    #[inline]
    pub fn read(
        &mut self,
        now: Timestamp,
        (line, from): (usize, EndId),
        what: &Transmit,
        mut take: impl FnMut(usize, Decoded<'_>),
    ) -> u64 {
        let (mut odd, mut is_known) = (0, self.ears.is_empty());
        let is_forged = self.is_forged(line, from, what);
        for ear in &mut self.ears {
            // A bus does not tell who sent a frame: a stranger's, or one with another node's identifier, counts as the
            // frame of the node whose message it is.
            let strange = (from == EndId::STRANGER || is_forged) && ear.judged && ear.end != from;
            if ear.line != line {
                continue;
            }
            if ear.end != from && !strange {
                if let Transmit::Bytes(packet) = what {
                    ear.decoder.overhear(packet.as_slice());
                }
                continue;
            }
            let before = ear.damage();
            let Ear { speaker, decoder, oddities, .. } = ear;
            let mut take = |decoded: Decoded<'_>| {
                oddities.see(&decoded);
                take(*speaker, decoded);
            };
            match what {
                Transmit::Frame(frame) => {
                    let decoded = decoder.at(now).frame(frame);
                    is_known |= decoded.is_some();
                    decoded.into_iter().for_each(take);
                    if let Some(id) = decoder.foreign() {
                        oddities.unexpected.count(id);
                        odd += 1;
                    }
                }
                Transmit::Bytes(packet) => decoder.bytes(packet.as_slice(), &mut take),
            }
            odd += ear.damage() - before;
        }
        // A frame counts once, whatever is wrong with it.
        match what {
            Transmit::Frame(frame) if !is_known || is_forged => {
                u64::from(self.is_unexpected(line, from, frame) || odd > 0)
            }
            Transmit::Frame(_) => odd.min(1),
            Transmit::Bytes(_) => odd,
        }
    }

    /// Whether a node sent a frame that is none of its own messages.
    #[inline]
    fn is_forged(&self, line: usize, from: EndId, what: &Transmit) -> bool {
        let Transmit::Frame(frame) = what else { return false };
        let mut own = self.ears.iter().filter(|ear| (ear.line, ear.end) == (line, from)).peekable();
        // A remote request has the identifier of another node's message, which it asks for.
        own.peek().is_some() && !frame.is_remote() && !own.any(|ear| ear.decoder.takes(frame.id()))
    }

    /// Whether the node at that end is at a port of the system.
    pub fn is_away(&self, line: usize, end: EndId) -> bool {
        let end = self.lines[line].ends().get(end.place());
        end.is_some_and(|end| self.nodes[end.node].is_away())
    }

    /// Sender of something from a port: the node away whose message it is, else `at`, the end of the port.
    pub fn speaker_of(&self, line: usize, at: EndId, what: &Transmit) -> EndId {
        let Transmit::Frame(frame) = what else { return at };
        let is_its = |ear: &Ear| ear.line == line && ear.decoder.takes(frame.id());
        let away = |ear: &&Ear| is_its(ear) && self.is_away(line, ear.end);
        if let Some(ear) = self.ears.iter().find(away) {
            return ear.end;
        }
        // What an end with messages of its own sends beside them counts as its owner's.
        at
    }

    /// Puts the gyro's outputs up to `now` on its line, each at its own instant.
    #[inline]
    pub fn wake_gyro(&mut self, now: Timestamp, place: usize) {
        let route = self.nodes[place].route(robot::GYRO);
        let Part::Robot(robot) = &mut self.nodes[place].part else { return };
        if robot.bench.gyro.next_wakeup() > now {
            return;
        }
        let mut what = Transmit::Bytes(Packet::new());
        while let Some(at) = robot.gyro_output(now, &mut what) {
            if let Some(Route { line, end }) = route {
                self.lines[line].send(at, end, what);
            }
        }
    }

    /// From now on an output of a gyro needs no event at its own instant: nothing observes it before its bytes have
    /// arrived, as long as it is fetched [before](Self::wake_gyros_before) anything else happens. This halves the
    /// events of a robot at rest. Not valid if a fault could let bytes arrive earlier.
    pub(crate) fn wake_gyros_late(&mut self) {
        for node in &mut self.nodes {
            let route = node.route(robot::GYRO);
            if let (Part::Robot(robot), Some(Route { line, .. })) = (&mut node.part, route) {
                let bytes = robot.bench.gyro_stream().format.facts().frame_bytes;
                robot.gyro_late = self.lines[line].time_for(bytes);
            }
        }
    }

    /// Fetches the gyros' outputs before `now`, each at its own instant: what happens now must not affect them.
    #[inline]
    pub(crate) fn wake_gyros_before(&mut self, now: Timestamp) {
        for place in 0..self.nodes.len() {
            self.wake_gyro(now - Span::from_nanos(1), place);
        }
    }

    /// Wakes the emulated devices that are due; calls `reached` for each, and `told` for what has become of one.
    #[inline]
    pub fn wake_emulated(
        &mut self,
        now: Timestamp,
        mut reached: impl FnMut(usize),
        mut told: impl FnMut(Woken),
    ) {
        for place in 0..self.nodes.len() {
            if self.nodes[place].back(now) {
                told(Woken::Back);
                reached(place);
            }
            match &mut self.nodes[place].part {
                Part::Robot(robot) => {
                    if robot.wake(now) {
                        reached(place);
                    }
                    self.wake_gyro(now, place);
                }
                Part::Described(described) if described.next_wakeup() <= now => {
                    described.wake(now);
                    if let Some(why) = described.failure(now) {
                        told(Woken::Failed(format!("`{}`: {why}", self.nodes[place].name)));
                    }
                    reached(place);
                }
                _ => {}
            }
        }
    }

    /// Wakes the other nodes that are due; returns whether the engine was told something.
    #[inline]
    pub fn wake_others(
        &mut self,
        now: Timestamp,
        engine: &mut Engine,
        mut reached: impl FnMut(usize),
    ) -> bool {
        let mut was_told = false;
        for (place, node) in self.nodes.iter_mut().enumerate() {
            match &mut node.part {
                Part::Controller(machine) if machine.is_due(now) => {
                    machine.wake(now);
                    reached(place);
                }
                Part::Replayed(replaying) if replaying.next_wakeup() <= now => {
                    replaying.wake(now);
                    if let Some(reply) = replaying.reply() {
                        engine.replied(now, &reply);
                        was_told = true;
                    }
                    reached(place);
                }
                Part::Own(device) if device.next_wakeup() <= now => {
                    device.wake(now);
                    let guest = &mut device.guest;
                    if let Some(how) = guest.ended() {
                        match guest.is_given_up() {
                            true => engine.abort(now),
                            false => engine.lost_node(now, &node.name, &how),
                        }
                        was_told = true;
                    }
                    if let Some(why) = guest.wrong() {
                        engine.broke(now, &why);
                        was_told = true;
                    }
                    reached(place);
                }
                Part::Tester(tester) if tester.next_wakeup() <= now => {
                    if let Err(why) = tester.wake(now) {
                        engine.broke(now, &why);
                        was_told = true;
                    }
                    if let Some(reply) = tester.reply() {
                        engine.replied(now, &reply);
                        was_told = true;
                    }
                    reached(place);
                }
                _ => {}
            }
        }
        was_told
    }

    /// Sends the outputs of a node. Controllers are drained by their owner, which also takes their reports.
    #[inline]
    pub fn empty(&mut self, now: Timestamp, place: usize) {
        loop {
            let sent = match &mut self.nodes[place].part {
                Part::Robot(robot) => robot.transmit().map(|what| (robot::CARRIER, what)),
                Part::Described(described) => described.transmit().map(at_only_port),
                Part::Own(device) => device.transmit(now),
                Part::Replayed(replaying) => replaying.transmit(now),
                Part::Tester(tester) => tester.transmit().map(at_only_port),
                Part::Controller(_) | Part::Plan | Part::Away | Part::Process(_) => None,
            };
            let Some((port, what)) = sent else { return };
            if matches!(self.nodes[place].part, Part::Own(_)) && self.disowns(place, port, &what) {
                return;
            }
            self.send(now, place, port, what);
        }
    }

    pub fn robot(&self) -> Option<&Robot> {
        self.robots().next()
    }

    pub fn robot_mut(&mut self) -> Option<&mut Robot> {
        self.robots_mut().next()
    }

    /// Gyros with their carriers, including those without one.
    pub fn robots(&self) -> impl Iterator<Item = &Robot> {
        self.nodes.iter().filter_map(|node| match &node.part {
            Part::Robot(robot) => Some(&**robot),
            _ => None,
        })
    }

    pub fn robots_mut(&mut self) -> impl Iterator<Item = &mut Robot> {
        self.nodes.iter_mut().filter_map(|node| match &mut node.part {
            Part::Robot(robot) => Some(&mut **robot),
            _ => None,
        })
    }

    /// The lines as a crossing sees them. The device of a line is its last emulated end.
    pub fn crossed_lines(&self) -> Vec<CrossedLine> {
        let of = |(line, name): (&Line, &Arc<str>)| CrossedLine {
            name: Arc::clone(name),
            is_can: line.is_can(),
            is_fd: line.is_fd(),
            device_end: line
                .ends()
                .iter()
                .rposition(|end| self.nodes[end.node].is_emulated())
                .unwrap_or_default(),
        };
        self.lines.iter().zip(&self.line_names).map(of).collect()
    }

    pub fn find(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|node| &*node.name == name)
    }
}

const fn at_only_port(what: Transmit) -> (PortId, Transmit) {
    (PortId(0), what)
}
