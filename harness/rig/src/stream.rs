//! A gyro's stream while nothing else happens: the longest part of most runs.
//!
//! The controller hears each output when its bytes are through the line, and mostly has nothing to say. Then the next thing
//! that happens is the next output, and neither lines nor nodes nor the plan have to be asked for it. What comes of it is
//! what the loop would make of it, event by event.

use super::Rig;
use super::line::EndId;
use super::node::Node;
use super::node::{Part, Route};
use super::robot::GYRO;
use super::simulate::{EVENTS_PER_PULSE, Simulation};
use super::touched::Touched;
use crate::crossing::Crossing;
use crate::engine::Action;
use crate::hosted::Hosted;
use record::Device;
use record::sink::RecordSink;
use wire::device::{PortId, Transmit};
use wire::time::Timestamp;

/// The only gyro of a rig, on a serial line of its own with a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    robot: usize,
    line: usize,
    end: EndId,
    controller: usize,
    /// The controller's.
    port: PortId,
    /// Of each output.
    bytes: usize,
}

impl Stream {
    /// That of `rig`, whose gyros are [late](Rig::wake_gyros_late).
    pub(super) fn of(rig: &Rig) -> Option<Self> {
        let is_robot = |node: &Node| matches!(node.part, Part::Robot(_));
        let robot = rig.nodes.iter().position(is_robot)?;
        let Route { line, end } = rig.nodes[robot].route(GYRO)?;
        let [one, other] = rig.lines[line].ends() else { return None };
        let (gyro, host) = if end == EndId::of(0) { (one, other) } else { (other, one) };
        let (controller, port) = (host.node, host.port);
        let bytes = rig.robot()?.bench.gyro_stream().format.frame_bytes();
        let is_heard = matches!(rig.nodes[controller].part, Part::Controller(_));
        let is_alone = rig.robots().count() == 1 && gyro.who == Device::Gyro && !rig.is_read(line);
        (is_heard && is_alone).then_some(Self { robot, line, end, controller, port, bytes })
    }
}

impl<C: Crossing> Simulation<C> {
    /// Carries the stream on until something else happens, or somebody has something to say; false where it did not go on.
    pub(super) fn stream_alone(
        &mut self,
        Stream { robot, line, end, controller, port, bytes }: Stream,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
    ) -> bool {
        if self.touched != Touched::default() {
            return false;
        }
        let before = self.events;
        let others = self.rig.next_but_stream(robot, controller).min(self.plan_due);
        loop {
            let until = others.min(self.rig.nodes[controller].next_wakeup());
            let Part::Robot(emulated) = &mut self.rig.nodes[robot].part else { return false };
            let due = emulated.bench.gyro.next_wakeup();
            let now = due + emulated.gyro_late;
            if now >= until || self.events.is_multiple_of(EVENTS_PER_PULSE) {
                return self.events > before;
            }
            let output = emulated.gyro_output(due);
            self.events += 1;
            self.begin_event(now);
            let Some((at, mut what)) = output else { continue };
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
    /// The controller there, if it is ours, has nothing to say; then it is asked when it wants to be woken.
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

    /// When something happens next but in the stream of that gyro.
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
