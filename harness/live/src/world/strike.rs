//! Injects faults in real time: the same schedule, lines and switches as in virtual time, timed by the real clock.

use super::LiveWorld;
use super::clock::Clock;
use super::device_under_test::Running;
use super::journal::note;
use super::losses::Losses;
use super::programs::Programs;
use judge::properties::Seen;
use record::{Device, FaultSummary};
use rig::Sink;
use rig::node::Part;
use wire::time::Timestamp;

impl LiveWorld {
    pub(super) fn see(&mut self, now: Timestamp, seen: &Seen<'_>) {
        if let Some(eyes) = &mut self.eyes {
            eyes.see(now, seen);
        }
    }

    /// Begins and ends the faults that are due.
    pub(super) fn strike(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        device: &mut Running,
        clock: &Clock,
    ) {
        let Some(faults) = self.faults.as_mut().filter(|faults| faults.next_due() <= now) else {
            return;
        };
        // Earlier events happen first.
        let engine = &mut self.director.engine;
        self.rig.wake_emulated(now, |_| {}, |woken| engine.woken(now, woken));
        let machine = device.machine();
        if faults.strike(now, (&mut self.rig, &mut self.director, machine), sink) {
            device.struck(clock, now);
            let seen = faults.seen();
            self.see(now, &seen);
        }
    }

    /// Does to the programs what has become of their supplies.
    pub(super) fn switch(&mut self, now: Timestamp, programs: &mut Programs) {
        for node in &mut self.rig.nodes {
            let Part::Process(wanted) = &mut node.part else { continue };
            let Some(on) = wanted.take() else { continue };
            if let Err(why) = programs.switch(&node.name, on) {
                self.director.engine.broke(now, &why.to_string());
            }
        }
    }

    /// Records changed error states of the bus nodes.
    pub(super) fn watch_confinement(&mut self, now: Timestamp, sink: Sink<'_>) {
        let Some(faults) = &self.faults else { return };
        if faults.record_confinement(now, &mut self.rig, sink, |_| {}) {
            self.see(now, &Seen::BusOff);
        }
    }

    /// Records the counts that no measurement covers, and returns them.
    pub(super) fn end_notes(&self, now: Timestamp, sink: Sink<'_>, losses: &Losses) -> Vec<String> {
        let mut notes = self.rig.remarks();
        notes.extend_from_slice(&losses.notes);
        for text in &notes {
            note(sink, now, Device::Plan, text.clone());
        }
        notes
    }

    /// Ends the run: records the faults that are left, and returns the totals.
    pub(super) fn end_faults(
        &mut self,
        now: Timestamp,
        sink: Sink<'_>,
        device: &mut Running,
    ) -> (Vec<FaultSummary>, u64) {
        let dropped = self.rig.dropped() + device.in_process().map_or(0, |here| here.dropped());
        let Some(faults) = &mut self.faults else { return (Vec::new(), dropped) };
        let machine = device.machine();
        (faults.finish(now, (&mut self.rig, &mut self.director, machine), sink), dropped)
    }
}
