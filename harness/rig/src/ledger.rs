//! Records what happens to the faults of a schedule, and sums it up at the end of a run.

use super::injector::{Change, Injector};
use crate::link::StateChange;
use plan::faults::Schedule;
use record::sink::RecordSink;
use record::{Device, FaultEvent, FaultRecord, FaultSummary, Record, RecordKind};
use wire::time::Timestamp;

/// The schedule of a run, and the count of each fault. The owner of the targets takes each [`change`](Self::change),
/// makes it, and reports when a fault is [`over`](Self::over).
#[derive(Debug, Clone)]
pub(crate) struct Ledger {
    pub injector: Injector,
    /// How often each fault has acted, once it is over.
    acted: Vec<u64>,
}

impl Ledger {
    /// The ledger of the run with `seed`, which begins at zero; `None` if the schedule is empty.
    pub fn of(schedule: &Schedule, seed: u64) -> Option<Self> {
        (!schedule.is_empty()).then(|| Self {
            injector: Injector::new(schedule, seed, Timestamp::ZERO),
            acted: vec![0; schedule.faults.len()],
        })
    }

    /// Returns the next change due by `now`, and records it if a fault begins.
    pub fn change(&mut self, now: Timestamp, sink: &mut dyn RecordSink) -> Option<Change> {
        let change = self.injector.change(now);
        if let Some(Change::Begins(index)) = change {
            self.tell(now, sink, index, FaultEvent::Began);
        }
        change
    }

    /// Counts the acts of an instantaneous fault.
    pub fn acted(&mut self, index: usize, acted: u64) {
        self.acted[index] = acted;
    }

    /// Counts the acts of a fault that is over, and records its end.
    pub fn over(&mut self, now: Timestamp, sink: &mut dyn RecordSink, index: usize, acted: u64) {
        self.acted[index] = acted;
        self.tell(now, sink, index, FaultEvent::Ended { acted });
    }

    /// Records the new error state of a bus node, attributed to the fault at `index`.
    pub fn confinement(
        &self,
        now: Timestamp,
        sink: &mut dyn RecordSink,
        index: usize,
        (node, change): (&str, &StateChange),
    ) {
        let event = FaultEvent::Confinement {
            node: node.to_owned(),
            state: change.state.name().to_owned(),
            tec: change.counters.tec,
            rec: change.counters.rec,
        };
        self.tell(now, sink, index, event);
    }

    /// Records the faults that never began, and returns the summary of each.
    pub fn close(&self, now: Timestamp, sink: &mut dyn RecordSink) -> Vec<FaultSummary> {
        for (index, why) in self.injector.never_begun() {
            self.tell(now, sink, index, FaultEvent::NeverHappened { why: why.to_owned() });
        }
        self.injector.summaries(&self.acted)
    }

    fn tell(&self, at: Timestamp, sink: &mut dyn RecordSink, index: usize, event: FaultEvent) {
        let fault = self.injector.fault(index);
        let record = FaultRecord { index: index as u32, name: fault.to_string(), event };
        let kind = RecordKind::Fault(Box::new(record));
        sink.record(Record { at, device: Device::from(fault.target), kind });
    }
}
