//! What has come through the lines is delivered, after whatever is crossed.

use super::SimulatedWorld;
use crate::hosted::{Hosted, HostedController as _};
use crate::properties::Seen;
use crate::record::Device;
use crate::record::sink::RecordSink;
use crate::world::bench::Carrier;
use crate::world::crossing::{Crossing, Line, Toward};
use crate::world::faults::Host;
use crate::world::lines::{BaseLink, Node};
use crate::world::watch::see;
use controller::{Input, Port};
use wire::can::CanFrame;
use wire::packet::Packet;
use wire::time::Timestamp;

impl<C: Crossing> SimulatedWorld<C> {
    pub(super) fn deliver(&mut self, sink: &mut impl RecordSink) {
        let Self { now, stage, crossing, controller, watch, touched, faults, .. } = self;
        let now = *now;
        let mut host = faults.as_mut().map(|faults| &mut faults.host);
        let (lines, bench) = (&mut stage.lines, &mut stage.bench);
        while let Some(mut packet) = lines.gyro.arrived(now) {
            if !crossing.bytes(Line::Gyro, Toward::Host, &mut packet) {
                continue;
            }
            sink.bytes(now, Device::Gyro, packet.as_slice());
            see(watch, now, &Seen::GyroBytes(packet.as_slice()));
            hear(controller, &mut host, now, Port::Gyro, packet);
            touched.controller = true;
        }
        while let Some(mut packet) = lines.gyro_commands.arrived(now) {
            if !crossing.bytes(Line::Gyro, Toward::Device, &mut packet) {
                continue;
            }
            sink.bytes(now, Device::Controller, packet.as_slice());
            bench.gyro.receive(now, packet.as_slice());
        }
        match (&mut lines.base, &mut bench.carrier) {
            (BaseLink::Can(bus), Carrier::Base(base)) => {
                while let Some((from, mut frame)) = bus.arrived(now) {
                    let toward = match from {
                        Node::Controller => Toward::Device,
                        Node::Base | Node::Stranger => Toward::Host,
                    };
                    if !crossing.frame(now, toward, &mut frame) {
                        continue;
                    }
                    match from {
                        Node::Controller => {
                            sink.frame(now, Device::Controller, frame);
                            base.receive_frame(now, &frame);
                            touched.carrier = true;
                        }
                        Node::Base => {
                            sink.frame(now, Device::Base, frame);
                            see(watch, now, &Seen::BaseFrame(&frame));
                            hear_frame(controller, &mut host, now, frame);
                            touched.controller = true;
                        }
                        Node::Stranger => {
                            sink.frame(now, Device::Plan, frame);
                            base.receive_frame(now, &frame);
                            see(watch, now, &Seen::BaseFrame(&frame));
                            hear_frame(controller, &mut host, now, frame);
                            (touched.carrier, touched.controller) = (true, true);
                        }
                    }
                }
            }
            (BaseLink::Serial { to_base, to_controller }, Carrier::Base(base)) => {
                while let Some(mut packet) = to_base.arrived(now) {
                    if !crossing.bytes(Line::Base, Toward::Device, &mut packet) {
                        continue;
                    }
                    sink.bytes(now, Device::Controller, packet.as_slice());
                    base.receive_bytes(now, packet.as_slice());
                    touched.carrier = true;
                }
                while let Some(mut packet) = to_controller.arrived(now) {
                    if !crossing.bytes(Line::Base, Toward::Host, &mut packet) {
                        continue;
                    }
                    sink.bytes(now, Device::Base, packet.as_slice());
                    see(watch, now, &Seen::BaseBytes(packet.as_slice()));
                    hear(controller, &mut host, now, Port::Base, packet);
                    touched.controller = true;
                }
            }
            _ => {}
        }
        let (table_reached, engine_reached) = stage.deliver_table_across(now, crossing, sink);
        touched.carrier |= table_reached;
        touched.engine |= engine_reached;
        if let Some(failure) = crossing.failure() {
            self.broke(&failure.to_string());
        }
    }

    /// Nodes that have left the bus, or come back to it, by faults.
    pub(super) fn note_confinement(&mut self, sink: &mut impl RecordSink) {
        let Self { faults: Some(faults), now, stage, watch, .. } = self else { return };
        if faults.record_confinement(*now, stage, sink) {
            see(watch, *now, &Seen::BusOff);
        }
    }
}

/// The controller hears bytes, at once unless its machine stands still.
fn hear(
    controller: &mut Hosted,
    host: &mut Option<&mut Host>,
    now: Timestamp,
    port: Port,
    packet: Packet,
) {
    match host {
        None => controller.receive(now, port, Input::Bytes(packet.as_slice())),
        Some(host) => host.bytes(now, port, packet, controller),
    }
}

/// The same for a frame.
fn hear_frame(
    controller: &mut Hosted,
    host: &mut Option<&mut Host>,
    now: Timestamp,
    frame: CanFrame,
) {
    match host {
        None => controller.receive(now, Port::Base, Input::Frame(frame)),
        Some(host) => host.frame(now, frame, controller),
    }
}
