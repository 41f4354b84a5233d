//! Traffic between the ports of the harness, the lines of the rig, and the record.

use super::LiveWorld;
use super::clock::Clock;
use super::commands::Commands;
use super::device_under_test::Running;
use super::journal::{Work, note};
use super::placement::Player;
use super::ports::{BASE, GYRO, OpenPort, PortPlan, Ports};
use super::role_port::PortEvent;
use judge::properties::Seen;
use plan::Order;
use ports::PortSpec;
use record::Device;
use rig::engine::Action;
use rig::line::EndId;
use rig::{Keep, Sink};
use wire::base::Message;
use wire::can::CanFrame;
use wire::device::Transmit;
use wire::time::Timestamp;

/// The controller and the base.
const ROBOT_ENDS: usize = 2;

/// Records traffic of a line, in a full record.
fn record(sink: Sink<'_>, now: Timestamp, by: Device, what: &Transmit) {
    match what {
        Transmit::Bytes(packet) => sink.bytes(now, by, packet.as_slice()),
        Transmit::Frame(frame) => sink.frame(now, by, *frame),
    }
}

impl LiveWorld {
    /// Takes what crossed the ports of an in-process controller: for the record, if the harness does not see it
    /// elsewhere, and for the monitor.
    pub(super) fn overhear(&mut self, now: Timestamp, sink: Sink<'_>, device: &mut Running) {
        while let Some(crossing) = device.crossing() {
            if self.setting.is_unheard(crossing.role) {
                record(sink, now, crossing.by, &crossing.crossed);
            }
            if let (Some(eyes), Some(robot)) = (&mut self.eyes, self.rig.robot()) {
                eyes.within(now, &robot.bench, &crossing);
            }
        }
        if let (Some(eyes), Some(robot)) = (&mut self.eyes, self.rig.robot()) {
            eyes.look_again(now, &robot.bench);
        }
    }

    pub(super) fn hear(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        ports: &Ports,
        place: usize,
        event: PortEvent,
    ) {
        let Some(OpenPort { plan, port, .. }) = ports.open.get(place) else { return };
        let role = &*plan.role;
        match event {
            PortEvent::Frame(frame) if role == BASE => {
                self.hear_base(now, sink, port.name(), plan, frame);
            }
            PortEvent::Frame(frame) => self.heard(now, plan, Transmit::Frame(frame)),
            PortEvent::Bytes(packet) => {
                if let Some(eyes) = self.eyes.as_mut().filter(|_| role == GYRO || role == BASE) {
                    eyes.line(now, role, Device::Controller, Transmit::Bytes(packet));
                }
                self.heard(now, plan, Transmit::Bytes(packet));
            }
            event => {
                if let PortEvent::Bus(told) = &event
                    && role == BASE
                    && told.bus_off
                {
                    self.see(now, &Seen::BusOff);
                }
                let whose = (plan.role.clone(), plan.side);
                let port = (port.name(), port.unsent());
                if let Some(what) = self.journal.take(now, whose, port, &event) {
                    note(sink, now, plan.who, what);
                }
            }
        }
    }

    /// Puts what came from a port on its line, sent by the end whose message it is.
    fn heard(&mut self, now: Timestamp, plan: &PortPlan, what: Transmit) {
        let end = self.rig.speaker_of(plan.line, plan.end, &what);
        let line = &mut self.rig.lines[plan.line];
        match (what, &plan.spec) {
            (Transmit::Frame(frame), PortSpec::Can { .. } | PortSpec::Slcan { .. }) => {
                line.carried(now, end, frame);
            }
            _ => line.send(now, end, what),
        }
    }

    /// Takes a frame from the bus of the base. The harness does not receive its own frames.
    fn hear_base(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        port: &str,
        plan: &PortPlan,
        frame: CanFrame,
    ) {
        let (line, end) = (plan.line, plan.end);
        let message = Message::from_can_id(frame.id());
        let of_base = message.is_some_and(Message::is_reply);
        let what = Transmit::Frame(frame);
        // Other nodes of the rig may be on the bus.
        if message.is_none() && self.rig.lines[line].ends().len() > ROBOT_ENDS {
            return self.heard(now, plan, what);
        }
        if message.is_none() && matches!(self.setting.base_port(), Some(PortSpec::Can { .. })) {
            // It has had its time on the bus of the kernel and concerns no device here; among the frames paced here it
            // would only take up room.
            self.foreign.take(now, &frame);
            record(sink, now, Device::Controller, &what);
            return;
        }
        let is_emulated = self.rig.robot().is_some_and(|robot| !robot.carrier_is_real);
        let by = if of_base { Device::Base } else { Device::Controller };
        // Frames of an emulated base are shown when it sends them, not when another node does.
        if let Some(eyes) = self.eyes.as_mut().filter(|_| !(is_emulated && of_base)) {
            eyes.line(now, BASE, by, what);
        }
        match (is_emulated, of_base) {
            (true, false) => self.rig.lines[line].send(now, end, what),
            (true, true) => {
                record(sink, now, by, &what);
                self.clash(now, sink, port, &frame);
            }
            (false, _) => record(sink, now, by, &what),
        }
    }

    /// Two nodes send frames with one identifier: an error on a real bus, and here two bases.
    fn clash(&mut self, now: Timestamp, sink: Sink<'_>, port: &str, frame: &CanFrame) {
        self.clashes += 1;
        let id = match frame.id() {
            wire::can::Id::Standard(id) => u32::from(id.as_raw()),
            wire::can::Id::Extended(id) => id.as_raw(),
        };
        let why = format!(
            "another node on {port} sends frames of the base (identifier {id:#05x}), which is emulated here"
        );
        if let Some(what) = self.journal.note(why.clone()) {
            note(sink, now, Device::Base, what);
        }
        if self.clashes == 1 {
            self.director.engine.broke(now, &why);
        }
    }

    pub(super) fn deliver(&mut self, now: Timestamp, sink: Sink<'_>, ports: &mut Ports) {
        // The gyro's outputs first, each at its own instant: later actions of the base must not affect them.
        for place in 0..self.rig.nodes.len() {
            self.rig.wake_gyro(now, place);
        }
        for line in 0..self.rig.lines.len() {
            while self.rig.lines[line].next_arrival() <= now
                && let Some((from, what)) = self.rig.lines[line].arrived(now)
            {
                self.delivered(now, sink, ports, (line, from), &what);
            }
        }
        self.watch_confinement(now, sink);
    }

    fn delivered(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        ports: &mut Ports,
        (line, from): (usize, EndId),
        what: &Transmit,
    ) {
        let Self { rig, director, eyes, .. } = self;
        let who = rig.lines[line].who(from);
        let is_recorded = rig.lines[line].is_recorded();
        if is_recorded {
            record(sink, now, who, what);
        }
        rig.hand_over(now, line, from, what, |_| {});
        let is_away = |end: EndId| rig.is_away(line, end);
        for open in ports.of_line(line) {
            let plan = &open.plan;
            // One port may stand for several nodes of a bus: it does not get its own data back.
            let came_from_it = from == plan.end || (is_away(from) && is_away(plan.end));
            let is_missed = rig.lines[line].misses(plan.end);
            if plan.listens || came_from_it || is_missed {
                continue;
            }
            if let Some(eyes) = eyes {
                eyes.line(now, &plan.role, who, *what);
            }
            open.send(now, what);
        }
        if !is_recorded {
            return;
        }
        let unexpected = rig.read(now, (line, from), what, |speaker, decoded| {
            director.engine.message(now, speaker, &decoded);
            if let Some(eyes) = eyes {
                eyes.see(now, &Seen::Message { speaker, decoded });
            }
        });
        director.engine.unexpected(&rig.line_names[line], unexpected);
        if let (Device::Table, Transmit::Bytes(packet)) = (who, what) {
            director.hear_table(now, packet.as_slice());
        }
    }

    pub(super) fn wake(&mut self, now: Timestamp) {
        let Self { rig, director, .. } = self;
        rig.wake_emulated(now, |_| {}, |woken| director.engine.woken(now, woken));
        rig.wake_others(now, &mut director.engine, |_| {});
        if director.engine.next_wakeup() <= now {
            director.engine.wake(now);
        }
    }

    pub(super) fn transmit(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        keep: Keep<'_>,
        (device, commands): (&mut Running, &mut Commands),
        clock: &Clock,
    ) {
        loop {
            let mut quiet = true;
            for place in 0..self.rig.nodes.len() {
                self.rig.empty(now, place);
            }
            while let Some(action) = self.director.engine.action() {
                quiet = false;
                if let (Some(eyes), Some(robot)) = (&mut self.eyes, self.rig.robot()) {
                    eyes.see_action(now, &robot.bench, &action);
                }
                if let (Action::Phase(event), Some(faults)) = (&action, &mut self.faults) {
                    faults.phase(now, event);
                    continue;
                }
                if let Action::Order(Order::PowerCycle { device, .. }) = &action
                    && matches!(self.setting.site.player(device), Some(Player::Real(_)))
                {
                    self.journal.work = Work::UnderWay;
                }
                if let Action::Order(Order::Command(name)) = &action {
                    self.journal.work = Work::UnderWay;
                    if let Err(why) =
                        commands.start(now, &format!("at {:.3} s", now.as_secs_f64()), name)
                    {
                        self.director.engine.broke(now, &why);
                    }
                    continue;
                }
                if let Some(mission) = self.director.act(now, &mut self.rig, sink, keep, action)
                    && !device.command(clock, mission)
                {
                    self.director.engine.lost_controller(now, "takes no more missions");
                }
            }
            if quiet {
                return;
            }
        }
    }

    pub(super) fn next_due(&self) -> Timestamp {
        self.rig
            .next_arrival()
            .min(self.rig.next_wakeup())
            .min(self.director.engine.next_wakeup())
            .min(self.faults.as_ref().map_or(Timestamp::MAX, |faults| faults.next_due()))
    }
}
