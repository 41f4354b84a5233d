//! What goes wrong on purpose in real time: the same schedule, lines and switches as in virtual time, struck when
//! the real clock says so.

use super::LiveWorld;
use super::clock::Clock;
use super::device_under_test::Running;
use super::traffic::note;
use judge::properties::Seen;
use record::sink::RecordSink;
use record::{Device, FaultSummary};
use wire::time::Timestamp;

impl LiveWorld {
    /// Shows it to whoever watches.
    pub(super) fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        if let Some(eyes) = &mut self.eyes {
            eyes.see(now, seen);
        }
    }

    /// Faults that are due begin and end.
    pub(super) fn strike(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        device: &mut Running,
        clock: &Clock,
    ) {
        let Some(faults) = self.faults.as_mut().filter(|faults| faults.next_due() <= now) else {
            return;
        };
        // What was due before has happened before.
        self.rig.wake_emulated(now, |_| {}, || self.director.engine.answered(now));
        let machine = device.machine();
        if faults.strike(now, &mut self.rig, &mut self.director, machine, sink) {
            device.struck(clock, now);
            let seen = faults.seen();
            self.see(now, &seen);
        }
    }

    /// What became of the nodes of the bus.
    pub(super) fn watch_confinement(&mut self, now: Timestamp, sink: &mut impl RecordSink) {
        let Some(faults) = &self.faults else { return };
        if faults.record_confinement(now, &mut self.rig, sink) {
            self.see(now, &Seen::BusOff);
        }
    }

    /// The run is over: what was counted, what became of the faults, and what found no room anywhere.
    pub(super) fn end_faults(
        &mut self,
        now: Timestamp,
        sink: &mut impl RecordSink,
        device: &mut Running,
    ) -> (Vec<FaultSummary>, u64) {
        for remark in self.rig.remarks() {
            note(sink, now, Device::Plan, remark);
        }
        let dropped = self.rig.dropped() + device.in_process().map_or(0, |here| here.dropped());
        let Some(faults) = &mut self.faults else { return (Vec::new(), dropped) };
        let machine = device.machine();
        (faults.finish(now, &mut self.rig, &mut self.director, machine, sink), dropped)
    }
}
