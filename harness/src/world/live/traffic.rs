//! What crosses between the ports of the harness and the lines, the emulated devices and the record.

use super::clock::Clock;
use super::device_under_test::Running;
use super::ports::{BASE, GYRO, Ports, TABLE, TABLE_DEVICE, device};
use super::role_port::PortEvent;
use super::{LiveWorld, Player};
use crate::engine::Action;
use crate::outcome::PortSide;
use crate::port::PortSpec;
use crate::properties::Seen;
use crate::record::Device;
use crate::record::sink::RecordSink;
use crate::world::bench::Carrier;
use crate::world::lines::{BaseLink, Node};
use crate::world::stage::Stage;
use wire::base::Message;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::packet::Packet;
use wire::time::Timestamp;

/// Keeps what crossed a port in a full record.
fn record(sink: &mut impl RecordSink, now: Timestamp, by: Device, crossed: Transmit) {
    match crossed {
        Transmit::Bytes(packet) => sink.bytes(now, by, packet.as_slice()),
        Transmit::Frame(frame) => sink.frame(now, by, frame),
    }
}

impl LiveWorld {
    fn gyro_is_emulated(&self) -> bool {
        self.setting.placement.gyro.is_emulated()
    }

    fn base_is_emulated(&self) -> bool {
        self.setting.placement.base.as_ref().is_some_and(Player::is_emulated)
    }

    /// What crossed the ports of a controller in this process: for the record, where nobody else hears it, and for
    /// whoever watches.
    pub(super) fn overhear(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        device: &mut Running,
    ) {
        while let Some(crossing) = device.crossing() {
            if self.setting.placement.is_unheard(crossing.role) {
                record(sink, now, crossing.by, crossing.crossed);
            }
            if let Some(eyes) = &mut self.eyes {
                eyes.within(now, &self.stage.bench.carrier, &crossing);
            }
        }
        if let Some(eyes) = &mut self.eyes {
            eyes.look_again(now, &self.stage.bench.carrier);
        }
    }

    /// Something that the controller says, or hears, crossed a port of the harness.
    fn watch_line(&mut self, now: Timestamp, role: &str, by: Device, crossed: Transmit) {
        if let Some(eyes) = &mut self.eyes {
            eyes.line(now, role, by, crossed);
        }
    }

    /// Takes what a port of the harness tells.
    pub(super) fn hear(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        ports: &Ports,
        role: &'static str,
        event: PortEvent,
    ) {
        match &event {
            PortEvent::Bytes(packet) if role == GYRO || role == BASE => {
                self.watch_line(now, role, Device::Controller, Transmit::Bytes(*packet));
            }
            PortEvent::Bus(event) if role == BASE && event.bus_off => self.see(now, &Seen::BusOff),
            _ => {}
        }
        match (role, event) {
            (GYRO, PortEvent::Bytes(packet)) => self.stage.lines.gyro_commands.send(now, packet),
            (BASE, PortEvent::Bytes(packet)) => {
                if let BaseLink::Serial { to_base, .. } = &mut self.stage.lines.base {
                    to_base.send(now, packet);
                }
            }
            (TABLE_DEVICE, PortEvent::Bytes(packet)) => {
                follow(&mut self.stage.bench.carrier, now, &packet)
            }
            (_, PortEvent::Bytes(packet)) => self.stage.hear_table(now, sink, packet.as_slice()),
            (_, PortEvent::Frame(frame)) => self.hear_frame(now, sink, ports.name(role), frame),
            (role, event) => {
                let whose = match role {
                    TABLE => (TABLE, PortSide::Plan),
                    TABLE_DEVICE => (TABLE, PortSide::Bench),
                    role => (role, PortSide::Bench),
                };
                if let Some(note) = self.journal.take(now, whose, ports.name(role), &event) {
                    self.stage.note(now, sink, device(role), note);
                }
            }
        }
    }

    /// A frame from the bus of the base. Frames that the harness itself sends are not heard.
    fn hear_frame(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        port: &str,
        frame: CanFrame,
    ) {
        let message = Message::from_can_id(frame.id());
        let of_base = message.is_some_and(Message::is_reply);
        let placed = self.setting.placement.base.as_ref().map(Player::spec);
        if message.is_none() && matches!(placed, Some(PortSpec::Can { .. })) {
            // It has had its time on the bus of the kernel, and concerns nobody here: among the frames that are
            // paced here it would only take their room.
            self.foreign.take(now, &frame);
            sink.frame(now, Device::Controller, frame);
            return;
        }
        // Frames of a base that is emulated are heard when it sends them, not from somebody else.
        if !(self.base_is_emulated() && of_base) {
            let by = if of_base { Device::Base } else { Device::Controller };
            self.watch_line(now, BASE, by, Transmit::Frame(frame));
        }
        match (self.base_is_emulated(), of_base) {
            (true, false) => {
                if let BaseLink::Can(bus) = &mut self.stage.lines.base {
                    bus.send(now, Node::Controller, frame);
                }
            }
            (true, true) => {
                sink.frame(now, Device::Base, frame);
                self.clash(now, sink, port, &frame);
            }
            (false, true) => sink.frame(now, Device::Base, frame),
            (false, false) => sink.frame(now, Device::Controller, frame),
        }
    }

    /// Two nodes send frames of one identifier: on a real bus an error, here a base that is two.
    fn clash(&mut self, now: Timestamp, sink: &mut impl RecordSink, port: &str, frame: &CanFrame) {
        self.clashes += 1;
        let id = match frame.id() {
            wire::can::Id::Standard(id) => u32::from(id.as_raw()),
            wire::can::Id::Extended(id) => id.as_raw(),
        };
        let why = format!(
            "another node on {port} sends frames of the base (identifier {id:#05x}), which is emulated here"
        );
        if let Some(note) = self.journal.note(why.clone()) {
            self.stage.note(now, sink, Device::Base, note);
        }
        if self.clashes == 1 {
            self.stage.engine.broke(now, &why);
        }
    }

    /// Hands over what has passed its line by now.
    pub(super) fn deliver(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        ports: &mut Ports,
    ) {
        // The gyro's outputs first, each at its own instant: they must not see what the base does later.
        self.stage.wake_gyro(now);
        let (eyes, Stage { lines, bench, .. }) = (&mut self.eyes, &mut self.stage);
        let mut watch = |role, crossed| {
            if let Some(eyes) = eyes {
                eyes.line(now, role, device(role), crossed);
            }
        };
        while let Some(packet) = lines.gyro_commands.arrived(now) {
            sink.bytes(now, Device::Controller, packet.as_slice());
            bench.gyro.receive(now, packet.as_slice());
        }
        // Nobody listens to an emulator whose role a real port plays.
        while let Some(packet) = lines.gyro.arrived(now) {
            if let Some(port) = &mut ports.gyro {
                sink.bytes(now, Device::Gyro, packet.as_slice());
                watch(GYRO, Transmit::Bytes(packet));
                port.send_bytes(packet.as_slice());
            }
        }
        if let (Carrier::Base(emulator), Some(port)) = (&mut bench.carrier, &mut ports.base) {
            match &mut lines.base {
                BaseLink::Serial { to_base, to_controller } => {
                    while let Some(packet) = to_base.arrived(now) {
                        sink.bytes(now, Device::Controller, packet.as_slice());
                        emulator.receive_bytes(now, packet.as_slice());
                    }
                    while let Some(packet) = to_controller.arrived(now) {
                        sink.bytes(now, Device::Base, packet.as_slice());
                        watch(BASE, Transmit::Bytes(packet));
                        port.send_bytes(packet.as_slice());
                    }
                }
                BaseLink::Can(bus) => {
                    while let Some((from, frame)) = bus.arrived(now) {
                        match from {
                            Node::Controller => {
                                sink.frame(now, Device::Controller, frame);
                                emulator.receive_frame(now, &frame);
                            }
                            Node::Base => {
                                sink.frame(now, Device::Base, frame);
                                watch(BASE, Transmit::Frame(frame));
                                port.send_frame(now, &frame);
                            }
                            Node::Stranger => {
                                sink.frame(now, Device::Plan, frame);
                                emulator.receive_frame(now, &frame);
                                watch(BASE, Transmit::Frame(frame));
                                port.send_frame(now, &frame);
                            }
                        }
                    }
                }
                BaseLink::None => {}
            }
        }
        match &mut ports.table {
            None => _ = self.stage.deliver_table(now, sink),
            Some(port) => {
                while let Some(packet) = lines.to_table.arrived(now) {
                    sink.bytes(now, Device::Plan, packet.as_slice());
                    port.send_bytes(packet.as_slice());
                    if ports.table_device.is_none() {
                        follow(&mut bench.carrier, now, &packet);
                    }
                }
                while let Some(packet) = lines.from_table.arrived(now) {
                    // The real one answers for itself.
                    if let Some(device) = &mut ports.table_device {
                        device.send_bytes(packet.as_slice());
                    }
                }
            }
        }
        self.watch_confinement(now, sink);
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        if self.stage.bench.carrier.next_wakeup() <= now {
            self.stage.bench.carrier.wake(now);
        }
        if self.stage.engine.next_wakeup() <= now {
            self.stage.engine.wake(now);
        }
    }

    pub(super) fn transmit(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        keep: &mut impl FnMut(&Action),
        device: &mut Running,
        clock: &Clock,
    ) {
        let real_base = self.setting.placement.base.is_some() && !self.base_is_emulated();
        loop {
            let mut quiet = true;
            while let Some(sent) = self.stage.bench.carrier.transmit() {
                if !real_base {
                    self.stage.carry(now, sent);
                }
            }
            while let Some(action) = self.stage.engine.action() {
                quiet = false;
                if let Some(eyes) = &mut self.eyes {
                    eyes.see_action(now, &self.stage.bench.carrier, &action);
                }
                if let (Action::Phase(event), Some(faults)) = (&action, &mut self.faults) {
                    faults.phase(now, event);
                    continue;
                }
                let host = self.faults.as_mut().map(|faults| &mut faults.host);
                if let Some(mission) = self.stage.act(now, sink, keep, action)
                    && !device.command(clock, mission, host)
                {
                    self.stage.engine.lost_controller(now, "it takes no more missions");
                }
            }
            if quiet {
                return;
            }
        }
    }

    pub(super) fn next_due(&self) -> Timestamp {
        let gyro = if self.gyro_is_emulated() {
            self.stage.bench.gyro.next_wakeup()
        } else {
            Timestamp::MAX
        };
        self.stage
            .lines
            .next_arrival()
            .min(gyro)
            .min(self.stage.bench.carrier.next_wakeup())
            .min(self.stage.engine.next_wakeup())
            .min(self.faults.as_ref().map_or(Timestamp::MAX, |faults| faults.next_due()))
    }
}

/// The emulated table takes a command: its own, or that of the real one, so that an emulated gyro on it turns.
fn follow(carrier: &mut Carrier, now: Timestamp, command: &Packet) {
    if let Carrier::Table(table) = carrier {
        table.receive(now, command.as_slice());
    }
}
