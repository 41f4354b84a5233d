//! Delivery: what has come through a line reaches the nodes at its other ends, and those who read along.

use super::line::EndId;
use super::simulate::Simulation;
use super::touched::Touched;
use crate::Sink;
use crate::watch::see;
use judge::properties::Seen;
use record::Device;
use wire::device::Transmit;

impl Simulation {
    /// Delivers what has arrived through the lines, after the crossing.
    pub(super) fn deliver(&mut self, sink: Sink<'_>) {
        let now = self.now;
        for line in 0..self.rig.lines.len() {
            if self.rig.lines[line].next_arrival() > now {
                continue;
            }
            while let Some((from, mut what)) = self.rig.lines[line].arrived(now) {
                self.carried(line, from, &mut what, |simulation, what| {
                    simulation.delivered(sink, line, from, what);
                });
            }
        }
    }

    /// Delivers what has arrived through a line, as it comes out of the crossing.
    #[inline]
    pub(super) fn carried(
        &mut self,
        line: usize,
        from: EndId,
        what: &mut Transmit,
        mut deliver: impl FnMut(&mut Self, &Transmit),
    ) {
        let Some(crossing) = &mut self.crossing else { return deliver(self, what) };
        let mut came = crossing.carry(self.now, line, from.place(), what);
        while came {
            deliver(self, what);
            let more = self.crossing.as_mut().and_then(|crossing| crossing.more());
            came = more.map(|more| *what = more).is_some();
        }
        if let Some(failure) = self.crossing.as_mut().and_then(|crossing| crossing.failure()) {
            self.broke(&failure.to_string());
        }
    }

    #[inline]
    pub(super) fn delivered(&mut self, sink: Sink<'_>, line: usize, from: EndId, what: &Transmit) {
        let Self { now, rig, director, touched, watch, .. } = self;
        let (now, who) = (*now, rig.lines[line].who(from));
        match what {
            Transmit::Bytes(packet) => sink.bytes(now, who, packet.as_slice()),
            Transmit::Frame(frame) => sink.frame(now, who, *frame),
        }
        if let Some(watch) = watch {
            let bench = || rig.robot().map(|robot| &robot.bench);
            match (what, who) {
                (Transmit::Bytes(packet), Device::Gyro) => {
                    watch.see(now, &Seen::GyroBytes(packet.as_slice()));
                }
                (Transmit::Bytes(packet), Device::Base) => {
                    watch.hear_base(now, &Seen::BaseBytes(packet.as_slice()), bench());
                }
                (Transmit::Frame(frame), Device::Base | Device::Plan) => {
                    watch.hear_base(now, &Seen::BaseFrame(frame), bench());
                }
                (_, Device::Controller) => watch.see(now, &Seen::Carried(what)),
                _ => {}
            }
        }
        rig.hand_over(now, line, from, what, |node| touched.node(node));
        let unexpected = rig.read(now, (line, from), what, |speaker, decoded| {
            director.engine.message(now, speaker, &decoded);
            touched.0 |= Touched::PLAN;
            see(watch, now, &Seen::Message { speaker, decoded });
        });
        director.engine.unexpected(&rig.line_names[line], unexpected);
        if let (Device::Table, Transmit::Bytes(packet)) = (who, what) {
            director.hear_table(now, packet.as_slice());
            touched.0 |= Touched::PLAN;
        }
    }
}
