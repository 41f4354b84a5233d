//! A gyro's stream while nothing else happens: the longest part of most runs.
//!
//! The controller receives each output when its bytes have arrived, and mostly sends nothing. Then the next event is
//! the next output or its arrival, and no other line, no node and no plan has to be queried. The result is the same as
//! that of the loop, event by event, faults and properties included.

use super::{EVENTS_PER_PULSE, Simulation};
use crate::Rig;
use crate::hosted::Hosted;
use crate::line::{EndId, Line};
use crate::node::{Node, Part, Route};
use crate::robot::GYRO;
use crate::touched::Touched;
use crate::watch::see;
use crate::{Keep, Sink};
use judge::properties::Seen;
use record::Device;
use wire::device::{PortId, Transmit};
use wire::packet::Packet;
use wire::time::{Span, Timestamp};

/// The only gyro of a rig, on its own serial line to a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream {
    robot: usize,
    line: usize,
    end: EndId,
    controller: usize,
    /// Port of the controller.
    port: PortId,
    /// Length of each output, and its time on the line.
    bytes: usize,
    takes: Span,
}

impl Stream {
    pub(super) fn of(rig: &Rig) -> Option<Self> {
        let is_robot = |node: &Node| matches!(node.part, Part::Robot(_));
        let robot = rig.nodes.iter().position(is_robot)?;
        let Route { line, end } = rig.nodes[robot].route(GYRO)?;
        let [one, other] = rig.lines[line].ends() else { return None };
        let (gyro, host) = if end == EndId::of(0) { (one, other) } else { (other, one) };
        let (controller, port) = (host.node, host.port);
        let bytes = rig.robot()?.bench.gyro_stream().format.facts().frame_bytes;
        let takes = rig.lines[line].time_for(bytes);
        let is_heard = matches!(rig.nodes[controller].part, Part::Controller(_));
        let is_alone = rig.robots().count() == 1 && gyro.who == Device::Gyro && !rig.is_read(line);
        (is_heard && is_alone).then_some(Self { robot, line, end, controller, port, bytes, takes })
    }
}

impl Simulation {
    /// Advances the stream until something else happens or `before` has come; returns when. `None` if a node had an
    /// output, which may change everything.
    pub(super) fn stream_alone(
        &mut self,
        Stream { robot, line, end, controller, port, bytes, takes }: Stream,
        before: Timestamp,
        sink: Sink<'_>,
        keep: Keep<'_>,
    ) -> Option<Timestamp> {
        if self.touched != Touched::default() || self.rig.lines.iter().any(Line::has_state_change) {
            return Some(self.next_event());
        }
        let others = self.rig.next_but_stream(robot, line, controller).min(self.plan_due);
        let others = others.min(self.next_fault()).min(before);
        let mut what = Transmit::Bytes(Packet::new());
        loop {
            let until = others.min(self.rig.nodes[controller].next_wakeup());
            let arrival = self.rig.lines[line].next_arrival();
            let is_near_pulse = self.is_near_pulse();
            let Part::Robot(emulated) = &mut self.rig.nodes[robot].part else { return None };
            let (at, late) = (emulated.bench.gyro.next_wakeup(), emulated.gyro_late);
            let next = (at + late).min(arrival);
            // Both at once are one event, which the loop handles.
            if next >= until || at + late == arrival || is_near_pulse {
                return Some(next.min(until));
            }
            self.events += 1;
            if arrival < at + late {
                // It was held up, or comes from the controller.
                self.begin_event(arrival);
                self.deliver(sink);
                break;
            }
            let has_output = emulated.gyro_output(at, &mut what).is_some();
            let until = until.min(emulated.bench.gyro.next_wakeup());
            self.begin_event(at + late);
            self.look_again();
            if !has_output {
                continue;
            }
            let arrival = at + takes;
            let is_whole = matches!(&what, Transmit::Bytes(packet) if packet.len() == bytes);
            if !is_whole || arrival >= until || !self.rig.lines[line].passes(at, arrival, end) {
                self.rig.lines[line].send(at, end, what);
                if late == Span::ZERO {
                    continue;
                }
                self.deliver(sink);
                break;
            }
            self.events += u64::from(late == Span::ZERO);
            self.begin_event(arrival);
            self.carried(line, end, &mut what, |simulation, what| {
                if let Transmit::Bytes(packet) = what {
                    sink.bytes(arrival, Device::Gyro, packet.as_slice());
                    see(&mut simulation.watch, arrival, &Seen::GyroBytes(packet.as_slice()));
                }
                if let Part::Controller(machine) = &mut simulation.rig.nodes[controller].part {
                    machine.host.receive(arrival, port, what);
                }
            });
            if self.touched != Touched::default() || !self.rig.is_silent(controller, arrival) {
                self.touched.node(controller);
                break;
            }
            self.look_again();
        }
        self.wake();
        self.look_again();
        self.transmit(sink, keep);
        None
    }

    /// A check outside the loop is due before or after the next event.
    const fn is_near_pulse(&self) -> bool {
        (self.events + 1) % EVENTS_PER_PULSE < 2
    }
}

impl Rig {
    /// Whether our controller at that place has no output; if so, updates its next wake-up.
    #[inline]
    fn is_silent(&mut self, place: usize, now: Timestamp) -> bool {
        let Part::Controller(machine) = &mut self.nodes[place].part else { return false };
        if machine.host.is_stalled() {
            return true;
        }
        let told = machine.host.told(now);
        let is_silent =
            matches!(&machine.host.guest, Hosted::Ours(ours) if ours.has_nothing_to_say(told));
        if is_silent {
            machine.ask_due();
        }
        is_silent
    }

    /// Time of the next event outside the stream of that gyro and its line.
    fn next_but_stream(&self, robot: usize, line: usize, controller: usize) -> Timestamp {
        let of_node = |(place, node): (usize, &Node)| match &node.part {
            Part::Robot(emulated) if place == robot => emulated.carrier_due,
            _ if place == controller => Timestamp::MAX,
            _ => node.next_wakeup(),
        };
        let nodes = self.nodes.iter().enumerate().map(of_node);
        let others = self.lines.iter().enumerate().filter(|(place, _)| *place != line);
        let arrivals = others.map(|(_, other)| other.next_arrival());
        nodes.chain(arrivals).min().unwrap_or(Timestamp::MAX)
    }
}
