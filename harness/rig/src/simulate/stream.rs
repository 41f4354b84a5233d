//! A gyro's stream while nothing else happens: the longest part of most runs.
//!
//! The controller receives each output when its bytes have arrived, and mostly sends nothing. Then the next event is
//! the next output, and no line, node or plan has to be queried. The result is the same as that of the loop, event by
//! event.

use super::{EVENTS_PER_PULSE, Simulation};
use crate::Rig;
use crate::engine::Action;
use crate::hosted::Hosted;
use crate::line::EndId;
use crate::node::{Node, Part, Route};
use crate::robot::GYRO;
use crate::touched::Touched;
use record::Device;
use record::sink::RecordSink;
use wire::device::{PortId, Transmit};
use wire::packet::Packet;
use wire::time::Timestamp;

/// The only gyro of a rig, on its own serial line to a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    robot: usize,
    line: usize,
    end: EndId,
    controller: usize,
    /// Port of the controller.
    port: PortId,
    /// Length of each output.
    bytes: usize,
}

impl Stream {
    /// The stream of `rig`, whose gyros are [late](Rig::wake_gyros_late).
    pub(super) fn of(rig: &Rig) -> Option<Self> {
        let is_robot = |node: &Node| matches!(node.part, Part::Robot(_));
        let robot = rig.nodes.iter().position(is_robot)?;
        let Route { line, end } = rig.nodes[robot].route(GYRO)?;
        let [one, other] = rig.lines[line].ends() else { return None };
        let (gyro, host) = if end == EndId::of(0) { (one, other) } else { (other, one) };
        let (controller, port) = (host.node, host.port);
        let bytes = rig.robot()?.bench.gyro_stream().format.facts().frame_bytes;
        let is_heard = matches!(rig.nodes[controller].part, Part::Controller(_));
        let is_alone = rig.robots().count() == 1 && gyro.who == Device::Gyro && !rig.is_read(line);
        (is_heard && is_alone).then_some(Self { robot, line, end, controller, port, bytes })
    }
}

impl Simulation {
    /// Advances the stream until something else happens or a node has an output; returns `false` if it did not advance.
    pub(super) fn stream_alone(
        &mut self,
        Stream { robot, line, end, controller, port, bytes }: Stream,
        sink: &mut dyn RecordSink,
        keep: &mut dyn FnMut(&Action),
    ) -> bool {
        if self.touched != Touched::default() {
            return false;
        }
        let before = self.events;
        let others = self.rig.next_but_stream(robot, controller).min(self.plan_due);
        let mut what = Transmit::Bytes(Packet::new());
        loop {
            let until = others.min(self.rig.nodes[controller].next_wakeup());
            let Part::Robot(emulated) = &mut self.rig.nodes[robot].part else { return false };
            let due = emulated.bench.gyro.next_wakeup();
            let now = due + emulated.gyro_late;
            if now >= until || self.events.is_multiple_of(EVENTS_PER_PULSE) {
                return self.events > before;
            }
            let at = emulated.gyro_output(due, &mut what);
            self.events += 1;
            self.begin_event(now);
            let Some(at) = at else { continue };
            let is_whole = matches!(&what, Transmit::Bytes(packet) if packet.len() == bytes);
            let passes = is_whole && self.rig.lines[line].passes(at, now, end);
            if passes {
                self.carried(line, end, &mut what, |simulation, what| {
                    if let Transmit::Bytes(packet) = what {
                        sink.bytes(now, Device::Gyro, packet.as_slice());
                    }
                    if let Part::Controller(machine) = &mut simulation.rig.nodes[controller].part {
                        machine.host.receive(now, port, what);
                    }
                });
            } else {
                self.rig.lines[line].send(at, end, what);
                self.deliver(sink);
            }
            if passes {
                if self.touched == Touched::default() && self.rig.is_silent(controller, now) {
                    continue;
                }
                self.touched.node(controller);
            }
            self.wake();
            self.transmit(sink, keep);
            return true;
        }
    }
}

impl Rig {
    /// Whether our controller at that place has no output; if so, updates its next wake-up.
    #[inline]
    fn is_silent(&mut self, place: usize, now: Timestamp) -> bool {
        let Part::Controller(machine) = &mut self.nodes[place].part else { return false };
        let is_silent =
            matches!(&machine.host.guest, Hosted::Ours(ours) if ours.has_nothing_to_say(now));
        if is_silent {
            machine.ask_due();
        }
        is_silent
    }

    /// Time of the next event outside the stream of that gyro.
    fn next_but_stream(&self, robot: usize, controller: usize) -> Timestamp {
        let next = |(place, node): (usize, &Node)| match &node.part {
            Part::Robot(emulated) if place == robot => emulated.carrier_due,
            _ if place == controller => Timestamp::MAX,
            _ => node.next_wakeup(),
        };
        let nodes = self.nodes.iter().enumerate().map(next);
        nodes.min().unwrap_or(Timestamp::MAX).min(self.next_arrival())
    }
}
