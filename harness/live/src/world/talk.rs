//! What the device under test says.

use super::LiveWorld;
use super::device_under_test::Running;
use super::heard::Heard;
use super::journal::note;
use record::Device;
use record::outcome::PortSide;
use rig::Sink;
use rig::talk::Talk;
use wire::time::Timestamp;

impl LiveWorld {
    pub(super) fn hear_device(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        device: &Running,
        heard: Heard,
    ) {
        match heard {
            Heard::Report(_) if self.director.talk.floods(now) => {
                self.director.engine.failed(now, &Talk::why());
            }
            Heard::Report(report) => {
                if let (Some(eyes), Some(robot)) = (&mut self.eyes, self.rig.robot()) {
                    eyes.report(now, &robot.bench, &report);
                }
                self.director.record_report(now, &mut self.rig, sink, &report);
                self.director.engine.report(now, &report);
            }
            Heard::Nothing => {}
            Heard::BadLine(what) if self.director.talk.misspoke() => {
                note(sink, now, Device::Controller, what);
            }
            Heard::BadLine(_) => {}
            Heard::Misreport(what) => self.director.engine.failed(now, &what),
            Heard::Note(what) => note(sink, now, Device::Controller, what),
            Heard::Port(role, event) => {
                let port = device.in_process().and_then(|here| here.port(role));
                let port = port.map_or(("", 0), |port| (port.name(), port.unsent()));
                let whose = (role.into(), PortSide::Controller);
                if let Some(what) = self.journal.take(now, whose, port, &event) {
                    note(sink, now, Device::Controller, what);
                }
            }
            Heard::Lost(why) => self.director.engine.broke(now, &why),
            Heard::Ended(how) => self.director.engine.lost_controller(now, &how),
            Heard::NodeEnded(node, how) => self.director.engine.lost_node(now, &node, &how),
        }
    }
}
