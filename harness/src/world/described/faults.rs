//! Faults of the line to a device of the user's own: what the schedule says is done to it.

use super::link::{DeviceLink, node};
use crate::engine::PhaseEvent;
use crate::faults::{Change, FaultEvent, FaultRecord, FaultSummary, Injector, Schedule};
use crate::link::Chance;
use crate::record::sink::RecordSink;
use crate::record::{Device, Record, RecordKind};
use wire::time::Timestamp;

/// The faults of a run; one without any has none of this.
#[derive(Debug)]
pub(in crate::world) struct LinkFaults {
    injector: Injector,
    seed: u64,
    acted: Vec<u64>,
    /// The last that began: changes of error states are put down to it.
    last: usize,
}

impl LinkFaults {
    /// The faults of `schedule` in the run with `seed`, which begins at zero; none where there are none.
    pub(in crate::world) fn of(schedule: &Schedule, seed: u64) -> Option<Self> {
        (!schedule.is_empty()).then(|| Self {
            injector: Injector::new(schedule, seed, Timestamp::ZERO),
            seed,
            acted: vec![0; schedule.faults.len()],
            last: 0,
        })
    }

    pub(in crate::world) const fn next_due(&self) -> Timestamp {
        self.injector.next_due()
    }

    pub(in crate::world) fn phase(&mut self, now: Timestamp, event: &PhaseEvent) {
        self.injector.phase(now, event);
    }

    /// What is due begins and ends.
    pub(in crate::world) fn strike(
        &mut self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) {
        while let Some(change) = self.injector.change(now) {
            match change {
                Change::Begins(index) => {
                    self.tell(now, sink, index, FaultEvent::Began);
                    self.last = index;
                    let (fault, seed) = (self.injector.fault(index), self.seed);
                    let chance = |way: &str| Chance::new(seed, &format!("{index} {way}"));
                    link.begin_fault(now, index, &fault.what, fault.toward, chance);
                }
                Change::Ends(index) => self.over(now, index, link, sink),
            }
        }
    }

    /// Records what became of the nodes of the bus.
    pub(in crate::world) fn record_confinement(
        &self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) {
        while let Some(change) = link.state_change() {
            let event = FaultEvent::Confinement {
                node: node(change.node).to_owned(),
                state: change.state.name().to_owned(),
                tec: change.counters.tec,
                rec: change.counters.rec,
            };
            self.tell(now, sink, self.last, event);
        }
    }

    /// The run is over: whatever goes on ends, and what never began is told.
    pub(in crate::world) fn finish(
        &mut self,
        now: Timestamp,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) -> Vec<FaultSummary> {
        for index in self.injector.still_on() {
            self.over(now, index, link, sink);
        }
        for (index, why) in self.injector.never_begun() {
            self.tell(now, sink, index, FaultEvent::NeverHappened { why: why.to_owned() });
        }
        self.injector.summaries(&self.acted)
    }

    fn over(
        &mut self,
        now: Timestamp,
        index: usize,
        link: &mut DeviceLink,
        sink: &mut impl RecordSink,
    ) {
        let acted = link.end_fault(now, index);
        self.acted[index] = acted;
        self.tell(now, sink, index, FaultEvent::Ended { acted });
    }

    fn tell(&self, at: Timestamp, sink: &mut impl RecordSink, index: usize, event: FaultEvent) {
        let name = self.injector.fault(index).to_string();
        let record = FaultRecord { index: index as u32, name, event };
        let kind = RecordKind::Fault(Box::new(record));
        sink.record(Record { at, device: Device::Device, kind });
    }
}
